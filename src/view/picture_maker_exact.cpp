// How PictureMaker makes what is shown at rest: what cmd_render.cpp would write.

#include <chrono>
#include <cmath>
#include <utility>

#include "psivox/error_control.h"
#include "psivox/light.h"
#include "psivox/parameters.h"
#include "psivox/reference.h"
#include "view/picture_maker.h"

namespace psivox::view {
namespace {

/// Aimed at for a tile of the exact picture: how long a new wish may wait.
constexpr double tile_ms = 25;

/// Root mean square of a layer's values.
double rms_of(const Layer& layer) {
  double squares = 0;
  for (const float value : layer.values) squares += double(value) * double(value);
  return std::sqrt(squares / double(layer.values.size()));
}

/// Options of a small picture by the program of those.
RenderOptions of_one_program(RenderOptions options) {
  options.tile = {};
  options.progress = {};
  return options;
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
  const glm::ivec2 whole = wish.scenes[side].resolution;
  ExactPart part{wish.number, side, whole, {tile.x, tile.y}, {tile.width, tile.height}, {}};
  part.rgba.reserve(std::size_t(tile.width) * std::size_t(tile.height) * 4);
  for (int y = tile.y; y < tile.y + tile.height; ++y) {
    const float* row =
        tile.picture + 4 * (std::size_t(y) * std::size_t(whole.x) + std::size_t(tile.x));
    part.rgba.insert(part.rgba.end(), row, row + 4 * std::size_t(tile.width));
  }
  const std::lock_guard lock(mutex_);
  if (!news_.parts.empty() && news_.parts.front().number != wish.number) news_.parts.clear();
  news_.parts.push_back(std::move(part));
}

RenderOptions PictureMaker::refining(const PictureWish& wish, double first, double last) {
  RenderOptions options;
  options.tile_ms = tile_ms;
  options.progress = [this, number = wish.number, first, last](double fraction) {
    check_current(number);
    stage("refining", first + fraction * (last - first));
    on_news_();
  };
  return options;
}

void PictureMaker::refine_side(const PictureWish& wish, std::size_t side) {
  const Scene& scene = wish.scenes[side];
  const double share = 1.0 / double(wish.scenes.size());
  RenderOptions options = refining(wish, double(side) * share, double(side + 1) * share);
  if (scene.renderer != RendererKind::gl) {
    const Image image = on_processor(wish, side, options);
    add_part(wish, side, {0, 0, image.width, image.height, image.rgba().data()});
    return;
  }
  options.tile = [&](const DoneTile& tile) { add_part(wish, side, tile); };
  const View view = view_of(*wish.volume, scene);
  draw(planned(view, wish.volume->atlas), side, options);
}

void PictureMaker::refine_layers(PictureWish wish) {
  std::vector<Image> images;
  const double share = 1.0 / double(wish.scenes.size());
  for (std::size_t side = 0; side < wish.scenes.size(); ++side) {
    RenderOptions options = refining(wish, double(side) * share, double(side + 1) * share);
    ask_for(wish.layer, wish.scenes[side], options);
    images.push_back(with_layer(wish, side, options));
  }
  std::optional<double> rms;
  if (wish.layer == ShownLayer::error) rms = rms_of(images.front().layers.back());
  const glm::dvec2 range = show_layer(wish.layer, images);
  for (std::size_t side = 0; side < images.size(); ++side)
    add_part(wish, side,
             {0, 0, images[side].width, images[side].height, images[side].rgba().data()});
  const std::lock_guard lock(mutex_);
  news_.layer_range = range;
  if (rms) news_.estimated_rms = rms;
}

Image PictureMaker::with_layer(const PictureWish& wish, std::size_t side,
                               const RenderOptions& options) {
  const Scene& scene = wish.scenes[side];
  const bool error = wish.layer == ShownLayer::error;
  // the reference has no other layer
  if (scene.renderer == RendererKind::march_double ||
      (scene.renderer == RendererKind::reference && error))
    return on_processor(wish, side, options);
  bring_up(wish.volume, scene.filter);
  const MarchPlan plan = planned(view_of(*wish.volume, scene), wish.volume->atlas);
  Image image = draw(plan, side, options);
  if (!error) return image;
  bring_up(wish.volume, Filter::exact);
  const View exact = exact_view(plan.view);
  const Image better = renderer_->render(exact, options).image;
  const double common =
      device_error(exact, wish.volume->atlas,
                   renderer_->render(pilot_view(exact), of_one_program(options)).image);
  image.layers.push_back(error_layer(image, better, common));
  return image;
}

MarchPlan PictureMaker::planned(View view, const MediumAtlas& atlas) {
  view.scene = with_default_tolerance(view.scene);
  if (!view.scene.tolerance) {
    MarchPlan given;
    given.view = std::move(view);
    return given;
  }
  stage("choosing the march", 0);
  return plan_march(view, atlas);
}

Image PictureMaker::draw(MarchPlan plan, std::size_t side, const RenderOptions& options) {
  Image image = renderer_->render(plan.view, options).image;
  if (plan.rays() > 0)
    confirm(plan, renderer_->render(pilot_view(plan.view), of_one_program(options)).image);
  estimated(plan, side);
  return image;
}

void PictureMaker::estimated(const MarchPlan& plan, std::size_t side) {
  if (side != 0 || plan.rays() == 0) return;
  const std::lock_guard lock(mutex_);
  news_.estimated_rms = plan.chosen.rms;
}

Image PictureMaker::on_processor(const PictureWish& wish, std::size_t side,
                                 const RenderOptions& options) {
  const Scene& scene = wish.scenes[side];
  View view = view_of(*wish.volume, scene);
  // their light is their own, as in cmd_render.cpp
  const bool light = wish.volume->scene.lit();
  if (light) view.medium = make_view(scene, wish.volume->fields).medium;
  if (scene.renderer == RendererKind::reference) {
    if (light) view = lit(view, reference_light_depths(view), options.progress);
    return render_reference(view, 1e-12, options.progress).image;
  }
  std::optional<MediumAtlas> own;
  if (light) {
    own = build_medium_atlas(view);
    view = lit(view, march_double_light_depths(view, *own), options.progress);
    add_luminance(*own, view);
  }
  const MediumAtlas& atlas = own ? *own : wish.volume->atlas;
  const MarchPlan plan = planned(view, atlas);
  Image image = render_march_double(plan.view, atlas, options).image;
  estimated(plan, side);
  if (wish.layer == ShownLayer::error)
    image.layers.push_back(
        error_layer(image, render_march_double(exact_view(plan.view), atlas, options).image));
  return image;
}

}  // namespace psivox::view
