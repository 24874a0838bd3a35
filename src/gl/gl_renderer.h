#pragma once

#include <array>

#include "march/marcher.h"

namespace psivox {

/// The march on the GPU: one GL context, the atlas of one view, and the programs built so far. It
/// may be made on one thread and used on another.
class GlRenderer : public Marcher {
 public:
  /// Throws Error(graphics): no EGL device, no 4.5 core context.
  explicit GlRenderer(const ContextOptions& options = {});
  ~GlRenderer() override;

  std::string description() const override;
  bool rounds() const override { return true; }
  bool draws_in_place() const override;

  /// Copies the atlas to the GPU. Throws Error(graphics).
  void upload(const MediumAtlas& atlas, Filter filter = Filter::exact) override;
  LightDepths light_depths(const View& view) override;
  LatticeColumns light_columns(const LatticeFrame& frame, const View& view,
                               const Beam& beam) override;
  RenderResult render(const View& view, const RenderOptions& options = {}) override;
  void release() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace psivox

namespace psivox::gl {

/// How many OpenGL objects there are: textures, buffers, framebuffers, vertex arrays, queries,
/// programs and shaders. After the same work they are the same, unless one is leaked.
using ObjectCounts = std::array<int, 7>;

/// Counts the objects of the current context, whoever made them.
ObjectCounts count_objects();

/// From now on, KHR_debug appends what it says of faults in the current context, which must be a
/// debug context.
void collect_faults(std::vector<std::string>& faults);

/// Where the system has no driver of EGL, a bundle's own software renderer stands in: the folder
/// `mesa` beside libpsivox (tools/make-bundle.sh). To be called before a context is made.
void find_bundled_driver();

}  // namespace psivox::gl
