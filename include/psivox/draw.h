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

// Where pictures are made. A Session holds one medium, a Marcher draws it, a Wish says what is
// wanted:
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

/// Never throws for a machine without EGL: the list is empty then.
std::vector<DeviceInfo> list_devices();

struct ContextOptions {
  int device = -1;     ///< index of list_devices, -1: the first that works, hardware first
  bool debug = false;  ///< KHR_debug: a message of high or medium severity becomes Error(graphics)
};

/// Draws rays: on the GPU, in double precision on the CPU, or by the reference. A marcher keeps
/// what it needs between pictures and sessions (a context, programs, textures). One thread may use
/// it at a time, not always the same one.
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

/// GL_RENDERER and GL_VERSION, or what else draws.
std::string description(const Marcher& marcher);

// --- the method of the march ---------------------------------------------------------------------

/// A method that was tried on a few hundred of the picture's rays, the pilot. Errors are of
/// radiance and alpha, over R G B A.
struct Trial {
  Method method;
  double worst_brick = 0;  ///< under uniform: what a brick may miss by its bound [tolerances]
  double rms = 0;          ///< over the pilot's rays
  double max = 0;          ///< of one of them
  double samples = 0;      ///< field look-ups a ray
  double cost = 0;  ///< expected time of a ray [look-ups of psi-balanced between uniform samples]
  bool accepted = false;  ///< its error is small enough
};

/// A plan's march and its pilot, which only a session reads.
struct PlannedMarch;

/// How a picture is marched so that its error, or its time, is what was asked for.
struct MarchPlan {
  Trial chosen;                 ///< rms and max estimate the picture's error
  std::vector<Trial> trials{};  ///< all that were tried
  bool reached = true;          ///< whether the estimate is within the tolerance
  int rays = 0;                 ///< of the pilot; 0: nothing had to be tried
  bool by_brick = false;        ///< some bricks have a smaller step than the rest
  std::shared_ptr<const PlannedMarch> march{};
};

// --- a picture -----------------------------------------------------------------------------------

enum class Stage { converting, lighting, uploading, choosing, marching, checking };

/// "lighting".
const char* stage_text(Stage stage);

/// Called with the done fraction of a stage, 0 to 1; 0 alone where it is not known. It may throw to
/// end the work: the session stays usable.
using StageProgress = std::function<void(Stage stage, double fraction)>;

/// A part of a picture that is done, from the top left pixel.
struct DoneTile {
  int x = 0, y = 0, width = 0, height = 0;
  const float* picture = nullptr;  ///< R G B A of the whole picture, row-major, done so far
};

/// Layers beside the picture, under their names of --aov. The reference has `transmittance` and
/// `error` (its own bound), and `depth` of maxima and surfaces.
struct Layers {
  bool depth = false;  ///< where the transmittance falls below 1/2 [world units]
  bool transmittance = false;
  bool steps = false;    ///< segments of a pixel's rays
  bool samples = false;  ///< field look-ups of a pixel's rays
  bool error = false;    ///< estimated RMS error of each pixel over R G B A
  bool any() const { return depth || transmittance || steps || samples || error; }
};

/// What a picture is to be. As it stands it is the session's own scene.
struct Wish {
  /// Its camera, method, tolerance, filter, texel type and picture are drawn; its medium must be
  /// the session's. Where it leaves the method open, the default tolerance chooses. Unset: the
  /// session's scene.
  std::optional<Scene> scene{};
  /// March as exactly as can be, whatever the scene's method: no error but the arithmetic's.
  bool exact = false;
  /// Time for the march [ms], in place of a tolerance: the most accurate method within it.
  std::optional<double> time_budget_ms{};
  /// A plan made before, by Session::plan for the same scene.
  std::optional<MarchPlan> plan{};
  /// Pixels of the same frame, in place of the scene's (previews).
  std::optional<glm::ivec2> resolution{};
  Layers layers{};
  bool count = false;   ///< count segments and look-ups in the stats
  bool confirm = true;  ///< estimate the error from what the device makes of the pilot's rays
  StageProgress progress{};
  std::function<void(const DoneTile&)> tile{};  ///< of the GPU's march: called before `progress`
  double tile_ms = 1000;  ///< time that the GPU aims at for a tile, between which work can end
  /// The table of a transfer function may be updated from that of another one instead of computed
  /// anew: sooner, and but for rounding the same.
  bool may_update_tables = false;
};

/// What a march took.
struct RenderStats {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION, or what else made the picture
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;  ///< field look-ups, where they were counted
  std::uint64_t steps = 0;    ///< segments, likewise
  std::uint64_t cells = 0;    ///< of the reference: cells crossed with a corner that is not 0
  int passes = 0;             ///< most passes that a tile needed
  double gl_init_ms = 0, shader_ms = 0, upload_ms = 0, march_ms = 0;
  /// Of march_ms: what the GPU took for the draws by its own timer (0 where it has none), and the
  /// processor time of the whole process, which other processes disturb least.
  double gpu_ms = 0, cpu_ms = 0;
};

/// What was done before a picture's march [ms]; 0 for what an earlier picture had done.
struct PreparationTimes {
  double atlas_ms = 0, light_ms = 0, plan_ms = 0, plan_cpu_ms = 0;
};

struct Drawn {
  Image image;  ///< the picture, then the layers that were asked for
  Scene scene;  ///< that it was drawn by, with a tolerance if that chose the method
  std::optional<MarchPlan> plan;         ///< where the method was chosen
  std::optional<Comparison> difference;  ///< with layer `error`: from the exact picture
  RenderStats stats;
  PreparationTimes times;
  AtlasSize atlas;                   ///< of all grids together; nothing of the reference
  std::vector<std::string> notices;  ///< one line each: what could not be had
};

/// Errors of some pixels of a picture.
struct CheckedError {
  int pixels = 0;
  double rms = 0;  ///< over R G B A
  double max = 0;  ///< of one channel
  int max_x = 0, max_y = 0;
};

/// One line of what a march computes or leaves out, and why.
struct Explanation {
  std::string what;  ///< "luminance"
  std::string text;
};

/// A medium with all that its pictures have in common: atlases and light. It is computed when a
/// picture first needs it and kept. Light is computed once, by the marcher that draws first; the
/// others draw what it gave.
class Session {
 public:
  /// Reads the scene's grids. Where the scene leaves the method open, the default tolerance
  /// chooses. Throws Error(input), Error(usage), Error(memory).
  explicit Session(const Scene& scene);
  explicit Session(View view);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  /// As it is drawn: with its light once that has been computed.
  const View& view() const;

  /// Converts the grids to bricks of the scene's texel type, if that is not done yet. Throws
  /// Error(memory), and Error(input) where the type does not hold the values.
  void convert();

  /// Does all that `draw` does before it marches and chooses: converts, lights, uploads.
  void prepare(Marcher& marcher, const Wish& wish = {});

  /// Chooses the method of the wish's scene, which has a tolerance, or for the wish's time.
  MarchPlan plan(Marcher& marcher, const Wish& wish);

  /// Draws. Throws Error(graphics), Error(memory), and what the wish's progress throws.
  Drawn draw(Marcher& marcher, const Wish& wish = {});

  /// What the march of the session's scene computes, what it leaves out because the picture does
  /// not depend on it, and why. Computes no light: a method that depends on it is not chosen yet.
  std::vector<Explanation> explain();

  /// Compares about `pixels` of a picture's pixels, one at random in each cell of a grid over it,
  /// with the reference. The same pixels every time. The picture is of the session's scene.
  CheckedError check_error(const Image& picture, int pixels, const Progress& progress = {});

  /// Where the ray through a point of the scene's picture [pixels; centres at +0.5] meets what
  /// hides what lies behind it; unset: nowhere.
  std::optional<glm::dvec3> pick(const Scene& scene, const glm::dvec2& pixel);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace psivox
