#include "view/picture_maker.h"

#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "psivox/error.h"
#include "psivox/error_control.h"
#include "psivox/light.h"
#include "psivox/reference.h"

namespace psivox::view {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Ends the making of a picture that nobody wants any more.
struct Outdated {};

/// Without a wish for this long, things are at rest.
constexpr auto rest = std::chrono::milliseconds(120);
/// Aimed at for a tile of the exact picture: how long a new wish may wait.
constexpr double tile_ms = 25;

/// The camera whose only pixel is that pixel of the picture.
Camera through_pixel(const Camera& camera, const glm::ivec2& resolution, const glm::dvec2& pixel) {
  const WorldRay ray = camera_ray(camera, resolution, pixel.x, pixel.y);
  Camera narrow = camera;
  narrow.position = ray.origin;
  narrow.forward = ray.direction;
  narrow.target = ray.origin + ray.direction;
  narrow.right = glm::normalize(glm::cross(ray.direction, camera.up));
  narrow.up = glm::cross(narrow.right, ray.direction);
  narrow.half_width = camera.half_width / resolution.x;
  narrow.half_height = narrow.half_width;
  return narrow;
}

}  // namespace

PictureMaker::PictureMaker(const Options& options, std::function<void()> on_news)
    : options_(options),
      on_news_(std::move(on_news)),
      pace_(options.budget_ms),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

PictureMaker::~PictureMaker() {
  thread_.request_stop();
  ++newest_;
  changed_.notify_all();
  thread_.join();
}

void PictureMaker::wish(PictureWish wish) {
  {
    const std::lock_guard lock(mutex_);
    newest_ = wish.number;
    wish_ = std::move(wish);
  }
  changed_.notify_all();
}

void PictureMaker::pick(const glm::dvec2& pixel) {
  {
    const std::lock_guard lock(mutex_);
    pick_ = pixel;
    interrupted_ = true;
  }
  changed_.notify_all();
}

void PictureMaker::reload_shaders() {
  {
    const std::lock_guard lock(mutex_);
    reload_ = true;
    interrupted_ = true;
  }
  changed_.notify_all();
}

PictureNews PictureMaker::news() {
  const std::lock_guard lock(mutex_);
  std::string renderer = news_.renderer;
  PictureNews news = std::exchange(news_, {});
  news_.renderer = std::move(renderer);
  return news;
}

std::optional<std::pair<std::string, double>> PictureMaker::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void PictureMaker::stage(const std::string& name, double fraction) {
  const std::lock_guard lock(mutex_);
  progress_.reset();
  if (!name.empty()) progress_ = {name, fraction};
}

void PictureMaker::report(const std::string& error) {
  {
    const std::lock_guard lock(mutex_);
    news_.errors.push_back(error);
  }
  on_news_();
}

void PictureMaker::check_current(std::uint64_t number) const {
  if (newest_ != number || interrupted_) throw Outdated();
}

void PictureMaker::run(const std::stop_token& stop) {
  serve(stop);
  // where its context is current
  renderer_.reset();
}

void PictureMaker::serve(const std::stop_token& stop) {
  PictureWish current;
  while (true) {
    std::optional<glm::dvec2> pixel;
    bool renew = false, fresh = false;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return wish_ || pick_ || reload_; })) return;
      pixel = std::exchange(pick_, {});
      renew = std::exchange(reload_, false);
      interrupted_ = false;
      fresh = wish_.has_value();
      if (fresh) current = *std::exchange(wish_, {});
    }
    try {
      if (renew) renew_renderer();
      if (pixel && current.volume) find_picked(current, *pixel);
      if ((fresh || renew) && current.volume) make(current, stop);
    } catch (const Outdated&) {
      const std::lock_guard lock(mutex_);
      if (!wish_ && newest_ == current.number) wish_ = current;  // it was only interrupted
    } catch (const std::exception& error) {
      report(error.what());
    }
    stage("", 0);
  }
}

void PictureMaker::make(const PictureWish& wish, const std::stop_token& stop) {
  if (wish.volume != uploaded_) pace_.forget();
  bring_up(*wish.volume, wish.scenes.front().filter);
  uploaded_ = wish.volume;
  draw_previews(wish);
  {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, stop, rest, [&] { return wish_ || pick_ || reload_; })) {
      if (!wish_) wish_ = wish;  // after the other task
      return;
    }
    if (stop.stop_requested()) return;
  }
  refine(wish);
}

void PictureMaker::bring_up(Volume& volume, Filter filter) {
  if (!renderer_) {
    stage("starting OpenGL", 0);
    try {
      renderer_ = std::make_unique<GlRenderer>(ContextOptions{options_.device, options_.debug});
    } catch (const Error&) {
      const std::lock_guard lock(mutex_);
      news_.fatal = std::current_exception();
      throw;
    }
    uploaded_.reset();
    const std::lock_guard lock(mutex_);
    news_.renderer = renderer_->description();
  }
  if (!volume.light_added && volume.view.medium.light) {
    uploaded_.reset();
    renderer_->upload(volume.atlas);
    const std::uint64_t number = newest_;
    View lighted = lit(volume.view, renderer_->light_depths(volume.view), [&](double fraction) {
      stage("lighting", fraction);
      check_current(number);
    });
    add_luminance(volume.atlas, lighted);
    volume.view = std::move(lighted);
  }
  volume.light_added = true;
  if (uploaded_.get() == &volume && uploaded_filter_ == filter) return;
  uploaded_.reset();
  renderer_->upload(volume.atlas, filter);
  uploaded_filter_ = filter;
}

void PictureMaker::draw_previews(const PictureWish& wish) {
  const Rung rung = pace_.rung();
  double sum_ms = 0;
  for (std::size_t side = 0; side < wish.scenes.size(); ++side) {
    const Scene& scene = wish.scenes[side];
    View view = view_of(*wish.volume, scene);
    view.scene = preview_scene(scene, rung);
    RenderOptions options;
    ask_for(wish.layer, view.scene, options);
    options.may_update_tables = true;
    options.progress = [&](double) {
      // A newer wish is served sooner if this one ends, but something must be seen now and then.
      if (newest_ != wish.number && sum_ms > 8 * options_.budget_ms) throw Outdated();
    };
    const auto start = Clock::now();
    RenderResult result = renderer_->render(view, options);
    const double ms = ms_since(start) - std::max(0.0, result.stats.shader_ms - 5);
    sum_ms += ms;
    const glm::dvec2 range = show_layer(wish.layer, result.image);
    {
      const std::lock_guard lock(mutex_);
      std::erase_if(news_.previews, [&](const PreviewPicture& old) { return old.side == side; });
      news_.layer_range = range;
      news_.previews.push_back({wish.number, side, std::move(result.image), rung, ms});
    }
    on_news_();
  }
  pace_.took(rung, sum_ms);
}

void PictureMaker::refine(const PictureWish& wish) {
  const auto start = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    news_.parts.clear();
  }
  for (std::size_t side = 0; side < wish.scenes.size(); ++side) refine_side(wish, side);
  {
    const std::lock_guard lock(mutex_);
    news_.refined = wish.number;
    news_.refine_ms = ms_since(start);
  }
  on_news_();
}

void PictureMaker::refine_side(const PictureWish& wish, std::size_t side) {
  const Scene& scene = wish.scenes[side];
  View view = view_of(*wish.volume, scene);
  if (scene.renderer == RendererKind::gl) view = planned(view, wish.volume->atlas);
  const auto add = [&](glm::ivec2 origin, glm::ivec2 size, const float* picture) {
    ExactPart part{wish.number, side, origin, size, {}};
    part.rgba.reserve(std::size_t(size.x) * std::size_t(size.y) * 4);
    for (int y = origin.y; y < origin.y + size.y; ++y) {
      const float* row =
          picture + 4 * (std::size_t(y) * std::size_t(scene.resolution.x) + std::size_t(origin.x));
      part.rgba.insert(part.rgba.end(), row, row + 4 * std::size_t(size.x));
    }
    const std::lock_guard lock(mutex_);
    if (!news_.parts.empty() && news_.parts.front().number != wish.number) news_.parts.clear();
    news_.parts.push_back(std::move(part));
  };
  RenderOptions options;
  options.tile_ms = tile_ms;
  options.progress = [&](double fraction) {
    check_current(wish.number);
    stage("refining",
          (static_cast<double>(side) + fraction) / static_cast<double>(wish.scenes.size()));
    on_news_();
  };
  if (wish.layer != ShownLayer::picture) {
    ask_for(wish.layer, view.scene, options);
    Image image = renderer_->render(view, options).image;
    const glm::dvec2 range = show_layer(wish.layer, image);
    add({0, 0}, scene.resolution, image.rgba().data());
    const std::lock_guard lock(mutex_);
    news_.layer_range = range;
    return;
  }
  if (scene.renderer == RendererKind::gl) {
    options.tile = [&](const DoneTile& tile) {
      add({tile.x, tile.y}, {tile.width, tile.height}, tile.picture);
    };
    renderer_->render(view, options);
    return;
  }
  const Image image = on_processor(*wish.volume, scene, options);
  add({0, 0}, scene.resolution, image.rgba().data());
}

/// The view as cmd_render.cpp has it marched.
View PictureMaker::planned(View view, const MediumAtlas& atlas) {
  if (view.scene.leaves_way_open()) view.scene.tolerance = default_tolerance;
  if (!view.scene.tolerance) return view;
  MarchPlan plan = plan_march(view, atlas);
  const std::lock_guard lock(mutex_);
  news_.estimated_rms = plan.chosen.rms;
  return std::move(plan.view);
}

/// As cmd_render.cpp does: their light is their own.
Image PictureMaker::on_processor(const Volume& volume, const Scene& scene,
                                 const RenderOptions& options) {
  View view = view_of(volume, scene);
  const bool light = volume.scene.lit();
  if (light) view.medium = make_view(scene, volume.fields).medium;
  if (scene.renderer == RendererKind::reference) {
    if (light) view = lit(view, reference_light_depths(view), options.progress);
    return render_reference(view, 1e-12, options.progress).image;
  }
  if (!light) return render_march_double(planned(view, volume.atlas), volume.atlas, options).image;
  MediumAtlas atlas = build_medium_atlas(view);
  view = lit(view, march_double_light_depths(view, atlas), options.progress);
  add_luminance(atlas, view);
  return render_march_double(planned(view, atlas), atlas, options).image;
}

void PictureMaker::find_picked(const PictureWish& wish, const glm::dvec2& pixel) {
  const Scene& scene = wish.scenes.front();
  if (wish.volume != uploaded_) return;  // its light may be missing
  View view = view_of(*wish.volume, scene);
  const WorldRay ray = camera_ray(view.camera, scene.resolution, pixel.x, pixel.y);
  view.camera = through_pixel(view.camera, scene.resolution, pixel);
  view.scene.resolution = {1, 1};
  view.scene.pixel_samples = 1;
  if (scene.mode == Mode::back_to_front) view.scene.mode = Mode::alpha;
  RenderOptions options;
  options.depth = true;
  const Image image = render_march_double(view, wish.volume->atlas, options).image;
  const double depth = image.layers.back().values.front();
  if (!std::isfinite(depth)) return;
  {
    const std::lock_guard lock(mutex_);
    news_.picked = ray.origin + depth * ray.direction;
  }
  on_news_();
}

void PictureMaker::renew_renderer() {
  if (!renderer_ || !uploaded_) return;
  // The new shaders must work before the old ones go.
  auto renderer = std::make_unique<GlRenderer>(ContextOptions{options_.device, options_.debug});
  renderer->upload(uploaded_->atlas, uploaded_filter_);
  View view = uploaded_->view;
  view.scene.filter = uploaded_filter_;
  view.scene.resolution = {1, 1};
  renderer->render(view);
  renderer_ = std::move(renderer);
}

}  // namespace psivox::view
