#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "psivox/atlas.h"
#include "psivox/image.h"
#include "psivox/medium.h"
#include "psivox/method.h"
#include "psivox/progress.h"
#include "psivox/team.h"

// Draws pictures. A Session holds one medium, a Marcher draws it, and a Wish describes the picture:
//   Session session(scene);
//   const auto gpu = open_gpu();
//   write_image(session.draw(*gpu).image, "picture.exr");

namespace psivox {

// --- marchers ------------------------------------------------------------------------------------

/// One EGL device, as --list-devices prints it.
struct DeviceInfo {
  int index = 0;
  std::string renderer;  ///< GL_RENDERER, or empty where no 4.5 core context could be made
  std::string version;   ///< GL_VERSION
  std::string problem;   ///< why it cannot be used, in one line
  bool software = false;
};

/// Returns an empty list on a machine without EGL; does not throw.
std::vector<DeviceInfo> list_devices();

struct ContextOptions {
  int device = -1;     ///< index of list_devices, -1: the first that works, hardware first
  bool debug = false;  ///< KHR_debug: a message of high or medium severity becomes Error(graphics)
};

/// Draws rays: on the GPU, in double precision on the CPU, or by the reference. A marcher keeps
/// what it needs between pictures and sessions (a context, programs, textures). Any thread may use
/// it, but only one at a time; see release().
class Marcher;

/// The march on the GPU. Opening it takes as long as reading a small file, so it may be done on
/// another thread. Throws Error(graphics): no EGL device, no 4.5 core context.
std::shared_ptr<Marcher> open_gpu(const ContextOptions& options = {});

/// The same march, from the same source, in double precision on the CPU. Its picture differs from
/// the GPU's by arithmetic error, and from the reference's by step error.
std::shared_ptr<Marcher> open_double();

/// The reference: another algorithm, in double precision on the CPU. It integrates each cell to a
/// relative accuracy of 1e-12 and reads the grids themselves, not the atlas.
std::shared_ptr<Marcher> open_reference();

/// The marcher that the scene asks for (--renderer, --device).
std::shared_ptr<Marcher> open_marcher(const Scene& scene);

/// Why the light of a view takes more than the memory for its grids, in one line; empty: it does
/// not. Of a density whose values stay in the file it is not known.
std::string light_obstacle(const View& view);

/// Lets another thread use the marcher. The thread that has used it calls this.
void release(Marcher& marcher);

/// GL_RENDERER and GL_VERSION, or the name of a CPU marcher.
std::string description(const Marcher& marcher);

// --- the method of the march ---------------------------------------------------------------------

/// A method that was tried on a few hundred of the picture's rays, the pilot, or on some of them if
/// these told enough. Errors are of radiance and alpha, over R G B A.
struct Trial {
  Method method;
  double worst_brick = 0;  ///< under uniform: largest error bound of a brick [tolerances]
  int rays = 0;            ///< of the pilot, that it marched
  double rms = 0;          ///< over these rays
  double max = 0;          ///< of one ray
  double samples = 0;      ///< field look-ups per ray
  double cost = 0;  ///< expected time of a ray [look-ups of psi-balanced between uniform samples]
  bool accepted = false;  ///< its error is small enough on these rays
};

/// A plan's march and its pilot, which only a session reads.
struct PlannedMarch;

/// How to march a picture within the wanted error or time.
struct MarchPlan {
  Trial chosen;                 ///< rms and max estimate the picture's error
  std::vector<Trial> trials{};  ///< all that were tried
  bool reached = true;          ///< whether the estimate is within the tolerance
  int rays = 0;                 ///< of the pilot; 0 if nothing had to be tried
  std::uint64_t samples = 0;    ///< field look-ups of the pilot, for all trials together
  bool by_brick = false;        ///< some bricks have a smaller step than the rest
  double light_rms = 0;         ///< part of chosen.rms: what the light at voxels misses
  double light_max = 0;         ///< part of chosen.max: the same, on one ray
  std::shared_ptr<const PlannedMarch> march{};
};

// --- a picture -----------------------------------------------------------------------------------

enum class Stage { converting, lighting, uploading, choosing, marching, checking };

/// "lighting".
const char* stage_text(Stage stage);

/// Called with the finished fraction of a stage, 0 to 1; with 0 only, if the fraction is unknown.
/// It may throw to end the work; the session stays usable.
using StageProgress = std::function<void(Stage stage, double fraction)>;

/// One bar for all stages of a picture: light takes the first half of a lit one, the march the
/// rest.
StageProgress over_stages(Progress bar, bool lit);

/// A finished part of a picture; x and y count from the top left pixel.
struct DoneTile {
  int x = 0, y = 0, width = 0, height = 0;
  const float* picture = nullptr;  ///< R G B A of the whole picture, row-major, done so far
};

/// Layers beside the picture, named as in --aov. The reference gives `transmittance`, `error` (its
/// own bound) and, for maxima and surfaces, `depth`.
struct Layers {
  bool depth = false;  ///< where the transmittance falls below 1/2 [world units]
  bool transmittance = false;
  bool steps = false;    ///< segments of a pixel's rays
  bool samples = false;  ///< field look-ups of a pixel's rays
  bool error = false;    ///< estimated RMS error of each pixel over R G B A
  bool any() const { return depth || transmittance || steps || samples || error; }
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
  /// Time for the march [ms], in place of a tolerance. It chooses the most accurate method that
  /// fits.
  std::optional<double> time_budget_ms{};
  /// A plan that Session::plan made for the same scene.
  std::optional<MarchPlan> plan{};
  /// Resolution of the same frame, in place of the scene's (for previews).
  std::optional<glm::ivec2> resolution{};
  Layers layers{};
  /// Any light will do that was computed before, or else a coarse one (for previews). If not set,
  /// the light is as exact as the tolerance asks, or exact if there is none.
  bool any_light = false;
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

/// The cost of a march.
struct RenderStats {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION, or the name of a CPU marcher
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;  ///< field look-ups, where they were counted
  std::uint64_t steps = 0;    ///< segments, where they were counted
  std::uint64_t cells = 0;    ///< reference only: cells crossed with a corner that is not 0
  std::uint64_t stuck = 0;    ///< rays that stood still before their end: a fault, see verify
  int passes = 0;             ///< most passes that a tile needed
  double gl_init_ms = 0, shader_ms = 0, upload_ms = 0, march_ms = 0;
  /// Within march_ms: the GPU's time for the draws by its own timer (0 if it has none), and the
  /// processor time of the whole process, which other processes disturb least.
  double gpu_ms = 0, cpu_ms = 0;
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
  Image image;                    ///< the picture, then the layers that were asked for
  Scene scene;                    ///< the scene drawn, with a tolerance if that chose the method
  std::optional<MarchPlan> plan;  ///< set if the method was chosen
  std::optional<Comparison> difference;  ///< from the exact picture; set with layer `error`
  std::optional<DrawnLight> light;       ///< set if light shines on the medium
  RenderStats stats;
  PreparationTimes times;
  AtlasSize atlas;                   ///< of all grids together; 0 for the reference
  std::vector<std::string> notices;  ///< one line each: what was not possible
};

/// Errors of some pixels of a picture.
struct CheckedError {
  int pixels = 0;
  double rms = 0;  ///< over R G B A
  double max = 0;  ///< of one channel
  int max_x = 0, max_y = 0;
};

/// One thing that a march computes or skips, and why.
struct Explanation {
  std::string what;  ///< "luminance"
  std::string text;
};

/// A medium with everything that its pictures share: atlases and light. The session computes each
/// when a picture first needs it, and keeps it. The marcher that draws first computes the light;
/// the others use its result.
class Session {
 public:
  /// Reads the scene's grids. If the scene leaves the method open, the default tolerance chooses
  /// it. Throws Error(input), Error(usage), Error(memory).
  explicit Session(const Scene& scene);
  explicit Session(View view);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  /// The view as drawn, with its light once that is computed.
  const View& view() const;

  /// Converts the grids to bricks of the scene's texel type, unless that is done, or the volume
  /// must be drawn in parts because of its memory limit. Throws
  /// Error(memory), and Error(input) if the values do not fit the type.
  void convert();

  /// Converts, lights and uploads: all that `draw` does before it chooses a method and marches.
  void prepare(Marcher& marcher, const Wish& wish = {});

  /// Chooses the method for the tolerance of the wish's scene, or for the wish's time budget.
  MarchPlan plan(Marcher& marcher, const Wish& wish);

  /// Draws. Throws Error(graphics), Error(memory), and what the wish's progress throws.
  Drawn draw(Marcher& marcher, const Wish& wish = {});

  /// Lists what the march of the session's scene computes, what it skips because the picture does
  /// not depend on it, and why. It computes no light, so a method that depends on the light stays
  /// open.
  std::vector<Explanation> explain();

  /// Compares about `pixels` pixels of a picture of the session's scene with the reference, in
  /// exact light. It
  /// takes one random pixel from each cell of a grid over the picture, the same ones every time.
  CheckedError check_error(const Image& picture, int pixels, const Progress& progress = {});

  /// The point at which the ray through `pixel` of the scene's picture [pixels; centres at +0.5]
  /// meets the part of the medium that hides the rest; unset: there is none.
  std::optional<glm::dvec3> pick(const Scene& scene, const glm::dvec2& pixel);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace psivox
