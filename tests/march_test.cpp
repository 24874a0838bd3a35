// Compares the GPU's march with the same march in double (arithmetic error) and with the reference
// (step error), on fields made here.

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "made_fields.h"
#include "march_cases.h"

namespace psivox {
namespace {

class March : public GpuTest {};

const glm::dvec3 eye_outside(95, 60, 70), blobs_middle(11, 12, 11);

Scene coloured() {
  Scene scene = oblique(64, 0.12);
  scene.luminance = {1, 0.5, 0.25};
  return scene;
}

/// A luminance grid with rotated voxels of another size that covers part of the density.
glm::dmat4 tilted() {
  glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(-18, -20, -14));
  m = glm::rotate(m, 0.3, glm::dvec3(1, 2, 0.5));
  return glm::scale(m, glm::dvec3(2.3, 1.7, 1.9));
}
Field scalar_glow() {
  return make_field(
      {{0, 0, 0}, {24, 24, 24}}, [](glm::ivec3 v) { return 0.3f + blobs_at(glm::dvec3(v) * 1.5); },
      tilted());
}
Field vector_glow() {
  return make_vector_field(
      {{0, 0, 0}, {24, 24, 24}},
      [](glm::ivec3 v) {
        if (v.x >= 16) return glm::vec3(0.3f, 0.5f, 0.9f);  // bricks of one colour
        return glm::vec3(noise(v), 0.5f * blobs_at(glm::dvec3(v)), 0.04f * float(v.x));
      },
      tilted());
}

enum class Source { constant, density, scalar, vector };

View scene_of(const Scene& scene, Source source) {
  switch (source) {
    case Source::constant:
      return view_of(scene, mixed());
    case Source::density:
      return view_of(scene, mixed(), Glow::density);
    case Source::scalar:
      return view_of(scene, mixed(), scalar_glow());
    case Source::vector:
      return view_of(scene, mixed(), vector_glow());
  }
  throw std::logic_error("no such source");
}

void expect_arithmetic(const std::string& what, const View& view) {
  psivox::expect_arithmetic(what, view, build_medium_atlas(view));
}

const char* source_names[] = {"constant", "density", "scalar", "vector"};
constexpr Source every_source[] = {Source::constant, Source::density, Source::scalar,
                                   Source::vector};

TEST_F(March, GpuIsTheMarchInDouble) {
  // A source gives its luminance at a segment's ends, in its middle or along a cell: a rule of each
  // kind reads all of it.
  const auto reads_any = [](Integrator rule) {
    return rule == Integrator::psi_weighted || rule == Integrator::midpoint || is_cell_rule(rule);
  };
  for (const IntegratorInfo& rule : integrators)
    for (const Source source : every_source)
      for (const double step : {0.0, 0.7, 3.0}) {
        if (is_transfer_rule(rule.id) || (step > 0 && is_cell_rule(rule.id))) continue;
        if (source != Source::density && !reads_any(rule.id)) continue;
        const auto own_step = step > 0 ? std::optional(step) : std::nullopt;
        expect_arithmetic(std::string(source_names[int(source)]) + " " + rule.name +
                              (own_step ? " step " : " cells ") + std::to_string(step),
                          scene_of(with(coloured(), rule.id, own_step), source));
      }
}

TEST_F(March, GpuIsTheMarchInDoubleInEveryTexelCameraAndCell) {
  Scene inside = looking(coloured(), {12.3, 9.1, 10.7}, {-20, 14, 2});
  inside.fov = 100;
  std::vector<std::pair<std::string, Scene>> ways{
      {"inside", inside}, {"orthographic", looking(coloured(), eye_outside, blobs_middle, 70.0)}};
  for (const int segments : {1, 4, 7}) {
    ways.emplace_back("segments " + std::to_string(segments), coloured());
    ways.back().second.segments = segments;
  }
  for (auto& [name, scene] : ways) {
    expect_arithmetic(name, scene_of(scene, Source::density));
    expect_arithmetic(name + ", own grid", scene_of(scene, Source::vector));
    scene.step = 0.8;
    expect_arithmetic(name + ", uniform", scene_of(scene, Source::vector));
  }
}

TEST_F(March, EarlyTerminationStopsAlike) {
  Scene scene = coloured();
  scene.extinction = 2;
  scene.early_termination = Scene{}.early_termination;
  const View view = scene_of(scene, Source::density);
  // Either may stop a segment later: that segment holds at most 1/16384 of the light.
  const MediumAtlas atlases = build_medium_atlas(view);
  const Comparison c =
      difference("terminated", render_gl(view, atlases).image, render_double(view, atlases).image);
  EXPECT_LE(c.max, 2 * Scene{}.resolved_early_termination());
  EXPECT_LE(c.rms, 5e-6);
}

// --- against the reference -----------------------------------------------------------------------

TEST_F(March, CellsAreTheReferenceForConstantLuminance) {
  // Simpson's rule is exact for a cell's cubic, whatever rule is given its depth: only float32
  // rounding remains, most of it the ray's place.
  for (const Integrator rule : {Integrator::psi_weighted, Integrator::cell_exact})
    for (const bool inside : {false, true}) {
      Scene scene = with(coloured(), rule, {});
      if (inside) scene = looking(scene, {12.3, 9.1, 10.7}, {-20, 14, 2});
      const View view = scene_of(scene, Source::constant);
      const Comparison c = difference(std::string(info(rule).name) + (inside ? " inside" : ""),
                                      gl_picture(view), render_reference(view).image);
      EXPECT_LE(c.max, 1e-6 * quotient_errors());
    }
}

TEST_F(March, CellsConvergeToTheReferenceForLuminanceFromGrids) {
  // Step error, in double. Doubling the segments divides it by four if L is a polynomial in the
  // cell; 0.45 allows for cells too opaque to be in the asymptotic range. If the luminance grid has
  // its own lattice, its kinks lie anywhere in a cell: second order still holds overall.
  for (const Source source : {Source::density, Source::scalar, Source::vector}) {
    Scene scene = coloured();
    scene.luminance = {1, 1, 1};
    View view = scene_of(scene, source);
    const Image reference = render_reference(view).image;
    double last = HUGE_VAL;
    for (const int segments : {1, 2, 4, 8}) {
      view.scene.segments = segments;
      const double rms = difference(std::string(source_names[int(source)]) + " segments " +
                                        std::to_string(segments),
                                    double_picture(view), reference)
                             .rms;
      EXPECT_LE(rms, 0.45 * last);
      last = rms;
    }
    EXPECT_LE(last, 2e-4);
  }
}

TEST_F(March, CellExactIsFarMoreExactThanSegments) {
  // Three nodes are exact for polynomials of degree 5. L tau has degree 6 here, and its error is x
  // q_3^2/2800 per cell: about 1e-5 on this rough field. Two linear segments leave a second-order
  // error instead. At least a factor of 40 lies between them; 76 and more were measured.
  for (const double extinction : {0.05, 0.5, 5.0, 500.0})
    for (const bool inside : {false, true}) {
      const auto error = [&](Integrator rule) {
        Scene scene = with(coloured(), rule, {});
        scene.extinction = extinction;
        if (inside) scene = looking(scene, {12.3, 9.1, 10.7}, {-20, 14, 2});
        const View view = scene_of(scene, Source::density);
        return difference(
            std::string(info(rule).name) + ", extinction " + std::to_string(extinction),
            gl_picture(view), render_reference(view).image);
      };
      const Comparison exact = error(Integrator::cell_exact);
      EXPECT_LE(exact.rms, std::max(error(Integrator::psi_weighted).rms / 40, 1e-6));
      EXPECT_LE(exact.channel_rms[3], 1e-6);  // float32, as for any cells
    }
}

// --- filtering in hardware -----------------------------------------------------------------------

TEST_F(March, HardwareFilterIsNearTheExactOne) {
  // GL requires at least 8 bits for the fraction of a filter weight. Half of the last bit along
  // each axis changes the value by at most 3/512 of its range. It changes the picture's optical
  // depth by K length 3/512, and its opacity by that times T: x e^{-x} <= 1/e of 3/512 times range
  // over mean. llvmpipe weighs in float32, with 1e-5 from normalised coordinates.
  const std::pair<Source, double> cases[] = {
      {Source::density, 0}, {Source::density, 0.5}, {Source::vector, 0}, {Source::scalar, 0.5}};
  for (const auto& [source, step] : cases) {
    Scene scene = coloured();
    scene.luminance = {1, 1, 1};
    if (step > 0) scene.step = step;
    const Image exact = gl_picture(scene_of(scene, source));
    scene.filter = Filter::hardware;
    const Image hardware = gl_picture(scene_of(scene, source));
    const Comparison c = difference(
        std::string("hardware ") + source_names[int(source)] + (step > 0 ? " uniform" : " cells"),
        exact, hardware);
    // Range over mean along a ray is at most 8 here (values up to 2, means from 0.25 on); L
    // doubles it.
    EXPECT_LE(c.max, 2 * 8 * 3.0 / 512 / 2.718);
    EXPECT_LE(c.rms, 3e-3);
  }
}

// --- media with known integrals, by every rule ---------------------------------------------------

class MarchAnalytic : public GpuTest {};

/// Luminance 1 everywhere gives the opacity as radiance, for any attenuation, rule, step and
/// camera.
TEST_F(MarchAnalytic, Furnace) {
  const auto density = share(mixed()), ones = share(ones_around_mixed());
  for (const IntegratorInfo& rule : integrators)
    for (const glm::dvec3& from : {glm::dvec3(90, 60, 75), {12.3, 9.1, 10.7}})
      for (const double step : {0.0, 0.1, 0.73, 1.0, 3.7, 16.0}) {
        if (is_transfer_rule(rule.id) || (step > 0 && is_cell_rule(rule.id))) continue;
        Scene scene = looking(small_scene(32, 0.15), from, {11, 12, 8});
        scene.early_termination = Scene{}.early_termination;
        scene = with(scene, rule.id, step > 0 ? std::optional(step) : std::nullopt);
        const View view = make_view(scene, density, ones);
        const Image image = gl_picture(view);
        expect_content(image);
        double worst = 0;
        for_pixels(view, image, [&](const WorldRay&, const float* rgba) {
          for (int c = 0; c < 3; ++c)
            worst = larger(worst, std::abs(double(rgba[c]) - double(rgba[3])));
        });
        EXPECT_LE(worst, 1e-6) << rule.name << " step " << step << " from " << from.x;
      }
}

TEST_F(MarchAnalytic, Walls) {
  // Attenuation and L rise from 0 within one voxel, up to a million optical depths. Nothing goes
  // through, and R = sqrt(pi / (2 K)), the integral of x K x e^{-K x^2/2}. Rules of linear segments
  // see a front segment of the ramp as a whole: their result only has to lie between its L and 0.
  const auto wall =
      share(make_field({{1, -20, -20}, {12, 20, 20}}, [](glm::ivec3) { return 1.0f; }));
  for (const double K : {1e2, 1e4, 1e6})
    for (const IntegratorInfo& rule : integrators) {
      if (is_transfer_rule(rule.id)) continue;
      Scene scene = looking(small_scene(4), {-10, 0.3, 0.2}, {0, 0.3, 0.2}, 4.0);
      scene.extinction = K;
      scene.integrator = rule.id;
      const Image image = gl_picture(view_of(scene, wall, Glow::density));
      const double expected = std::sqrt(std::numbers::pi / (2 * K));
      std::printf("  K %g %s: A %.7f R %.3e (exact %.3e)\n", K, rule.name, pixel(image, 1, 1, 3),
                  pixel(image, 1, 1, 0), expected);
      EXPECT_NEAR(pixel(image, 1, 1, 3), 1, 1e-6) << rule.name << ' ' << K;
      EXPECT_GE(pixel(image, 1, 1, 0), 0) << rule.name << ' ' << K;
      EXPECT_LE(pixel(image, 1, 1, 0), 1) << rule.name << ' ' << K;
      if (is_cell_rule(rule.id)) {
        EXPECT_NEAR(pixel(image, 1, 1, 0) / expected, 1, 1e-3) << K;
      }
    }
}

}  // namespace
}  // namespace psivox
