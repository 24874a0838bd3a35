#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/marcher.h"
#include "psivox/medium.h"
#include "psivox/team.h"

// Draws pictures. A Session holds one medium, a Marcher draws it, and a Wish describes the picture:
//   Session session(scene);
//   const auto gpu = open_gpu();
//   write_image(session.draw(*gpu).image, "picture.exr");

namespace psivox {

struct MediumAtlas;
enum class CodeWidth : std::uint8_t;

/// Why the light of a view takes more than the memory for its grids, in one line; empty: it does
/// not, or the density's values stay in the file, and how much of it is visible is not known.
std::string light_obstacle(const View& view);

/// Lets another thread use the marcher. The thread that has used it calls this.
void release(Marcher& marcher);

/// GL_RENDERER and GL_VERSION, or the name of a CPU marcher.
std::string description(const Marcher& marcher);

// --- a picture -----------------------------------------------------------------------------------

enum class Stage { lighting, uploading, choosing, marching, checking };

/// "lighting".
const char* stage_text(Stage stage);

/// Called with the finished fraction of a stage, 0 to 1; with 0 only, if the fraction is unknown.
/// It may throw to end the work; the session stays usable.
using StageProgress = std::function<void(Stage stage, double fraction)>;

/// One bar for all stages of a picture: light takes the first half, where it is computed, the march
/// the rest.
StageProgress over_stages(Progress bar);

/// Layers beside the picture, named as in --aov. The reference gives `transmittance`, `error` (its
/// own bound) and, for maxima and surfaces, `depth`.
struct Layers {
  bool depth = false;  ///< where the transmittance falls below 1/2 [world units]
  bool transmittance = false;
  bool steps = false;    ///< segments of a pixel's rays
  bool samples = false;  ///< field look-ups of a pixel's rays
  bool error = false;    ///< estimated RMS error of each pixel over R G B A
  bool bound = false;    ///< upper bound on the error of each pixel's worst channel
  /// Image::deep in place of layers: transmittance and radiance in front of every depth are within
  /// the scene's tolerance, or the default one. The picture is what it adds up to.
  bool deep = false;
  bool has(std::string_view name) const;
};

/// `depth`, `transmittance`, ...
const std::vector<std::string>& layer_names();

/// Layers by their names; others are ignored.
Layers layers_of(const std::vector<std::string>& names);

/// Why the scene's picture cannot have the layer of that name; empty if it can.
std::string layer_obstacle(const std::string& layer, const Scene& scene);

/// A description of the wanted picture. The default is the session's own scene.
struct Wish {
  /// The scene to draw; unset: the session's. Its medium must be the session's; its camera, method,
  /// tolerance, filter, texel type and picture may differ. If it leaves the method open, the
  /// default tolerance chooses it.
  std::optional<Scene> scene{};
  /// March as exactly as possible, whatever the scene's method; only arithmetic error remains.
  bool exact = false;
  /// The plan of an earlier picture of the same scene.
  std::optional<MarchPlan> plan{};
  /// Resolution of the same frame, in place of the scene's (for previews).
  std::optional<glm::ivec2> resolution{};
  Layers layers{};
  /// Any light will do that was computed before, or else a coarse one (for previews). If not set,
  /// the light is as exact as the tolerance asks, or exact if there is none.
  bool any_light = false;
  /// Codes wherever they save bytes, and not only where a picture's march pays for choosing them.
  bool fewest_bytes = false;
  bool count = false;   ///< count segments and look-ups in the stats
  bool confirm = true;  ///< estimate the error from the pilot's rays as the device draws them
  StageProgress progress{};
  /// Draw together with other processes, which have the same wish for the same volume. The first
  /// has the picture; the others' are empty.
  std::shared_ptr<Team> team = alone();
  std::function<void(const DoneTile&)> tile{};  ///< the GPU's march calls it before `progress`
  double tile_ms = 1000;  ///< the GPU's target for a tile; work can end between tiles
  /// Whether the table of a transfer function may be updated from another function's instead of
  /// computed anew. An update is faster and differs by rounding only.
  bool may_update_tables = false;
};

/// Times of the work before a picture's march [ms]; 0 for work that an earlier picture did.
struct PreparationTimes {
  double atlas_ms = 0, light_ms = 0, plan_ms = 0;
  double light_cpu_ms = 0, plan_cpu_ms = 0;  ///< processor time of the whole process
};

/// How a picture's light was computed.
struct DrawnLight {
  std::string method;  ///< "columns 1 voxel apart"
  int beams = 0;       ///< directions that light comes from
  double rms = 0;      ///< estimated error, RMS over the picture and R G B A; 0: exact
  double max = 0;      ///< of one channel of a ray, among some hundred rays
};

struct Drawn {
  Image image;  ///< the picture, then the layers that were asked for
  /// The view drawn: its scene has a tolerance if that chose the method, its medium the light.
  View view;
  std::optional<MarchPlan> plan;         ///< set if the method was chosen
  std::optional<Comparison> difference;  ///< from the exact picture; set with layer `error`
  std::optional<double> bound;           ///< the greatest; set with layer `bound`
  std::optional<DrawnLight> light;       ///< set if light shines on the medium
  RenderStats stats;
  PreparationTimes times;
  AtlasSize atlas;                   ///< of all grids together; 0 for the reference
  std::vector<std::string> notices;  ///< one line each: what was not possible
};

/// Why a picture of the view shows nothing on a display, as a sentence for the user: it differs
/// from the background in no pixel. Empty if it shows something.
std::string blank_reason(const View& view, const Image& image);

/// A medium with everything that its pictures share: atlases and light. The session computes each
/// when a picture first needs it, and keeps it. The marcher that draws first computes the light;
/// the others use its result.
class Session {
 public:
  /// Reads the scene's grids. If the scene leaves the method open, the default tolerance chooses
  /// it. Throws Error(input), Error(usage), Error(memory).
  explicit Session(const Scene& scene);
  /// `for_one_picture`: of a file's medium. The values of its fields go as bricks are made of them.
  /// What asks for them later reads the file again and computes the light anew.
  explicit Session(View view, bool for_one_picture = false);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  /// The view that it was given or has made, without light. A session for one picture keeps no
  /// values in it.
  const View& view() const;

  /// Converts the grids to bricks, unless that is done, or the volume
  /// must be drawn in parts because of its memory limit. Throws Error(memory).
  void convert();

  /// Converts, lights and uploads: all that `draw` does before it chooses a method and marches.
  void prepare(Marcher& marcher, const Wish& wish = {});

  /// What the device has of the grids by a scene's method and texel type, or with a plan's codes,
  /// with their light once that is computed. It stays until the next call. Throws Error(memory) if
  /// the volume must be drawn in parts.
  const MediumAtlas& atlas(const Scene& scene,
                           const std::shared_ptr<const std::vector<CodeWidth>>& codes = {});

  /// Draws. Throws Error(graphics), Error(memory), and what the wish's progress throws.
  Drawn draw(Marcher& marcher, const Wish& wish = {});

  /// Lists what the march of the session's scene computes, what it skips because the picture does
  /// not depend on it, and why. It computes no light, so a method that depends on the light stays
  /// open.
  std::vector<Explanation> explain();

  /// Compares about `pixels` pixels of a picture that the session has drawn with the reference, in
  /// exact light. It takes one random pixel from each cell of a grid over the picture, the same
  /// ones every time.
  CheckedError check_error(const Drawn& drawn, int pixels, const StageProgress& progress = {});

  /// The point at which the ray through `pixel` of the scene's picture [pixels; centres at +0.5]
  /// meets the part of the medium that hides the rest; unset: there is none.
  std::optional<glm::dvec3> pick(const Scene& scene, const glm::dvec2& pixel);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace psivox
