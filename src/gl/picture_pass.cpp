#include "gl/picture_pass.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "march/film.h"
#include "march/glsl_subset.h"

namespace psivox::gl {

/// A part of the picture in the making: one sample of each of its pixels.
struct Exposure {
  int x = 0, y = 0, width = 0, height = 0;
  int sample = 0;
  std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
};

/// Tiles on their way from the GPU to the film: read() while nothing is drawn, develop() while the
/// next tile is.
class Readback {
 public:
  /// `drawn`: number of pixels that will be read, of which options.progress tells.
  Readback(Film& film, const View& view, const RenderOptions& options, double drawn);

  /// Copies a tile from the GPU.
  void read(const TileTarget& target, const Exposure& tile);

  /// Adds pixels whose rays were not drawn: all are as the one at `like`.
  void add_missed(const PixelBox& pixels, const glm::ivec2& like);

  /// Adds the tile that was read last, if it is not added yet, to the film, and reports it.
  void develop();

  /// Reports the progress so far.
  void report() const;

  /// Rays that no longer advanced and were ended early, of what was read.
  std::uint64_t stuck() const { return stuck_; }

 private:
  void add(const Exposure& tile);
  /// Adds a tile of several samples a pixel without layers.
  void add_picture(const Exposure& tile);

  Film& film_;
  const RenderOptions& options_;
  int samples_;  ///< of a pixel
  double all_rays_;
  std::uint64_t rays_done_ = 0, stuck_ = 0;
  std::optional<Exposure> waiting_;
  std::vector<glm::vec4> picture_, layers_;
  std::vector<PixelSums> sums_;  ///< of the tile, where a pixel has several samples and layers
  std::vector<glm::dvec4> picture_sums_;  ///< where it has no layers
};

Readback::Readback(Film& film, const View& view, const RenderOptions& options, double drawn)
    : film_(film),
      options_(options),
      samples_(view.scene.pixel_samples),
      all_rays_(drawn * samples_) {}

void Readback::read(const TileTarget& target, const Exposure& tile) {
  waiting_ = tile;
  glm::vec4* pixels = film_.pixel(tile.x, tile.y);
  int stride = film_.width();
  if (samples_ > 1) {
    picture_.resize(tile.pixels());
    pixels = picture_.data();
    stride = tile.width;
  }
  target.read_picture(tile.width, tile.height, pixels, stride);
  for (int row = 0; row < tile.height; ++row)
    for (glm::vec4& pixel :
         std::span(pixels + std::ptrdiff_t(row) * stride, std::size_t(tile.width)))
      if (pixel.w > 0.5f * float(stuck_mark)) {
        pixel.w -= float(stuck_mark);
        ++stuck_;
      }
  if (!film_.has_layers()) return;
  layers_.resize(tile.pixels());
  target.read_layers(tile.width, tile.height, layers_.data(), tile.width);
}

void Readback::develop() {
  if (!waiting_) return;
  const Exposure tile = *waiting_;
  waiting_.reset();
  add(tile);
  rays_done_ += tile.pixels();
  if (options_.tile && tile.sample + 1 == samples_)
    options_.tile({tile.x, tile.y, tile.width, tile.height, film_.picture()});
  report();
}

void Readback::report() const {
  if (options_.progress) options_.progress(double(rays_done_) / all_rays_);
}

void Readback::add_missed(const PixelBox& pixels, const glm::ivec2& like) {
  const auto& [origin, size] = pixels;
  film_.repeat(like, pixels);
  if (options_.tile) options_.tile({origin.x, origin.y, size.x, size.y, film_.picture()});
}

void Readback::add(const Exposure& tile) {
  if (samples_ == 1) {
    const std::span<const glm::vec4> layers = layers_;
    const auto width = std::size_t(tile.width);
    for (int row = 0; film_.has_layers() && row < tile.height; ++row)
      film_.set_layers(tile.x, tile.y + row, layers.subspan(std::size_t(row) * width, width));
    return;
  }
  if (!film_.has_layers()) return add_picture(tile);
  if (tile.sample == 0) sums_.assign(tile.pixels(), {});
  std::size_t k = 0;
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    for (int x = tile.x; x < tile.x + tile.width; ++x, ++k) {
      sums_[k].add(glm::dvec4(picture_[k]), glm::dvec4(layers_[k]));
      if (tile.sample + 1 == samples_) film_.set(x, y, sums_[k]);
    }
}

void Readback::add_picture(const Exposure& tile) {
  picture_sums_.resize(tile.pixels());
  const bool first = tile.sample == 0, last = tile.sample + 1 == samples_;
  const auto width = std::size_t(tile.width);
  for (int row = 0; row < tile.height; ++row) {
    const std::size_t from = std::size_t(row) * width;
    glm::vec4* pixels = film_.pixel(tile.x, tile.y + row);
    for (std::size_t i = 0; i < width; ++i) {
      glm::dvec4 sum(picture_[from + i]);
      if (!first) sum += picture_sums_[from + i];
      if (last)
        pixels[i] = glm::vec4(sum / double(samples_));
      else
        picture_sums_[from + i] = sum;
    }
  }
}

Timer::Timer(const std::string& renderer) : waits_(is_software(renderer)) {
  GLint bits = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
  works_ = bits > 0;
}

Timer::~Timer() {
  end();
  glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
}

void Timer::begin() {
  if (!works_) return;
  glCreateQueries(GL_TIME_ELAPSED, 1, &queries_.emplace_back());
  glBeginQuery(GL_TIME_ELAPSED, queries_.back());
  running_ = true;
  if (waits_) glFinish();
}

void Timer::submitted() {
  glFlush();
  if (!waits_) end();
}

void Timer::awaited() {
  if (!waits_) return;
  glFinish();
  end();
}

double Timer::sum_ms() const {
  double sum = 0;
  for (const GLuint query : queries_) {
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
    sum += 1e-6 * static_cast<double>(nanoseconds);
  }
  return sum;
}

void Timer::end() {
  if (running_) glEndQuery(GL_TIME_ELAPSED);
  running_ = false;
}

namespace {

constexpr int smallest_side = 16;

/// Side of the largest tile that `pixels` need. State between passes takes 128 bytes a pixel, which
/// a driver clears for each target: 8 MiB here. By compute shaders a tile may be the whole picture:
/// a GPU waits for the longest rays of each.
int largest_side(const PixelBox& pixels, bool resumable, bool computes) {
  const auto widest = unsigned(std::max(pixels.size.x, pixels.size.y));
  const int most = resumable ? 256 : computes ? 4096 : 1024;
  return std::clamp(int(std::bit_ceil(widest)), smallest_side, most);
}

/// Side of the first tile, whose time is not known.
int first_side(int passes, double wanted_ms) {
  constexpr int many_passes = 16;
  if (passes > many_passes) return smallest_side;
  return passes > 1 || wanted_ms < 100 ? 64 : 512;
}

/// Look-ups that any GPU does at once in less time than a watchdog allows: 0.4 s at 1e9 a second.
constexpr double most_at_once = 4e8;

/// Adds a row or a column of a larger rectangle to an inner one. Returns a pixel of it; empty if
/// the inner one is all.
std::optional<glm::ivec2> grow(PixelBox& inner, const PixelBox& all) {
  if (inner.empty()) inner = {all.origin, {0, 0}};
  for (const int axis : {0, 1}) {
    if (inner.origin[axis] == all.origin[axis] && inner.size[axis] == all.size[axis]) continue;
    const bool before = inner.origin[axis] > all.origin[axis];
    if (before) --inner.origin[axis];
    ++inner.size[axis];
    inner.size = glm::max(inner.size, 1);
    return before ? inner.origin : inner.origin + inner.size - 1;
  }
  return {};
}

/// Side of the next tile from the time that the last one took: no draw runs for minutes, and few
/// draws wait for each other.
int next_side(int side, const PixelBox& tile, double tile_ms, double wanted_ms) {
  if (tile_ms > 2 * wanted_ms) return std::max(side / 2, smallest_side);
  const double part = double(tile.size.x) * double(tile.size.y) / (double(side) * double(side));
  return tile_ms < 0.4 * part * wanted_ms ? side * 2 : side;
}

}  // namespace

PicturePass::PicturePass(const EglContext& context, const GridTextures& textures,
                         const MarchProgram& march, MarchSetup setup, const View& view,
                         const RenderOptions& options, int passes)
    : context_(context),
      textures_(textures),
      march_(march),
      setup_(std::move(setup)),
      tables_(setup_.tables),
      view_(view),
      options_(options),
      picture_(options.pixels.value_or(PixelBox{{}, view.scene.resolution})),
      drawn_(common(picture_, pixels_of(view, glm::dvec3(textures.atlas().density.domain.min),
                                        glm::dvec3(textures.atlas().density.domain.max)))),
      missed_(grow(drawn_, picture_)),
      beside_(around(drawn_, picture_)),
      largest_(largest_side(drawn_, march.key().resumable, march.program().group().x > 0)),
      timer_(context.renderer()),
      order_(drawn_, picture_.origin + picture_.size / 2, largest_) {
  setup_.tables = {};  // the device has them
  const bool computes = march.program().group().x > 0;
  const double cost = options.ray_cost * double(drawn_.size.x) * double(drawn_.size.y);
  const bool at_once = computes && passes == 1 && cost > 0 && cost <= most_at_once;
  make_target(at_once ? largest_ : std::min(first_side(passes, options.tile_ms), largest_));
  if (!is_software(context.renderer())) return;
  // Such a driver compiles at the first draw: one pixel, so that the march's time is the march's.
  bind();
  target_->bind(0);
  march.program().set("first_pass", 1);
  march.program().set("tile_origin", missed_.value_or(drawn_.origin));
  pixels_.run(march.program(), 1, 1);
  glFinish();
  context.check("compiling the march's shader");
}

void PicturePass::bind() const {
  march_.configure(setup_);
  tables_.bind(MarchProgram::tables_unit);
  textures_.bind(march_);
}

void PicturePass::make_target(int side) {
  const bool layers = options_.count || options_.depth || options_.transmittance;
  target_ = std::make_unique<TileTarget>(side, march_.key().resumable, layers);
}

void PicturePass::begin() {
  if (order_.empty()) return;
  bind();
  first_ = order_.take(target_->side());
  passes_ = draw_passes(first_, 0, [] {});
  timer_.awaited();
}

Image PicturePass::draw(RenderStats& stats) {
  bind();
  Film film(view_, options_);
  Readback readback(film, view_, options_, double(drawn_.size.x) * drawn_.size.y);
  int side = target_->side();
  while (passes_ > 0 || !order_.empty()) {
    if (side > target_->side()) make_target(side);
    const PixelBox tile = passes_ > 0 ? first_ : order_.take(side);
    const Stopwatch drawing;
    draw_tile(tile, readback, stats);
    side = std::min(next_side(side, tile, drawing.ms(), options_.tile_ms), largest_);
  }
  readback.develop();
  for (const PixelBox& pixels : beside_)
    readback.add_missed({pixels.origin - picture_.origin, pixels.size}, *missed_ - picture_.origin);
  stats.gpu_ms += timer_.sum_ms();
  stats.stuck += readback.stuck();
  return film.finish(stats);
}

void PicturePass::draw_tile(const PixelBox& tile, Readback& readback, RenderStats& stats) {
  const glm::ivec2 at = tile.origin - picture_.origin;
  Exposure exposure{at.x, at.y, tile.size.x, tile.size.y};
  for (; exposure.sample < view_.scene.pixel_samples; ++exposure.sample) {
    int passes = std::exchange(passes_, 0);
    if (passes == 0) passes = draw_passes(tile, exposure.sample, [&] { readback.report(); });
    stats.passes = std::max(stats.passes, passes);
    readback.develop();  // the tile before, while this one is drawn
    timer_.awaited();
    target_->bind((passes - 1) & 1);
    readback.read(*target_, exposure);
    context_.check("marching");
  }
}

int PicturePass::draw_passes(const PixelBox& tile, int sample,
                             const std::function<void()>& report) {
  const glm::dvec2 place = pixel_sample(sample, view_.scene.pixel_samples);
  march_.program().set("tile_origin", tile.origin);
  march_.program().set("given.sample_offset", options_.place.value_or(place));
  bool again = false;
  return target_->draw_passes(march_, tile.size.x, tile.size.y, [&] {
    if (std::exchange(again, true)) {
      timer_.awaited();
      report();
    }
    timer_.begin();
    pixels_.run(march_.program(), tile.size.x, tile.size.y);
    timer_.submitted();
  });
}

}  // namespace psivox::gl
