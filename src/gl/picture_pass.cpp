#include "gl/picture_pass.h"

#include <algorithm>

#include "psivox/stopwatch.h"

namespace psivox::gl {
namespace {

/// Side of the next tile from the time that the last one took: no draw runs for minutes, and few
/// draws wait for each other.
int next_side(int side, double tile_ms, double wanted_ms) {
  constexpr int smallest = 16, largest = 1024;
  if (tile_ms > 2 * wanted_ms) return std::max(side / 2, smallest);
  if (tile_ms < 0.4 * wanted_ms) return std::min(side * 2, largest);
  return side;
}

}  // namespace

PicturePass::PicturePass(const EglContext& context, const MarchProgram& march, const View& view,
                         const RenderOptions& options)
    : context_(context), march_(march), view_(view), options_(options) {
  make_target(march.key().resumable || options.tile_ms < 100 ? 64 : 512);
  // Drivers compile at the first draw: one pixel, so that the march's time is the march's.
  target_->bind(0);
  march.program().set("first_pass", 1);
  triangle_.draw(march.program(), 1, 1);
  glFinish();
  context.check("compiling the march's shader");
}

void PicturePass::make_target(int side) {
  const bool layers = options_.count || options_.depth || options_.transmittance;
  target_ = std::make_unique<TileTarget>(side, march_.key().resumable, layers);
}

Image PicturePass::draw(RenderStats& stats) {
  Timer timer(context_.renderer());
  Film film(view_, options_);
  Readback readback(film, view_, options_);
  const int rows = view_.scene.resolution.y;
  for (int y = 0; y < rows;) {
    // A row of tiles keeps its height; the side follows the time between rows.
    const int side = target_->side(), height = std::min(side, rows - y);
    const double slowest_ms = draw_row(y, height, readback, timer, stats);
    y += height;
    const int next = next_side(side, slowest_ms, options_.tile_ms);
    if (next != side && y < rows) make_target(next);
  }
  readback.develop();
  stats.gpu_ms = timer.sum_ms();
  return film.finish(stats);
}

double PicturePass::draw_row(int y, int height, Readback& readback, Timer& timer,
                             RenderStats& stats) {
  const int side = target_->side(), columns = view_.scene.resolution.x;
  const int samples = view_.scene.pixel_samples;
  double slowest_ms = 0;
  for (int x = 0; x < columns; x += side) {
    const Stopwatch drawing;
    Exposure tile{x, y, std::min(side, columns - x), height};
    march_.program().set("tile_origin", glm::ivec2(x, y));
    for (; tile.sample < samples; ++tile.sample) {
      march_.program().set("given.sample_offset", pixel_sample(tile.sample, samples));
      const int passes = draw_passes(tile, timer);
      stats.passes = std::max(stats.passes, passes);
      readback.develop();  // the tile before, while this one is drawn
      timer.awaited();
      target_->bind((passes - 1) & 1);
      readback.read(*target_, tile);
      context_.check("marching");
    }
    slowest_ms = std::max(slowest_ms, drawing.ms());
  }
  return slowest_ms;
}

int PicturePass::draw_passes(const Exposure& tile, Timer& timer) {
  int passes = 0;
  do {
    if (passes > 0) timer.awaited();
    target_->bind(passes & 1);
    march_.program().set("first_pass", passes == 0);
    timer.begin();
    triangle_.draw(march_.program(), tile.width, tile.height);
    timer.submitted();
    ++passes;
  } while (march_.key().resumable && !target_->all_done(tile.width, tile.height, (passes - 1) & 1));
  return passes;
}

}  // namespace psivox::gl
