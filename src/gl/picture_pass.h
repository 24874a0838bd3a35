#pragma once

#include <epoxy/gl.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/egl_context.h"
#include "gl/grid_textures.h"
#include "gl/march_program.h"
#include "gl/tiles.h"
#include "march/marcher.h"

namespace psivox::gl {

class Readback;

/// Sum of the times that the GPU takes for stretches of commands, by GL_TIME_ELAPSED.
class Timer {
 public:
  explicit Timer(const std::string& renderer);
  ~Timer();
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void begin();
  /// What is measured has been handed to the driver, which begins with it now.
  void submitted();
  /// It is waited for next.
  void awaited();
  /// Waits for the commands [ms]; 0 where the driver has no such timer.
  double sum_ms() const;

 private:
  void end();

  /// llvmpipe stores commands, the timer's among them, and runs them tile by tile: the timer's must
  /// not be stored together with the draws.
  bool waits_;
  bool works_ = false;
  bool running_ = false;
  std::vector<GLuint> queries_;
};

/// march.frag over the pixels of a view whose rays may meet its domain, tile by tile. Needs a
/// current context, and what it was given, for its whole life.
class PicturePass {
 public:
  /// Has a software driver compile the program, by a first draw. `setup` is the view's, the program
  /// that of its key, `passes` what a ray may need at most.
  PicturePass(const EglContext& context, const GridTextures& textures, const MarchProgram& march,
              MarchSetup setup, const View& view, const RenderOptions& options, int passes);

  /// Hands the first tile to the driver, which draws it while others prepare more. Until draw(),
  /// other passes may draw.
  void begin();

  /// Draws what is left. Sets passes, gpu_ms and what the film counts of `stats`.
  Image draw(RenderStats& stats);

 private:
  void draw_tile(const PixelBox& tile, Readback& readback, RenderStats& stats);
  /// Draws the sample of a tile in as many passes as its rays need; returns their number.
  int draw_passes(const PixelBox& tile, int sample, const std::function<void()>& report);
  void make_target(int side);

  /// Sets parameters, tables and grids.
  void bind() const;

  const EglContext& context_;
  const GridTextures& textures_;
  const MarchProgram& march_;
  MarchSetup setup_;
  Tables tables_;
  const View& view_;
  const RenderOptions& options_;
  PixelBox picture_;  ///< what is to be drawn
  /// All of it whose rays may meet the domain, and a row or column of others, if there are any.
  PixelBox drawn_;
  std::optional<glm::ivec2> missed_;  ///< a pixel whose ray does not: all these draw the same
  std::vector<PixelBox> beside_;      ///< the rest
  int largest_;                       ///< side of the largest tile
  EachPixel pixels_;
  Timer timer_;
  std::unique_ptr<TileTarget> target_;  ///< of the largest tile so far
  TileOrder order_;
  PixelBox first_{};  ///< the tile that begin() took
  int passes_ = 0;    ///< in which it was drawn; 0: it was not
};

}  // namespace psivox::gl
