#include "gl/picture_pass.h"

#include <algorithm>
#include <utility>

#include "psivox/stopwatch.h"

namespace psivox::gl {
namespace {

constexpr int smallest_side = 16, largest_side = 1024;

/// Side of the next tile from the time that the last one took: no draw runs for minutes, and few
/// draws wait for each other.
int next_side(int side, const PixelBox& tile, double tile_ms, double wanted_ms) {
  if (tile_ms > 2 * wanted_ms) return std::max(side / 2, smallest_side);
  const double part = double(tile.size.x) * double(tile.size.y) / (double(side) * double(side));
  if (tile_ms < 0.4 * part * wanted_ms) return std::min(side * 2, largest_side);
  return side;
}

}  // namespace

PicturePass::PicturePass(const EglContext& context, const MarchProgram& march, const View& view,
                         const Box& domain, const RenderOptions& options)
    : context_(context),
      march_(march),
      view_(view),
      options_(options),
      picture_(options.pixels.value_or(PixelBox{{}, view.scene.resolution})),
      drawn_(common(picture_, pixels_of(view, glm::dvec3(domain.min), glm::dvec3(domain.max)))),
      beside_(around(drawn_, picture_)) {
  make_target(march.key().resumable || options.tile_ms < 100 ? 64 : 512);
  // Drivers compile at the first draw: one pixel, so that the march's time is the march's. It is
  // one that misses the domain, if any does, since all these draw the same.
  target_->bind(0);
  march.program().set("first_pass", 1);
  march.program().set("tile_origin", beside_.empty() ? drawn_.origin : beside_[0].origin);
  triangle_.draw(march.program(), 1, 1);
  target_->read_picture(1, 1, &missed_.picture, 1);
  if (has_layers()) target_->read_layers(1, 1, &missed_.layers, 1);
  context.check("compiling the march's shader");
}

bool PicturePass::has_layers() const {
  return options_.count || options_.depth || options_.transmittance;
}

void PicturePass::make_target(int side) {
  target_ = std::make_unique<TileTarget>(side, march_.key().resumable, has_layers());
}

Image PicturePass::draw(RenderStats& stats) {
  Timer timer(context_.renderer());
  Film film(view_, options_);
  Readback readback(film, view_, options_, double(drawn_.size.x) * drawn_.size.y);
  const glm::ivec2 centre = picture_.origin + picture_.size / 2;
  for (TileOrder order(drawn_, centre, largest_side); !order.empty();) {
    const int side = target_->side();
    const PixelBox tile = order.take(side);
    const Stopwatch drawing;
    draw_tile(tile, readback, timer, stats);
    const int next = next_side(side, tile, drawing.ms(), options_.tile_ms);
    if (next != side && !order.empty()) make_target(next);
  }
  readback.develop();
  for (const PixelBox& pixels : beside_)
    readback.add_missed({pixels.origin - picture_.origin, pixels.size}, missed_);
  if (drawn_.empty() && options_.progress) options_.progress(1);
  stats.gpu_ms = timer.sum_ms();
  stats.stuck += readback.stuck();
  return film.finish(stats);
}

void PicturePass::draw_tile(const PixelBox& tile, Readback& readback, Timer& timer,
                            RenderStats& stats) {
  const int samples = view_.scene.pixel_samples;
  const glm::ivec2 at = tile.origin - picture_.origin;
  Exposure exposure{at.x, at.y, tile.size.x, tile.size.y};
  march_.program().set("tile_origin", tile.origin);
  for (; exposure.sample < samples; ++exposure.sample) {
    march_.program().set("given.sample_offset",
                         options_.place.value_or(pixel_sample(exposure.sample, samples)));
    const int passes = draw_passes(exposure, timer);
    stats.passes = std::max(stats.passes, passes);
    readback.develop();  // the tile before, while this one is drawn
    timer.awaited();
    target_->bind((passes - 1) & 1);
    readback.read(*target_, exposure);
    context_.check("marching");
  }
}

int PicturePass::draw_passes(const Exposure& tile, Timer& timer) {
  bool again = false;
  return target_->draw_passes(march_, tile.width, tile.height, [&] {
    if (std::exchange(again, true)) timer.awaited();
    timer.begin();
    triangle_.draw(march_.program(), tile.width, tile.height);
    timer.submitted();
  });
}

}  // namespace psivox::gl
