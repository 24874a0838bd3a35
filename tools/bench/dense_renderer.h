#pragma once

#include <map>
#include <memory>

#include "gl/egl_context.h"
#include "gl/program.h"
#include "gl/tile_target.h"
#include "march/medium_atlas.h"

namespace psivox::bench {

/// The baseline that psivox is measured against: dense.frag over one dense 3D texture of the domain
/// in float32, drawn as one tile.
class DenseRenderer {
 public:
  DenseRenderer(const Field& field, int side);
  ~DenseRenderer();
  DenseRenderer(const DenseRenderer&) = delete;
  DenseRenderer& operator=(const DenseRenderer&) = delete;

  /// Draws the view and reads it back; returns milliseconds. Luminance is constant or the density
  /// grid.
  double render(const View& view, const MediumAtlas& atlas);

 private:
  gl::EglContext context_;
  gl::TileTarget target_;
  GLuint volume_ = 0, vertex_array_ = 0;
  std::map<std::string, std::unique_ptr<gl::Program>> programs_;
};

}  // namespace psivox::bench
