#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/scene.h"

// What draws rays, what it costs, and the method by which it marches.

namespace psivox {

/// One EGL device, as --list-devices prints it.
struct DeviceInfo {
  int index = 0;
  std::string renderer;  ///< GL_RENDERER, or empty where no 4.5 core context could be made
  std::string version;   ///< GL_VERSION
  std::string problem;   ///< why it cannot be used, in one line
  bool software = false;
};

/// Whether a GL driver of this GL_RENDERER draws with the processor.
inline bool is_software(std::string_view renderer) {
  return renderer.find("llvmpipe") != std::string_view::npos;
}

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

/// A finished part of a picture; x and y count from the top left pixel.
struct DoneTile {
  int x = 0, y = 0, width = 0, height = 0;
  const float* picture = nullptr;  ///< R G B A of the whole picture, row-major, done so far
};

/// The cost of a march.
struct RenderStats {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION, or the name of a CPU marcher
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;  ///< field look-ups, where they were counted
  std::uint64_t steps = 0;    ///< segments, where they were counted
  std::uint64_t cells = 0;    ///< reference only: cells crossed with a corner that is not 0
  std::uint64_t stuck = 0;    ///< rays that no longer advanced and were ended: a fault, see verify
  int passes = 0;             ///< most passes that a tile needed
  double gl_init_ms = 0, shader_ms = 0, upload_ms = 0, march_ms = 0;
  /// Within march_ms: the GPU's time for the draws by its own timer (0 if it has none), and the
  /// processor time of the whole process, which other processes disturb least.
  double gpu_ms = 0, cpu_ms = 0;
};

/// Errors of some pixels of a picture.
struct CheckedError {
  int pixels = 0;
  double rms = 0;  ///< over R G B A
  double max = 0;  ///< of one channel
  int max_x = 0, max_y = 0;
  double light_ms = 0, reference_ms = 0;  ///< what the exact light and the reference have taken
};

/// One thing that a march computes or skips, and why.
struct Explanation {
  std::string what;  ///< "luminance"
  std::string text;
};

/// A method that was tried on a few hundred of the picture's rays, the pilot, or on some of them if
/// these told enough. Errors are of radiance and alpha, over R G B A.
struct Trial {
  Method method;
  int rays = 0;        ///< of the pilot, that it marched
  double rms = 0;      ///< over these rays
  double max = 0;      ///< of one ray
  double samples = 0;  ///< field look-ups per ray
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
  double light_rms = 0;         ///< part of chosen.rms: what the light at voxels misses
  double light_max = 0;         ///< part of chosen.max: the same, on one ray
  std::shared_ptr<const PlannedMarch> march{};
};

}  // namespace psivox
