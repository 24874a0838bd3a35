#include "view/picture_maker.h"

#include <utility>

#include "base/stopwatch.h"
#include "psivox/error.h"

namespace psivox::view {
namespace {

/// Aimed at for a tile of the exact picture: how long a new wish may wait.
constexpr double tile_ms = 25;

DoneTile whole(const Image& image) {
  return {0, 0, image.width, image.height, image.rgba().data()};
}

}  // namespace

PictureMaker::PictureMaker(const ViewerOptions& options, int device, std::function<void()> on_news)
    : Worker(std::move(on_news)),
      options_(options),
      context_{device, options.debug},
      pace_(options.frame_budget_ms) {
  start([this](const std::stop_token& stop) { run(stop); });
}

PictureMaker::~PictureMaker() {
  stop([&] { ++newest_; });
}

void PictureMaker::wish(PictureWish wish) {
  post([&] {
    newest_ = wish.number;
    if (std::exchange(layer_, wish.layer) != wish.layer) news_.state.layer_range = {};
    wish_ = std::move(wish);
  });
}

void PictureMaker::rest(std::uint64_t number) {
  post([&] { resting_ = number; });
}

void PictureMaker::ask(const glm::dvec2& pixel, bool for_value) {
  post([&] {
    pick_ = {pixel, for_value};
    interrupted_ = true;
  });
}

void PictureMaker::reload_shaders() {
  post([&] { reload_ = interrupted_ = true; });
}

PictureNews PictureMaker::news() {
  const std::lock_guard lock(mutex_);
  PictureNews news = std::exchange(news_, {});
  news_.state = news.state;
  return news;
}

void PictureMaker::stage(const std::string& name, double fraction) {
  const std::lock_guard lock(mutex_);
  progress_.reset();
  if (!name.empty()) progress_ = {name, fraction};
}

void PictureMaker::check_current(std::uint64_t number) const {
  if (newest_ != number || interrupted_) throw Outdated();
}

void PictureMaker::run(const std::stop_token& stop) {
  serve(stop);
  // where its context is current
  gpu_.reset();
}

void PictureMaker::serve(const std::stop_token& stop) {
  PictureWish current;
  while (true) {
    std::optional<std::pair<glm::dvec2, bool>> pixel;
    bool renew = false, fresh = false;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return wish_ || pick_ || reload_; });
      if (stop.stop_requested()) return;  // even if there is a task
      pixel = std::exchange(pick_, {});
      renew = std::exchange(reload_, false);
      interrupted_ = false;
      fresh = wish_.has_value();
      if (fresh) current = *std::exchange(wish_, {});
    }
    try {
      if (renew) renew_renderer();
      if (pixel && current.volume) find_picked(current, pixel->first, pixel->second);
      if ((fresh || renew) && current.volume) make(current, stop);
    } catch (const Outdated&) {
      const std::lock_guard lock(mutex_);
      if (!wish_ && newest_ == current.number) wish_ = current;  // it was only interrupted
    } catch (const std::exception& error) {
      tell([&] { news_.errors.emplace_back(error.what()); });
    }
    stage("", 0);
  }
}

void PictureMaker::make(const PictureWish& wish, const std::stop_token& stop) {
  const bool another = wish.volume != shown_;
  if (another) pace_.forget();
  bring_up(wish.volume, wish.scenes.front());
  if (another) stage("compiling", 0);
  draw_previews(wish);
  stage("", 0);
  {
    std::unique_lock lock(mutex_);
    const auto at_rest = [&] { return resting_ == wish.number; };
    const auto other_task = [&] { return wish_ || pick_ || reload_; };
    if (!changed_.wait(lock, stop, [&] { return at_rest() || other_task(); })) return;
    if (other_task()) {
      if (!wish_) wish_ = wish;  // after the other task
      return;
    }
  }
  refine(wish);
}

void PictureMaker::bring_up(const std::shared_ptr<Volume>& wished, const Scene& scene) {
  if (!gpu_) {
    stage("starting OpenGL", 0);
    try {
      gpu_ = open_gpu(context_);
    } catch (const Error&) {
      const std::lock_guard lock(mutex_);
      news_.fatal = std::current_exception();
      throw;
    }
    const std::lock_guard lock(mutex_);
    news_.state.renderer = description(*gpu_);
  }
  shown_.reset();
  Wish wish;
  wish.scene = scene;
  wish.any_light = true;
  // not ended by a new wish: light of the camera would never be done while the camera moves
  wish.progress = [this](psivox::Stage entered, double fraction) {
    stage(stage_text(entered), fraction);
  };
  wished->session->prepare(*gpu_, wish);
  shown_ = wished;
}

void PictureMaker::draw_previews(const PictureWish& wish) {
  const Rung rung = pace_.rung();
  double sum_ms = 0;
  std::vector<Image> images;
  for (const Scene& scene : wish.scenes) {
    Wish preview;
    preview.scene = preview_scene(scene, rung);
    preview.resolution = std::exchange(preview.scene->resolution, scene.resolution);
    preview.scene->tolerance.reset();
    if (!preview.scene->sampling) preview.scene->sampling = preview.scene->resolved_sampling();
    if (wish.layer != ShownLayer::error) ask_for(wish.layer, preview);
    preview.may_update_tables = true;
    preview.any_light = true;
    const Stopwatch drawing;
    Drawn drawn = wish.volume->session->draw(*gpu_, preview);
    sum_ms += drawing.ms() - std::max(0.0, drawn.stats.shader_ms - 5);
    images.push_back(std::move(drawn.image));
  }
  const glm::dvec2 range = show_layer(wish.layer, images);
  tell([&] {
    news_.previews.clear();
    for (std::size_t side = 0; side < images.size(); ++side)
      news_.previews.push_back({wish.number, side, std::move(images[side])});
    news_.state.shown = wish.number;
    news_.state.rung = rung;
    news_.state.preview_ms = sum_ms;
    news_.state.layer_range = range;
  });
  pace_.took(rung, sum_ms);
}

void PictureMaker::find_picked(const PictureWish& wish, const glm::dvec2& pixel, bool for_value) {
  if (wish.volume != shown_) return;  // its light may be missing
  const auto point = wish.volume->session->pick(wish.scenes.front(), pixel);
  if (point && !for_value) tell([&] { news_.picked = point; });
  if (!for_value) return;
  std::optional<Probed> probed;
  if (point) probed = {*point, wish.volume->value_at(*point)};
  tell([&] { news_.probed = probed; });
}

void PictureMaker::renew_renderer() {
  if (!gpu_ || !shown_) return;
  // The new shaders must work before the old ones go.
  const std::shared_ptr<Marcher> gpu = open_gpu(context_);
  Wish pixel;
  pixel.any_light = true;
  pixel.scene = shown_->scene;
  pixel.scene->tolerance.reset();
  pixel.scene->sampling = pixel.scene->resolved_sampling();
  pixel.resolution = glm::ivec2(1);
  shown_->session->draw(*gpu, pixel);
  gpu_ = gpu;
}

// --- at rest: the picture that `psivox render` would write -------------------------------

void PictureMaker::refine(const PictureWish& wish) {
  const Stopwatch refining;
  {
    const std::lock_guard lock(mutex_);
    news_.parts.clear();
    news_.state.estimated_rms.reset();
  }
  std::vector<Image> images;
  for (std::size_t side = 0; side < wish.scenes.size(); ++side)
    images.push_back(refine_side(wish, side));
  const glm::dvec2 range = show_layer(wish.layer, images);
  for (std::size_t side = 0; side < images.size() && wish.layer != ShownLayer::picture; ++side)
    add_part(wish, side, whole(images[side]));
  tell([&] {
    if (options_.count_objects) news_.state.objects = gl::count_objects();
    news_.state.refined = wish.number;
    news_.state.layer_range = range;
    news_.state.refine_ms = refining.ms();
  });
}

void PictureMaker::add_part(const PictureWish& wish, std::size_t side, const DoneTile& tile) {
  const glm::ivec2 size = wish.scenes[side].resolution;
  Image image = rgba_image(tile.width, tile.height);
  float* to = image.rgba().data();
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    to =
        std::copy_n(tile.picture + 4 * (std::size_t(y) * std::size_t(size.x) + std::size_t(tile.x)),
                    4 * std::size_t(tile.width), to);
  const std::lock_guard lock(mutex_);
  if (!news_.parts.empty() && news_.parts.front().number != wish.number) news_.parts.clear();
  news_.parts.push_back({wish.number, side, std::move(image), {tile.x, tile.y}, size});
  news_.state.begun = wish.number;
}

Image PictureMaker::refine_side(const PictureWish& wish, std::size_t side) {
  Wish exact;
  exact.scene = wish.scenes[side];
  exact.tile_ms = tile_ms;
  ask_for(wish.layer, exact);
  Scene& scene = *exact.scene;
  const bool picture = wish.layer == ShownLayer::picture;
  // of the reference's layers there is `error` alone
  if (scene.renderer == RendererKind::reference && !picture && !exact.layers.error)
    scene.renderer = RendererKind::gl;
  const bool by_gpu = scene.renderer == RendererKind::gl;
  const double share = 1 / double(wish.scenes.size()), first = double(side) * share;
  exact.progress = [&](psivox::Stage entered, double fraction) {
    check_current(wish.number);
    if (entered != psivox::Stage::marching) return stage(stage_text(entered), fraction);
    stage("refining", first + fraction * share);
    on_news_();
  };
  const bool in_tiles = picture && by_gpu && !scene.shows(Shows::plane);
  if (in_tiles) exact.tile = [&](const DoneTile& tile) { add_part(wish, side, tile); };
  // the light of other marchers is their own, as the command's is
  std::optional<Session> own;
  if (!by_gpu && wish.volume->scene.lit()) own.emplace(open_scene(scene, wish.volume->fields).view);
  const std::shared_ptr<Marcher> marcher = by_gpu ? gpu_ : open_marcher(scene);
  Drawn drawn = (own ? *own : *wish.volume->session).draw(*marcher, exact);
  std::optional<double> rms;
  if (drawn.plan && drawn.plan->rays > 0) rms = drawn.plan->chosen.rms;
  if (drawn.difference) rms = drawn.difference->rms;
  if (side == 0 && rms) {
    const std::lock_guard lock(mutex_);
    news_.state.estimated_rms = rms;
  }
  if (picture && !in_tiles) add_part(wish, side, whole(drawn.image));
  return std::move(drawn.image);
}

}  // namespace psivox::view
