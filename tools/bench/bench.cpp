// bench [-s STEP] [FILE.vdb ...]: compares psivox with a dense-texture ray marcher in one process,
// both with the same step (default 1). The variants of a scene take turns; results are medians. It
// also prints the conversion rate and the size of the atlas. Without files it draws only the fog.
// Ratios mean something on any machine, milliseconds only on a quiet one.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "base/stopwatch.h"
#include "base/text.h"
#include "bench.h"
#include "dense_shader.h"
#include "field/dense_values.h"
#include "gl/egl_context.h"
#include "gl/march_program.h"
#include "gl/program.h"
#include "gl/tiles.h"
#include "march/medium_atlas.h"
#include "psivox/draw.h"

namespace {

using namespace psivox;
using bench::median;

/// The baseline that psivox is measured against: dense.frag over one dense 3D texture of the domain
/// in float32, drawn as one tile.
class DenseRenderer {
 public:
  DenseRenderer(const Field& field, int side) : context_({}), target_(side, false, false) {
    const Box domain = field.domain();
    const glm::ivec3 size = domain.max - domain.min + 1;
    std::vector<float> values(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    write_dense(field, domain, values.data());

    glCreateTextures(GL_TEXTURE_3D, 1, &volume_);
    glTextureStorage3D(volume_, 1, GL_R32F, size.z, size.y, size.x);
    glTextureParameteri(volume_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(volume_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureSubImage3D(volume_, 0, 0, 0, 0, size.z, size.y, size.x, GL_RED, GL_FLOAT,
                        values.data());
    context_.check("copying the dense volume");
  }

  ~DenseRenderer() {
    context_.make_current();
    glDeleteTextures(1, &volume_);
  }

  /// Draws the view and reads it back; returns milliseconds. Luminance is constant or the density
  /// grid.
  double render(const View& view, const MediumAtlas& atlas) {
    context_.make_current();
    const MarchSetup setup = make_march_setup(view, atlas);
    const std::string prelude =
        gl::common_prelude(gl::driver_is_software()) +
#define GRID(id, name) "const int " #name "_buffers = 1;\n"
#include "grids.glsl"
#undef GRID
        "const int texels_per_buffer = 1;\n"
        "#define HARDWARE_FILTER " +
        std::to_string(setup.constants.hardware_filter) + "\n#define LUMINANCE_DENSITY " +
        std::to_string(view.medium.source == LuminanceSource::density) + "\n";
    auto& program = programs_[prelude];
    if (!program)
      program = std::make_unique<gl::Program>(
          "dense.frag", prelude,
          std::map<std::string, std::string>{{"dense.frag", bench::dense_shader}});
    gl::set_parameters(*program, setup.parameters);
    program->set("tile_origin", glm::ivec2(0));
    program->set("volume", 0);

    const glm::ivec2 size = view.scene.resolution;
    const Stopwatch watch;
    target_.bind(0);
    glBindTextureUnit(0, volume_);
    triangle_.draw(*program, size.x, size.y);
    std::vector<glm::vec4> picture(std::size_t(size.x) * std::size_t(size.y));
    target_.read_picture(size.x, size.y, picture.data(), size.x);
    context_.check("drawing the dense volume");
    return watch.ms();
  }

 private:
  gl::EglContext context_;
  gl::TileTarget target_;
  gl::Triangle triangle_;
  GLuint volume_ = 0;
  std::map<std::string, std::unique_ptr<gl::Program>> programs_;
};

struct Variant {
  std::string name;
  std::function<double()> draw;  ///< milliseconds
  std::vector<double> times{};
  std::vector<double> work{};  ///< processor milliseconds
};

constexpr int side = 512;
constexpr int rounds = 9;

void run_interleaved(std::vector<Variant>& variants) {
  for (Variant& v : variants) v.draw();  // compiles
  for (int i = 0; i < rounds; ++i)
    for (Variant& v : variants) {
      const Stopwatch watch;
      v.times.push_back(v.draw());
      v.work.push_back(watch.cpu_ms());
    }
}

void bench_conversion(const Field& field) {
  std::vector<double> times;
  AtlasSize single, half;
  for (int i = 0; i < rounds; ++i) {
    const Stopwatch watch;
    single = build_atlas(field).size;
    times.push_back(watch.ms());
  }
  half = build_atlas(field, {.texel = TexelType::float16}).size;
  const double own = 4.0 * double(field.active_voxels);
  std::printf(
      "  atlas: %.1f ms, %.0f M active voxels/s; %llu bricks, %llu constants; "
      "%.2fx the active voxels' bytes (float16 %.2fx)\n",
      median(times), double(field.active_voxels) / median(times) / 1e3,
      static_cast<unsigned long long>(single.textured_bricks),
      static_cast<unsigned long long>(single.constant_bricks), double(single.bytes()) / own,
      double(half.bytes()) / own);
}

/// Prints a row for each variant; its ratios are to the dense one before it.
void print_variants(const std::vector<Variant>& variants) {
  std::printf("    %-34s %9s %9s %16s %12s %16s\n", "variant", "ms", "spread", "dense / variant",
              "CPU ms", "dense / variant");
  double baseline = 0, baseline_work = 0;
  for (const Variant& v : variants) {
    const double ms = median(v.times);
    const double work = median(v.work);
    if (v.name.starts_with("dense")) {
      baseline = ms;
      baseline_work = work;
    }
    const auto [least, most] = std::minmax_element(v.times.begin(), v.times.end());
    std::printf("    %-34s %9.1f %8.0f%% %15.2fx %12.1f %15.2fx\n", v.name.c_str(), ms,
                100 * (*most - *least) / ms, baseline / ms, work, baseline_work / work);
  }
}

void bench_march(const std::shared_ptr<const Field>& field, bool luminance_from_density,
                 double step) {
  const std::string uniform_name = formatted("uniform %g", step);
  Scene scene;
  scene.resolution = {side, side};
  if (luminance_from_density) scene.luminance_grid = field->name;
  const View base = make_view(scene, field, luminance_from_density ? field : nullptr);
  const MediumAtlas atlas = build_medium_atlas(base);
  DenseRenderer dense(*field, side);
  Session session(base);
  // one each, so that no variant uploads again in its turn
  const auto exact = open_gpu(), exact_half = open_gpu(), hardware = open_gpu();

  std::vector<Variant> variants;
  const auto view_of = [&](auto change) {
    View view = base;
    view.scene.step.reset();
    view.scene.sampling.reset();
    view.scene.integrator.reset();
    change(view.scene);
    return view;
  };
  const auto uniform = [step](Integrator rule, Filter filter) {
    return [=](Scene& s) {
      s.step = step;
      s.integrator = rule;
      s.filter = filter;
    };
  };
  const auto cells = [](Scene& s) { s.sampling = Sampling::cells; };
  const auto add = [&](const std::string& name, Marcher& gpu, const View& view,
                       TexelType texel = TexelType::float32) {
    Wish wish;
    wish.scene = view.scene;
    wish.scene->texel = texel;
    const auto draw = [&, wish] { return session.draw(gpu, wish).stats.march_ms; };
    variants.push_back({name, draw});
  };
  const auto add_dense = [&](const std::string& name, Filter filter) {
    const View view = view_of(uniform(Integrator::porter_duff, filter));
    variants.push_back({name, [&dense, &atlas, view] { return dense.render(view, atlas); }});
  };
  add_dense("dense porter-duff, exact", Filter::exact);
  add(uniform_name + " porter-duff, exact", *exact,
      view_of(uniform(Integrator::porter_duff, Filter::exact)));
  add(uniform_name + " psi-balanced, exact", *exact,
      view_of(uniform(Integrator::psi_balanced, Filter::exact)));
  add(uniform_name + " psi-balanced, float16", *exact_half,
      view_of(uniform(Integrator::psi_balanced, Filter::exact)), TexelType::float16);
  add("cells psi-weighted, exact", *exact, view_of(cells));
  add("cells psi-weighted, float16", *exact_half, view_of(cells), TexelType::float16);
  add_dense("dense porter-duff, hardware", Filter::hardware);
  add(uniform_name + " psi-balanced, hardware", *hardware,
      view_of(uniform(Integrator::psi_balanced, Filter::hardware)));
  add("cells psi-weighted, hardware", *hardware, view_of([&](Scene& s) {
        cells(s);
        s.filter = Filter::hardware;
      }));

  run_interleaved(variants);
  std::printf("  %dx%d, luminance %s, %s\n", side, side,
              luminance_from_density ? "from the grid" : "constant", description(*exact).c_str());
  print_variants(variants);
}

void bench_scene(const std::string& name, Field field, double step) {
  const auto shared = std::make_shared<const Field>(std::move(field));
  const glm::ivec3 size = shared->active_box.max - shared->active_box.min + 1;
  std::printf(
      "%s: %llu active voxels, %.1f %% of their box\n", name.c_str(),
      static_cast<unsigned long long>(shared->active_voxels),
      100.0 * double(shared->active_voxels) / (double(size.x) * double(size.y) * double(size.z)));
  bench_conversion(*shared);
  bench_march(shared, false, step);
  bench_march(shared, true, step);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const bool with_step = argc > 2 && std::string(argv[1]) == "-s";
  return bench::run("bench", [&] {
    const double step = with_step ? std::atof(argv[2]) : 1;
    bench_scene("fog", bench::make_fog(256), step);
    for (int i = with_step ? 3 : 1; i < argc; ++i) {
      const VdbFile file(argv[i]);
      bench_scene(std::filesystem::path(argv[i]).filename().string(),
                  file.read(file.default_grid()), step);
    }
  });
}
