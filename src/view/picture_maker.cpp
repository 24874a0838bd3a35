#include "view/picture_maker.h"

#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "psivox/error.h"
#include "psivox/light.h"

namespace psivox::view {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Without a wish for this long, things are at rest.
constexpr auto rest = std::chrono::milliseconds(120);

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
  PictureNews news = std::exchange(news_, {});
  news_.renderer = news.renderer;
  news_.objects = news.objects;
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
  const bool another = wish.volume != uploaded_;
  if (another) pace_.forget();
  bring_up(wish.volume, wish.scenes.front().filter);
  if (another) stage("compiling", 0);
  draw_previews(wish);
  stage("", 0);
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

void PictureMaker::bring_up(const std::shared_ptr<Volume>& wished, Filter filter) {
  Volume& volume = *wished;
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
  if (uploaded_ == wished && uploaded_filter_ == filter) return;
  uploaded_.reset();
  stage("uploading", 0);
  renderer_->upload(volume.atlas, filter);
  uploaded_ = wished;
  uploaded_filter_ = filter;
}

void PictureMaker::draw_previews(const PictureWish& wish) {
  const Rung rung = pace_.rung();
  double sum_ms = 0;
  std::vector<Image> images;
  for (const Scene& scene : wish.scenes) {
    View view = view_of(*wish.volume, scene);
    view.scene = preview_scene(scene, rung);
    RenderOptions options;
    ask_for(wish.layer, view.scene, options);
    options.may_update_tables = true;
    const auto start = Clock::now();
    RenderResult result = renderer_->render(view, options);
    sum_ms += ms_since(start) - std::max(0.0, result.stats.shader_ms - 5);
    images.push_back(std::move(result.image));
  }
  const glm::dvec2 range = show_layer(wish.layer, images);
  {
    const std::lock_guard lock(mutex_);
    news_.layer_range = range;
    news_.previews.clear();
    for (std::size_t side = 0; side < images.size(); ++side)
      news_.previews.push_back({wish.number, side, std::move(images[side]), rung, sum_ms});
  }
  on_news_();
  pace_.took(rung, sum_ms);
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
