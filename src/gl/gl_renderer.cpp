#include "gl/gl_renderer.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "base/stopwatch.h"
#include "gl/egl_context.h"
#include "gl/grid_textures.h"
#include "gl/picture_pass.h"
#include "gl/tiles.h"
#include "march/light_lattice.h"
#include "psivox/error.h"

namespace psivox {
namespace gl {

/// light.frag over a view's density: exact optical depths from voxels towards the light. Needs a
/// current context for its whole life.
class LightPass {
 public:
  /// `setup`: of light_march. The program is light.frag by the textures' key for it. All must stay
  /// until the last use.
  LightPass(const MarchSetup& setup, const GridTextures& textures, const MarchProgram& program);

  void depths(LightBlocks blocks, const TakeDepths& take, const Progress& progress);
  /// Rays that no longer advanced and were ended early.
  std::uint64_t stuck() const { return stuck_; }

 private:
  static constexpr int side = 512;  ///< of the target: the voxels of a block, and blocks at a time

  const MarchSetup& setup_;
  const GridTextures& textures_;
  const MarchProgram& march_;
  TileTarget target_;
  EachPixel pixels_;
  std::uint64_t stuck_ = 0;
};

LightPass::LightPass(const MarchSetup& setup, const GridTextures& textures,
                     const MarchProgram& program)
    : setup_(setup),
      textures_(textures),
      march_(program),
      target_(side, march_.key().resumable, false) {
  march_.configure(setup_);
  march_.program().set("blocks_first", int(setup_.tables.size()));
}

void LightPass::depths(LightBlocks blocks, const TakeDepths& take, const Progress& progress) {
  textures_.bind(march_);
  std::vector<glm::vec4> picture(std::size_t(side) * side);
  in_batches(blocks, progress, [&](std::size_t first, std::size_t end) {
    std::vector<glm::vec4> entries = setup_.tables;
    for (std::size_t block = first; block < end; ++block)
      entries.emplace_back(glm::vec3(blocks[block] - setup_.origin), 0.f);
    const Tables tables(entries);
    tables.bind(MarchProgram::tables_unit);
    const int rows = int(end - first);
    const int passes =
        target_.draw_passes(march_, side, rows, [&] { pixels_.run(march_.program(), side, rows); });
    target_.bind((passes - 1) & 1);
    target_.read_picture(side, rows, picture.data(), side);
    std::vector<double> depths(side);
    for (std::size_t k = 0; k < end - first; ++k) {
      for (std::size_t i = 0; i < side; ++i) {
        depths[i] = double(picture[k * side + i].x);
        stuck_ += picture[k * side + i].w > 0;
      }
      take(first + k, depths);
    }
  });
}

}  // namespace gl

static constexpr auto light_needs = "light needs an upload for exact filtering";

struct GlRenderer::Impl {
  gl::EglContext context;
  double init_ms = 0;
  double upload_ms = 0;
  std::uint64_t stuck = 0;             ///< rays towards the next picture's light
  const MediumAtlas* atlas = nullptr;  ///< that upload() was given, for that filter
  Filter filter = Filter::exact;
  std::optional<gl::GridTextures> textures;  ///< of it, made for the first program that reads them
  std::map<std::string, std::unique_ptr<gl::MarchProgram>> programs;

  explicit Impl(const ContextOptions& options) : context(options) {}
  ~Impl() {
    try {
      context.make_current();
    } catch (const Error&) {  // lost: there is nothing to delete
    }
  }

  /// The atlas of an upload for that filter.
  const MediumAtlas& given(Filter wanted, const char* what) const {
    if (atlas && filter == wanted) return *atlas;
    throw Error(ExitCode::failure, what);
  }

  /// Its textures. Makes the context current.
  const gl::GridTextures& uploaded(Filter wanted, const char* what) {
    given(wanted, what);
    context.make_current();
    if (textures) return *textures;
    const Stopwatch watch;
    textures.emplace(*atlas, filter);
    context.check("copying the atlas");
    glFinish();
    upload_ms = watch.ms();
    return *textures;
  }

  /// The program for a key, built once a process.
  const gl::MarchProgram& program(const gl::ProgramKey& key,
                                  const std::string& shader = "march.frag") {
    auto& slot = programs[shader + "\n" + key.prelude()];
    if (!slot) {
      slot = std::make_unique<gl::MarchProgram>(key, shader);
      context.check("building the march's shader");
    }
    return *slot;
  }
};

GlRenderer::GlRenderer(const ContextOptions& options) {
  const Stopwatch watch;
  impl_ = std::make_unique<Impl>(options);
  impl_->context.release();
  impl_->init_ms = watch.ms();
}

GlRenderer::~GlRenderer() = default;

void GlRenderer::release() { impl_->context.release(); }

std::string GlRenderer::description() const {
  impl_->context.make_current();
  return impl_->context.renderer() + ", " + impl_->context.version();
}

bool GlRenderer::draws_in_place() const {
  impl_->context.make_current();
  return gl::draws_from_host();
}

void GlRenderer::upload(const MediumAtlas& atlas, Filter filter) {
  Impl& impl = *impl_;
  if (impl.textures) {
    impl.context.make_current();
    impl.textures.reset();
  }
  impl.atlas = &atlas;
  impl.filter = filter;
}

LightDepths GlRenderer::light_depths(const View& view) {
  return one_by_one([&view, this](const Beam& beam, LightBlocks blocks, const TakeDepths& take,
                                  const Progress& progress) {
    Impl& impl = *impl_;
    if (beam.method.spacing > 0) {
      const MediumAtlas& atlas = impl.given(Filter::exact, light_needs);
      const LatticeFrame frame(view, atlas.density.domain, beam);
      return lattice_depths(frame, atlas, blocks, light_columns(frame, view, beam), take, progress);
    }
    const gl::GridTextures& textures = impl.uploaded(Filter::exact, light_needs);
    MarchSetup setup = make_march_setup(light_march(view, beam), textures.atlas());
    const gl::MarchProgram& program = impl.program(textures.key(setup), "light.frag");
    gl::LightPass pass(setup, textures, program);
    pass.depths(blocks, take, progress);
    impl.stuck += pass.stuck();
    impl.context.check("lighting");
  });
}

LatticeColumns GlRenderer::light_columns(const LatticeFrame& frame, const View& view,
                                         const Beam& beam) {
  return psivox::light_columns<float>(frame, view, impl_->given(Filter::exact, light_needs), beam);
}

RenderResult GlRenderer::render(const View& view, const RenderOptions& options) {
  Impl& impl = *impl_;
  const gl::GridTextures& textures =
      impl.uploaded(view.scene.filter, "render needs an upload for the same filter");
  RenderResult result;
  RenderStats& stats = result.stats;
  stats.renderer = description();
  stats.gl_init_ms = impl.init_ms;
  stats.upload_ms = impl.upload_ms;
  stats.stuck = std::exchange(impl.stuck, 0);

  const Stopwatch building;
  const auto pass_of = [&](const View& drawn, const RenderOptions& how) {
    MarchSetup setup = make_march_setup(drawn, textures.atlas(), how);
    const int turns = setup.parameters.max_turns;
    const gl::MarchProgram& march = impl.program(textures.key(setup));
    const int passes = 1 + (turns - 1) / setup.parameters.max_turns;
    return std::make_unique<gl::PicturePass>(impl.context, textures, march, std::move(setup), drawn,
                                             how, passes);
  };
  RenderOptions of_pilot = options;
  of_pilot.tile = {};
  of_pilot.progress = {};
  std::unique_ptr<gl::PicturePass> pilot;
  if (options.pilot) pilot = pass_of(*options.pilot, of_pilot);
  const auto picture = pass_of(view, options);
  stats.shader_ms = building.ms();

  const Stopwatch marching;
  if (pilot) pilot->begin();
  result.image = picture->draw(stats);
  RenderStats ignored;
  if (pilot) result.pilot = pilot->draw(ignored);
  stats.march_ms = marching.ms();
  stats.cpu_ms = marching.cpu_ms();
  return result;
}

}  // namespace psivox

namespace psivox::gl {
namespace {

/// Names in use. A driver gives out the lowest free name, or the one after the highest there ever
/// was: all are below a new one, or with no wide gap behind it.
template <typename IsObject>
int count_names(GLuint fresh, const IsObject& is_object) {
  constexpr int widest_gap = 512;
  int count = 0, gap = 0;
  for (GLuint name = 1; name < fresh || gap < widest_gap; ++name) {
    const bool there = is_object(name);
    gap = there ? 0 : gap + 1;
    count += there;
  }
  return count;
}

template <typename Generate, typename Delete, typename IsObject>
int count_generated(const Generate& generate, const Delete& remove, const IsObject& is_object) {
  GLuint fresh = 0;
  generate(1, &fresh);
  remove(1, &fresh);
  return count_names(fresh, is_object);
}

}  // namespace

ObjectCounts count_objects() {
  const GLuint fresh = glCreateProgram();  // shaders have the same names
  glDeleteProgram(fresh);
  return {count_generated(glGenTextures, glDeleteTextures, glIsTexture),
          count_generated(glGenBuffers, glDeleteBuffers, glIsBuffer),
          count_generated(glGenFramebuffers, glDeleteFramebuffers, glIsFramebuffer),
          count_generated(glGenVertexArrays, glDeleteVertexArrays, glIsVertexArray),
          count_generated(glGenQueries, glDeleteQueries, glIsQuery),
          count_names(fresh, glIsProgram),
          count_names(fresh, glIsShader)};
}

}  // namespace psivox::gl
