#include "gl/gl_renderer.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>

#include "gl/atlas_textures.h"
#include "gl/egl_context.h"
#include "gl/light_pass.h"
#include "gl/march_program.h"
#include "gl/tables.h"
#include "gl/tile_target.h"
#include "gl/timer.h"
#include "march/film.h"
#include "march/march_parameters.h"
#include "psivox/error.h"
#include "psivox/stopwatch.h"

namespace psivox {
namespace {

/// Side of the next tile from the time that the last one took: no draw runs for minutes, and few
/// draws wait for each other.
int next_side(int side, double tile_ms, double wanted_ms) {
  constexpr int smallest = 16, largest = 1024;
  if (tile_ms > 2 * wanted_ms) return std::max(side / 2, smallest);
  if (tile_ms < 0.4 * wanted_ms) return std::min(side * 2, largest);
  return side;
}

/// A part of the picture in the making: one of its pixels' samples.
struct Exposure {
  int x = 0, y = 0, width = 0, height = 0;
  int sample = 0;
  std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
};

/// Tiles on their way from the GPU to the film: read() while nothing is drawn, develop() beside.
class Readback {
 public:
  Readback(Film& film, int samples) : film_(film), samples_(samples) {}

  void read(const gl::TileTarget& target, const Exposure& tile) {
    glm::vec4* pixels = film_.pixel(tile.x, tile.y);
    int stride = film_.width();
    if (samples_ > 1) {
      picture_.resize(tile.pixels());
      pixels = picture_.data();
      stride = tile.width;
    }
    target.read_picture(tile.width, tile.height, pixels, stride);
    if (!film_.has_layers()) return;
    layers_.resize(tile.pixels());
    target.read_layers(tile.width, tile.height, layers_.data(), tile.width);
  }

  void develop(const Exposure& tile) {
    if (samples_ == 1) {
      const std::span<const glm::vec4> layers = layers_;
      for (int row = 0; film_.has_layers() && row < tile.height; ++row)
        film_.set_layers(
            tile.x, tile.y + row,
            layers.subspan(std::size_t(row) * std::size_t(tile.width), std::size_t(tile.width)));
      return;
    }
    if (tile.sample == 0) sums_.assign(tile.pixels(), {});
    if (!film_.has_layers()) layers_.assign(tile.pixels(), glm::vec4(0));
    std::size_t k = 0;
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      for (int x = tile.x; x < tile.x + tile.width; ++x, ++k) {
        sums_[k].add(glm::dvec4(picture_[k]), glm::dvec4(layers_[k]));
        if (tile.sample + 1 == samples_) film_.set(x, y, sums_[k]);
      }
  }

 private:
  Film& film_;
  int samples_;
  std::vector<glm::vec4> picture_, layers_;
  std::vector<PixelSums> sums_;  ///< of the tile, where a pixel has several samples
};

}  // namespace

struct GlRenderer::Impl {
  gl::EglContext context;
  double init_ms = 0;
  double upload_ms = 0;
  const MediumAtlas* atlas = nullptr;
  Filter filter = Filter::exact;  ///< that the textures are made for
  std::unique_ptr<gl::AtlasTextures> density, luminance, emission, gradient;
  std::map<std::string, std::unique_ptr<gl::MarchProgram>> programs;
  GLuint vertex_array = 0;

  explicit Impl(const ContextOptions& options) : context(options) {
    glCreateVertexArrays(1, &vertex_array);
  }
  ~Impl() {
    context.make_current();
    glDeleteVertexArrays(1, &vertex_array);
  }

  const gl::MarchProgram& program(const gl::ProgramKey& key);
  void draw(const gl::MarchProgram& program, int width, int height) const;
};

/// The program for a key, built once a process.
const gl::MarchProgram& GlRenderer::Impl::program(const gl::ProgramKey& key) {
  auto& slot = programs[key.prelude()];
  if (!slot) {
    slot = std::make_unique<gl::MarchProgram>(key);
    context.check("building the march's shader");
  }
  return *slot;
}

void GlRenderer::Impl::draw(const gl::MarchProgram& march, int width, int height) const {
  glBindVertexArray(vertex_array);
  glUseProgram(march.program().id());
  glViewport(0, 0, width, height);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

GlRenderer::GlRenderer(const ContextOptions& options) {
  const Stopwatch watch;
  impl_ = std::make_unique<Impl>(options);
  impl_->context.release();
  impl_->init_ms = watch.ms();
}

GlRenderer::~GlRenderer() = default;

std::string GlRenderer::description() const {
  impl_->context.make_current();
  return impl_->context.renderer() + ", " + impl_->context.version();
}

void GlRenderer::upload(const MediumAtlas& atlas, Filter filter) {
  const Stopwatch watch;
  Impl& impl = *impl_;
  impl.context.make_current();
  int needed = gl::MarchProgram::first_grid_unit;
  const auto copy = [&](std::unique_ptr<gl::AtlasTextures>& textures, const BrickAtlas* grid) {
    textures.reset();
    if (!grid) return;
    textures = std::make_unique<gl::AtlasTextures>(*grid, filter);
    needed += textures->units();
  };
  copy(impl.density, &atlas.density);
  copy(impl.luminance, atlas.luminance ? &*atlas.luminance : nullptr);
  copy(impl.emission, atlas.emission ? &*atlas.emission : nullptr);
  copy(impl.gradient, atlas.gradient ? &*atlas.gradient : nullptr);
  impl.context.check("copying the atlas");
  GLint units = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  if (needed > units)
    throw Error(ExitCode::graphics, "the atlas takes " + std::to_string(needed) +
                                        " textures, and the device has " + std::to_string(units) +
                                        "; a coarser grid needs fewer");
  glFinish();
  impl.atlas = &atlas;
  impl.filter = filter;
  impl.upload_ms = watch.ms();
}

LightDepths GlRenderer::light_depths(const View& view) {
  Impl& impl = *impl_;
  impl.context.make_current();
  if (!impl.density || impl.filter != Filter::exact)
    throw Error(ExitCode::failure, "light needs an upload for exact filtering");
  const auto pass =
      std::make_shared<const gl::LightPass>(view, *impl.atlas, *impl.density, impl.gradient.get());
  return [&impl, pass](std::span<const glm::ivec3> origins) {
    impl.context.make_current();
    std::vector<double> depths = pass->depths(origins);
    impl.context.check("lighting");
    return depths;
  };
}

RenderResult GlRenderer::render(const View& view, const RenderOptions& options) {
  Impl& impl = *impl_;
  impl.context.make_current();
  if (!impl.density || impl.filter != view.scene.filter)
    throw Error(ExitCode::failure, "render needs an upload for the same filter");

  MarchSetup setup = make_march_setup(view, *impl.atlas, options);
  const int pass_turns = gl::turns_per_pass(setup);
  const gl::AtlasTextures* grids[] = {impl.density.get(), impl.luminance.get(), impl.emission.get(),
                                      impl.gradient.get()};
  gl::ProgramKey key{setup.constants};
  for (int i = 0; i < 4; ++i) {
    if (!grids[i]) continue;
    key.buffers[i] = grids[i]->buffers();
    // of grids with several buffers it is the device's limit
    key.texels_per_buffer = std::max(key.texels_per_buffer, grids[i]->texels_per_buffer());
  }
  key.resumable = setup.parameters.max_turns > pass_turns;
  setup.parameters.max_turns = std::min(setup.parameters.max_turns, pass_turns);

  RenderResult result;
  RenderStats& stats = result.stats;
  stats.renderer = description();
  stats.gl_init_ms = impl.init_ms;
  stats.upload_ms = impl.upload_ms;

  const Stopwatch building;
  const gl::MarchProgram& march = impl.program(key);
  march.configure(setup);
  const gl::Tables tables(setup.tables);
  tables.bind(gl::MarchProgram::tables_unit);
  for (int i = 0; i < 4; ++i)
    if (grids[i]) grids[i]->bind(march.grid_unit(i));

  int side = key.resumable || options.tile_ms < 100 ? 64 : 512;
  const bool want_layers = options.count || options.depth || options.transmittance;
  auto target = std::make_unique<gl::TileTarget>(side, key.resumable, want_layers);
  // Drivers compile at the first draw: one pixel, so that the march's time is the march's.
  target->bind(0);
  march.program().set("first_pass", 1);
  impl.draw(march, 1, 1);
  glFinish();
  impl.context.check("compiling the march's shader");
  stats.shader_ms = building.ms();

  const Stopwatch marching;
  gl::Timer timer(stats.renderer);
  const glm::ivec2 size = view.scene.resolution;
  const int samples = view.scene.pixel_samples;
  Film film(view, options);
  Readback readback(film, samples);
  std::uint64_t pixels_done = 0;
  const auto finish = [&](const Exposure& tile) {
    readback.develop(tile);
    if (tile.sample + 1 < samples) return;
    pixels_done += tile.pixels();
    if (options.tile) options.tile({tile.x, tile.y, tile.width, tile.height, film.picture()});
    if (options.progress) options.progress(double(pixels_done) / (double(size.x) * double(size.y)));
  };
  std::optional<Exposure> read;  // but not finished: that is done while the next one is drawn
  for (int y = 0; y < size.y;) {
    // A row of tiles keeps its height; the side follows the time between rows.
    const int height = std::min(side, size.y - y);
    double slowest_ms = 0;
    for (int x = 0; x < size.x; x += side) {
      const Stopwatch drawing;
      Exposure tile{x, y, std::min(side, size.x - x), height};
      march.program().set("tile_origin", glm::ivec2(x, y));
      for (; tile.sample < samples; ++tile.sample) {
        march.program().set("given.sample_offset", pixel_sample(tile.sample, samples));
        int passes = 0;
        do {
          if (passes > 0) timer.awaited();
          target->bind(passes & 1);
          march.program().set("first_pass", passes == 0);
          timer.begin();
          impl.draw(march, tile.width, tile.height);
          timer.submitted();
          ++passes;
        } while (key.resumable && !target->all_done(tile.width, tile.height, (passes - 1) & 1));
        stats.passes = std::max(stats.passes, passes);
        if (read) finish(*read);
        timer.awaited();
        target->bind((passes - 1) & 1);
        readback.read(*target, tile);
        read = tile;
        impl.context.check("marching");
      }
      slowest_ms = std::max(slowest_ms, drawing.ms());
    }
    y += height;
    const int next = next_side(side, slowest_ms, options.tile_ms);
    if (next != side && y < size.y) {
      side = next;
      target = std::make_unique<gl::TileTarget>(side, key.resumable, want_layers);
    }
  }
  if (read) finish(*read);
  stats.march_ms = marching.ms();
  stats.gpu_ms = timer.sum_ms();
  stats.cpu_ms = marching.cpu_ms();
  result.image = film.finish(stats);
  return result;
}

}  // namespace psivox
