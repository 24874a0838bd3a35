#pragma once

#include <memory>
#include <optional>

#include "gl/egl_context.h"
#include "gl/march_program.h"
#include "gl/tiles.h"
#include "march/marcher.h"

namespace psivox::gl {

struct Exposure;
class Readback;
class Timer;

/// march.frag over the pixels of a view whose rays may meet its domain, tile by tile. Its
/// parameters, tables and grids are set and bound already, and stay so. Needs a current context for
/// its whole life.
class PicturePass {
 public:
  /// Has a software driver compile the program, by a first draw. `domain` is the density's
  /// [voxels], `passes` what a ray may need at most.
  PicturePass(const EglContext& context, const MarchProgram& march, const View& view,
              const Box& domain, const RenderOptions& options, int passes);

  /// Sets passes, gpu_ms and what the film counts of `stats`.
  Image draw(RenderStats& stats);

 private:
  void draw_tile(const PixelBox& tile, Readback& readback, Timer& timer, RenderStats& stats);
  /// Draws an exposure in as many passes as its rays need; returns their number.
  int draw_passes(const Exposure& tile, const Readback& readback, Timer& timer);
  void make_target(int side);

  const EglContext& context_;
  const MarchProgram& march_;
  const View& view_;
  const RenderOptions& options_;
  PixelBox picture_;  ///< what is to be drawn
  /// All of it whose rays may meet the domain, and a row or column of others, if there are any.
  PixelBox drawn_;
  std::optional<glm::ivec2> missed_;  ///< a pixel whose ray does not: all these draw the same
  std::vector<PixelBox> beside_;      ///< the rest
  int largest_;                       ///< side of the largest tile
  EachPixel pixels_;
  std::unique_ptr<TileTarget> target_;  ///< of the largest tile so far
};

}  // namespace psivox::gl
