#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "psivox/image.h"
#include "psivox/light.h"
#include "psivox/medium_atlas.h"
#include "psivox/progress.h"

namespace psivox {

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

/// A part of a picture that is done, from the top left pixel.
struct DoneTile {
  int x = 0, y = 0, width = 0, height = 0;
  const float* picture = nullptr;  ///< R G B A of the whole picture, row-major, done so far
};

struct RenderOptions {
  bool count = false;  ///< count segments and look-ups: layers `steps` and `samples`, and the stats
  bool depth = false;  ///< layer `depth`
  bool transmittance = false;  ///< layer `transmittance`
  Progress progress{};
  std::function<void(const DoneTile&)> tile{};  ///< GlRenderer's: called before `progress`
  /// Time that GlRenderer aims at for a tile, between which `progress` may throw to end the work.
  double tile_ms = 1000;
  /// The table of a transfer function may be updated from that of another one instead of computed
  /// anew: sooner there, but for rounding the same.
  bool may_update_tables = false;
};

struct RenderStats {
  std::string renderer;  ///< GL_RENDERER and GL_VERSION, or what else made the picture
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;  ///< field look-ups, with RenderOptions::count
  std::uint64_t steps = 0;    ///< segments, likewise
  int passes = 0;             ///< most passes that a tile needed
  double gl_init_ms = 0, shader_ms = 0, upload_ms = 0, march_ms = 0;
  /// Of march_ms: what the GPU took for the draws by its own timer (0 where it has none), and the
  /// processor time of the whole process, which other processes disturb least.
  double gpu_ms = 0, cpu_ms = 0;
};

struct RenderResult {
  Image image;
  RenderStats stats;
};

struct ContextOptions {
  int device = -1;     ///< index of list_devices, -1: the first that works, hardware first
  bool debug = false;  ///< KHR_debug: a message of high or medium severity becomes Error(graphics)
};

/// The march on the GPU: one GL context, the atlases of one view, and its shader. It may be made on
/// one thread, which takes as long as reading a small file, and then be used on another.
class GlRenderer {
 public:
  /// Throws Error(graphics): no EGL device, no 4.5 core context.
  explicit GlRenderer(const ContextOptions& options = {});
  ~GlRenderer();
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  /// GL_RENDERER and GL_VERSION.
  std::string description() const;

  /// Copies the atlases, which must stay until the last render, to the GPU. With Filter::hardware a
  /// later render must ask for that filter too, and vice versa.
  void upload(const MediumAtlas& atlas, Filter filter = Filter::exact);

  /// Optical depths towards the light of a view whose density is uploaded, with exact filtering:
  /// for lit() (light.h), before the next upload. Throws Error(graphics).
  LightDepths light_depths(const View& view);

  /// Draws the view's picture from the uploaded atlases, which must be its own.
  RenderResult render(const View& view, const RenderOptions& options = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same march, from the same source, in double precision on the CPU: what differs from
/// GlRenderer's picture is arithmetic error, what differs from the reference is step error.
RenderResult render_march_double(const View& view, const MediumAtlas& atlas,
                                 const RenderOptions& options = {});

}  // namespace psivox
