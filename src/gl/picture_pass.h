#pragma once

#include <memory>

#include "gl/egl_context.h"
#include "gl/march_program.h"
#include "gl/readback.h"
#include "gl/tile_order.h"
#include "gl/tile_target.h"
#include "gl/timer.h"
#include "gl/triangle.h"

namespace psivox::gl {

/// march.frag over the pixels of a view, tile by tile. Its parameters, tables and grids are set and
/// bound already, and stay so. Needs a current context for its whole life.
class PicturePass {
 public:
  /// Has the driver compile the program, by a first draw.
  PicturePass(const EglContext& context, const MarchProgram& march, const View& view,
              const RenderOptions& options);

  /// Sets passes, gpu_ms and what the film counts of `stats`.
  Image draw(RenderStats& stats);

 private:
  void draw_tile(const Tile& tile, Readback& readback, Timer& timer, RenderStats& stats);
  /// Draws an exposure in as many passes as its rays need; returns their number.
  int draw_passes(const Exposure& tile, Timer& timer);
  void make_target(int side);

  const EglContext& context_;
  const MarchProgram& march_;
  const View& view_;
  const RenderOptions& options_;
  Triangle triangle_;
  std::unique_ptr<TileTarget> target_;
};

}  // namespace psivox::gl
