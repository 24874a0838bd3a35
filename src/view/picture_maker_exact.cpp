// How PictureMaker makes what is shown at rest: the picture that `psivox render` would write.

#include <chrono>
#include <cmath>
#include <utility>

#include "view/picture_maker.h"

namespace psivox::view {
namespace {

/// Aimed at for a tile of the exact picture: how long a new wish may wait.
constexpr double tile_ms = 25;

DoneTile whole(const Image& image) {
  return {0, 0, image.width, image.height, image.rgba().data()};
}

}  // namespace

void PictureMaker::refine(const PictureWish& wish) {
  const auto start = std::chrono::steady_clock::now();
  {
    const std::lock_guard lock(mutex_);
    news_.parts.clear();
  }
  if (wish.layer == ShownLayer::picture)
    for (std::size_t side = 0; side < wish.scenes.size(); ++side) refine_side(wish, side);
  else
    refine_layers(wish);
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  const gl::ObjectCounts objects =
      options_.count_objects ? gl::count_objects() : gl::ObjectCounts();
  {
    const std::lock_guard lock(mutex_);
    news_.objects = objects;
    news_.refined = wish.number;
    news_.refine_ms = taken.count();
  }
  on_news_();
}

void PictureMaker::add_part(const PictureWish& wish, std::size_t side, const DoneTile& tile) {
  const glm::ivec2 size = wish.scenes[side].resolution;
  ExactPart part{wish.number, side, size, {tile.x, tile.y}, {tile.width, tile.height}, {}};
  part.rgba.reserve(std::size_t(tile.width) * std::size_t(tile.height) * 4);
  for (int y = tile.y; y < tile.y + tile.height; ++y) {
    const float* row =
        tile.picture + 4 * (std::size_t(y) * std::size_t(size.x) + std::size_t(tile.x));
    part.rgba.insert(part.rgba.end(), row, row + 4 * std::size_t(tile.width));
  }
  const std::lock_guard lock(mutex_);
  if (!news_.parts.empty() && news_.parts.front().number != wish.number) news_.parts.clear();
  news_.parts.push_back(std::move(part));
}

Wish PictureMaker::exact_wish(const PictureWish& wish, std::size_t side) {
  Wish exact;
  exact.scene = wish.scenes[side];
  exact.tile_ms = tile_ms;
  const double share = 1 / double(wish.scenes.size()), first = double(side) * share;
  exact.progress = [this, number = wish.number, first, share](psivox::Stage entered,
                                                              double fraction) {
    check_current(number);
    if (entered == psivox::Stage::marching) {
      stage("refining", first + fraction * share);
      on_news_();
    } else {
      stage(stage_text(entered), fraction);
    }
  };
  return exact;
}

void PictureMaker::refine_side(const PictureWish& wish, std::size_t side) {
  Wish exact = exact_wish(wish, side);
  const Scene& scene = wish.scenes[side];
  if (scene.renderer == RendererKind::gl && !scene.shows(Shows::plane)) {
    exact.tile = [&](const DoneTile& tile) { add_part(wish, side, tile); };
    draw(wish, side, exact);
  } else {
    add_part(wish, side, whole(draw(wish, side, exact).image));
  }
}

void PictureMaker::refine_layers(const PictureWish& wish) {
  std::vector<Image> images;
  for (std::size_t side = 0; side < wish.scenes.size(); ++side) {
    Wish exact = exact_wish(wish, side);
    ask_for(wish.layer, exact);
    // of the reference's layers there is `error` alone
    if (exact.scene->renderer == RendererKind::reference && !exact.layers.error)
      exact.scene->renderer = RendererKind::gl;
    images.push_back(draw(wish, side, exact).image);
  }
  const glm::dvec2 range = show_layer(wish.layer, images);
  for (std::size_t side = 0; side < images.size(); ++side)
    add_part(wish, side, whole(images[side]));
  const std::lock_guard lock(mutex_);
  news_.layer_range = range;
}

Drawn PictureMaker::draw(const PictureWish& wish, std::size_t side, const Wish& exact) {
  Session* session = wish.volume->session.get();
  std::shared_ptr<Marcher> marcher = gpu_;
  std::optional<Session> own;
  if (exact.scene->renderer != RendererKind::gl) {
    marcher = open_marcher(*exact.scene);
    // their light is their own, as the command's is
    if (wish.volume->scene.lit())
      session = &own.emplace(make_view(*exact.scene, wish.volume->fields));
  }
  Drawn drawn = session->draw(*marcher, exact);
  std::optional<double> rms;
  if (drawn.plan && drawn.plan->rays > 0) rms = drawn.plan->chosen.rms;
  if (drawn.difference) rms = drawn.difference->rms;
  if (side == 0 && rms) {
    const std::lock_guard lock(mutex_);
    news_.estimated_rms = rms;
  }
  return drawn;
}

}  // namespace psivox::view
