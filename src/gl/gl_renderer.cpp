#include <algorithm>
#include <map>

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
#include "psivox/renderer.h"
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

  const gl::MarchProgram& program(const gl::MarchVariant& variant);
  void draw(const gl::MarchProgram& program, int width, int height) const;
};

/// The program for a variant, built once a process.
const gl::MarchProgram& GlRenderer::Impl::program(const gl::MarchVariant& variant) {
  auto& slot = programs[variant.prelude()];
  if (!slot) {
    slot = std::make_unique<gl::MarchProgram>(variant);
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

void GlRenderer::upload(const MediumAtlas& atlas, Filter filter, std::uint64_t max_buffer_texels) {
  const Stopwatch watch;
  Impl& impl = *impl_;
  impl.context.make_current();
  int needed = gl::MarchProgram::first_grid_unit;
  const auto copy = [&](std::unique_ptr<gl::AtlasTextures>& textures, const BrickAtlas* grid) {
    textures.reset();
    if (!grid) return;
    textures = std::make_unique<gl::AtlasTextures>(*grid, filter, max_buffer_texels);
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

LightDepths GlRenderer::light_depths(const View& view, int max_turns) {
  Impl& impl = *impl_;
  impl.context.make_current();
  if (!impl.density || impl.filter != Filter::exact)
    throw Error(ExitCode::failure, "light needs an upload for exact filtering");
  const auto pass = std::make_shared<const gl::LightPass>(view, *impl.atlas, *impl.density,
                                                          impl.gradient.get(), max_turns);
  return [&impl, pass](std::span<const glm::ivec3> origins) {
    impl.context.make_current();
    std::vector<double> depths = pass->depths(origins);
    impl.context.check("lighting");
    return depths;
  };
}

RenderResult GlRenderer::render(const View& view, const RenderOptions& options, int max_turns) {
  Impl& impl = *impl_;
  impl.context.make_current();
  if (!impl.density || impl.filter != view.scene.filter)
    throw Error(ExitCode::failure, "render needs an upload for the same filter");

  MarchSetup setup = make_march_setup(view, *impl.atlas, options.may_update_tables);
  setup.constants.count_steps = options.count;
  setup.constants.find_depth = options.depth;
  const int pass_turns = max_turns ? max_turns : gl::turns_per_pass(setup);
  const gl::AtlasTextures* grids[] = {impl.density.get(), impl.luminance.get(), impl.emission.get(),
                                      impl.gradient.get()};
  gl::MarchVariant variant{setup.constants};
  for (int i = 0; i < 4; ++i) {
    if (!grids[i]) continue;
    variant.buffers[i] = grids[i]->buffers();
    // of grids with several buffers it is the device's limit
    variant.texels_per_buffer = std::max(variant.texels_per_buffer, grids[i]->texels_per_buffer());
  }
  variant.resumable = setup.parameters.max_turns > pass_turns;
  setup.parameters.max_turns = std::min(setup.parameters.max_turns, pass_turns);

  RenderResult result;
  RenderStats& stats = result.stats;
  stats.renderer = description();
  stats.gl_init_ms = impl.init_ms;
  stats.upload_ms = impl.upload_ms;

  const Stopwatch building;
  const gl::MarchProgram& march = impl.program(variant);
  march.configure(setup.parameters);
  const gl::Tables tables(setup.tables);
  tables.bind(gl::MarchProgram::tables_unit);
  for (int i = 0; i < 4; ++i)
    if (grids[i]) grids[i]->bind(march.grid_unit(i));

  int side = variant.resumable || options.tile_ms < 100 ? 64 : 256;
  auto target = std::make_unique<gl::TileTarget>(side, variant.resumable);
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
  const bool want_layers = options.count || options.depth || options.transmittance;
  Film film(view, options);
  std::vector<PixelSums> sums;
  std::vector<glm::vec4> picture, layers;
  std::uint64_t pixels_done = 0;
  for (int y = 0; y < size.y;) {
    // A row of tiles keeps its height; the side follows the time between rows.
    const int height = std::min(side, size.y - y);
    double slowest_ms = 0;
    for (int x = 0; x < size.x; x += side) {
      const Stopwatch drawing;
      const int width = std::min(side, size.x - x);
      sums.assign(std::size_t(width) * std::size_t(height), {});
      march.program().set("tile_origin", glm::ivec2(x, y));
      for (int i = 0; i < samples; ++i) {
        march.program().set("sample_offset", pixel_sample(i, samples));
        int passes = 0;
        do {
          const int set = passes & 1;
          target->bind(set);
          march.program().set("first_pass", passes == 0);
          timer.begin();
          impl.draw(march, width, height);
          timer.end();
          ++passes;
        } while (variant.resumable && !target->all_done(width, height, (passes - 1) & 1));
        stats.passes = std::max(stats.passes, passes);
        target->bind((passes - 1) & 1);
        target->read_picture(width, height, picture);
        if (want_layers)
          target->read_layers(width, height, layers);
        else
          layers.assign(picture.size(), glm::vec4(0));
        for (std::size_t k = 0; k < sums.size(); ++k)
          sums[k].add(glm::dvec4(picture[k]), glm::dvec4(layers[k]));
      }
      impl.context.check("marching");
      for (int k = 0; k < width * height; ++k)
        film.set(x + k % width, y + k / width, sums[std::size_t(k)]);
      slowest_ms = std::max(slowest_ms, drawing.ms());
      pixels_done += sums.size();
      if (options.tile) options.tile({x, y, width, height, film.picture()});
      if (options.progress)
        options.progress(double(pixels_done) / (double(size.x) * double(size.y)));
    }
    y += height;
    const int next = next_side(side, slowest_ms, options.tile_ms);
    if (next != side && y < size.y) {
      side = next;
      target = std::make_unique<gl::TileTarget>(side, variant.resumable);
    }
  }
  stats.march_ms = marching.ms();
  stats.gpu_ms = timer.sum_ms();
  stats.cpu_ms = marching.cpu_ms();
  result.image = film.finish(stats);
  return result;
}

}  // namespace psivox
