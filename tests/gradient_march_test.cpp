// Pictures by functions of value and gradient: compares the GPU, the march in double and the
// reference.

#include <gtest/gtest.h>

#include <algorithm>

#include <span>
#include "gl/march_program.h"
#include "gradient_cases.h"
#include "light_cases.h"
#include "march/light.h"
#include "march/march_parameters.h"
#include "march_cases.h"
#include "scene/transfer_function.h"
#include "thrown.h"

namespace psivox {
namespace {

Scene scene_of(int side = 24) { return looking(small_scene(side), {60, 70, 90}, {10, 12, 11}); }

/// Bound for the GPU's arithmetic against double: RMS below 1e-6, as MATH requires of float32, plus
/// the effect of the steepest function on a value's rounding at one pixel.
void expect_same(const std::string& what, const Image& gl, const Image& reference) {
  const Comparison c = difference(what, gl, reference);
  EXPECT_LT(c.rms, 1e-6) << what;
  EXPECT_LT(c.max, 3e-5) << what;
}

class GradientMarch : public GpuTest {};

TEST_F(GradientMarch, GpuIsTheMarchInDouble) {
  for (const TransferFunction& f : {table, shells}) {
    View view = view_by(scene_of(), f, mixed());
    const auto check = [&](const std::string& what) {
      const Image gl = gl_picture(view);
      expect_content(gl);
      expect_same(what, gl, double_picture(view));
    };
    check("cells");
    view.scene.mode = Mode::back_to_front;
    check("cells back to front");
    view.scene.mode = Mode::alpha;
    view.scene.sampling = Sampling::uniform;
    for (const Integrator rule : {Integrator::psi_balanced, Integrator::midpoint}) {
      view.scene.integrator = rule;
      check("uniform");
    }
  }
}

TEST_F(GradientMarch, GpuIsTheMarchInDoubleOverTemplatesToo) {
  Scene scene = looking(small_scene(24), {60, 70, 90}, {10, 12, 11}, 60);
  scene.sampling = Sampling::template_;
  for (const TransferFunction& f : {table, shells}) {
    const View view = view_by(scene, f, mixed());
    const Image gl = gl_picture(view);
    expect_content(gl);
    expect_same("template", gl, double_picture(view));
  }
}

TEST_F(GradientMarch, PassesGoOnWhereTheyWere) {
  for (const std::optional<double> step : {std::optional<double>(), std::optional<double>(0.5)}) {
    Scene scene = scene_of();
    scene.step = step;
    const View view = view_by(scene, shells, mixed());
    const MediumAtlas atlas = build_medium_atlas(view);
    const RenderResult one = render_gl(view, atlas),
                       many =
                           render_gl(view, atlas, {.render = {}, .limits = {.turns_per_pass = 16}});
    EXPECT_GT(many.stats.passes, 1);
    expect_same("passes", many.image, one.image);
  }
}

TEST_F(GradientMarch, HardwareFilteringIsNear) {
  View view = view_by(scene_of(), table, blobs());
  const Image exact = gl_picture(view);
  view.scene.filter = Filter::hardware;
  const Comparison c = difference("hardware", gl_picture(view), exact);
  // weights of 8 bits in the worst case: 1/256 of a voxel, over the table's steepest passage of
  // 0.25 in value, here four voxels; and cubics that are quadratics
  EXPECT_LT(c.rms, 5e-3);
}

/// Order of an error that falls from `coarse` to `fine` over `halvings` halvings.
double order(double coarse, double fine, int halvings) {
  return std::log2(coarse / fine) / halvings;
}

TEST(GradientConvergence, IsOfSecondOrderTowardsTheReference) {
  for (const bool rough : {false, true})
    for (const TransferFunction& f : {table, shells}) {
      View view = view_by(scene_of(), f, rough ? mixed() : blobs());
      const RenderResult reference = render_reference(view);
      expect_content(reference.image);
      EXPECT_LT(std::ranges::max(reference.image.layers[1].values), 1e-8f);
      const auto error = [&](const char* what, double number) {
        return difference(what + std::to_string(number), double_picture(view), reference.image).rms;
      };
      std::vector<double> errors;
      for (const int n : {1, 2, 4, 8, 16}) {
        view.scene.segments = n;
        errors.push_back(error("segments ", n));
      }
      // Kinks meet the segments' ends at all phases, so the fit over four halvings has the order,
      // but not each halving. A first-order error would fall to a sixteenth.
      EXPECT_GT(order(errors.front(), errors.back(), 4), 1.6);
      std::printf("  order by segments %.2f\n", order(errors.front(), errors.back(), 4));
      view.scene.sampling = Sampling::uniform;
      view.scene.integrator = Integrator::psi_balanced;
      errors.clear();
      for (const double h : {1.0, 0.5, 0.25, 0.125}) {
        view.scene.step = h;
        errors.push_back(error("step ", h));
      }
      EXPECT_GT(order(errors.front(), errors.back(), 3), 1.6);
      std::printf("  order by steps %.2f\n", order(errors.front(), errors.back(), 3));
    }
}

TEST(GradientConvergence, HoldsInAnyTransformAndMode) {
  const glm::dvec3 middle(sheared * glm::dvec4(19, 17, 15, 1));
  Scene scene = looking(small_scene(16), middle + glm::dvec3(30, 25, 40), middle);
  // here the gradients of the blobs are about 0.1/0.5, thicknesses 0.6
  const TransferFunction thin({{0, 0, {1, 0.2, 0}}, {1, 0, {0, 0.5, 1}}}, true,
                              {.isosurfaces = {{0.3, 0.6, 1}, {0.7, 0.5, 2}}});
  for (const Mode mode : {Mode::alpha, Mode::back_to_front, Mode::xray}) {
    scene.mode = mode;
    View view = view_by(scene, thin, blobs({0, 0, 0}, sheared));
    const Image reference = render_reference(view).image;
    expect_content(reference);
    view.scene.segments = 2;
    const double coarse = difference("2", double_picture(view), reference).rms;
    view.scene.segments = 32;
    const double fine = difference("32", double_picture(view), reference).rms;
    EXPECT_GT(order(coarse, fine, 4), 1.6);
  }
}

// --- compared with functions of the value alone --------------------------------------------------

const std::vector<TransferPoint> peaks{{0.1, 0, {1, 0.2, 0}},
                                       {0.3, 0.6, {0.2, 1, 0}},
                                       {0.4, 0.05, {0, 0.5, 1}},
                                       {0.7, 0.1, {1, 1, 1}},
                                       {1.2, 0.5, {1, 0, 0.5}}};

TransferFunction by_equal_columns() {
  GradientPart part{.gradients = {0.05, 0.3}};
  for (const TransferPoint& point : peaks)
    part.attenuation.insert(part.attenuation.end(), 2, point.attenuation);
  return TransferFunction(peaks, true, part);
}

TEST_F(GradientMarch, EqualColumnsAreTheFunctionOfTheValue) {
  for (const std::optional<double> step : {std::optional<double>(), std::optional<double>(0.5)}) {
    Scene scene = scene_of();
    scene.step = step;
    const View plain = view_by(scene, TransferFunction(peaks), mixed());
    View view = view_by(scene, by_equal_columns(), mixed());
    ASSERT_TRUE(view.medium.gradient);
    expect_content(double_picture(plain));
    // Under uniform sampling a run of one value is one closed step without a gradient, and many
    // with it. The two share only the places of the other samples.
    if (!step) {
      expect_same("double", double_picture(view), double_picture(plain));
      expect_same("gl", gl_picture(view), gl_picture(plain));
    }
    const double off =
        difference("reference", render_reference(view).image, render_reference(plain).image).max;
    EXPECT_LT(off, 1e-7);  // both are float32
    if (step) {
      const View smooth = view_by(scene, TransferFunction(peaks), blobs());
      const View same = view_by(scene, by_equal_columns(), blobs());
      expect_same("uniform double", double_picture(same), double_picture(smooth));
      expect_same("uniform gl", gl_picture(same), gl_picture(smooth));
    }
  }
}

// --- what is skipped -----------------------------------------------------------------------------

/// A box of values next to unstored voxels; its gradients reach one voxel into those.
Field box_of_leaf() {
  return make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 1.f; });
}
const TransferFunction edge_only({{0, 0, {1, 1, 1}}, {0.5, 0, {1, 0.5, 0}}}, true,
                                 {.gradients = {0, 0.5}, .attenuation = {0, 1, 0, 0}});

TEST(GradientSkipping, FindsGradientsWhereNothingIsStored) {
  Scene scene = looking(small_scene(32), {30, 24, 40}, {4, 4, 4});
  View view = view_by(scene, edge_only, box_of_leaf());
  const Image reference = render_reference(view).image;
  expect_content(reference);
  view.scene.segments = 16;
  // second order: 1.9e-2 measured with 1 segment, so 16 segments are 256 times as accurate; a
  // missing brick costs more than 1e-2
  EXPECT_LT(difference("cells", double_picture(view), reference).rms, 3e-4);
  view.scene.sampling = Sampling::uniform;
  view.scene.step = 1.0 / 16;
  EXPECT_LT(difference("uniform", double_picture(view), reference).rms, 3e-4);
}

TEST(GradientSkipping, TilesAreWhatTheirVoxelsAre) {
  const auto value = [](glm::ivec3 v) { return v.x < 128 && v.y < 128 && v.z < 128 ? 0.7f : 0.4f; };
  const Box box{{0, 0, 0}, {143, 143, 143}};
  const Field leaves = make_field(box, value);
  Field tiles = leaves;
  std::erase_if(tiles.leaves, [](const Leaf& leaf) {
    return leaf.origin.x < 128 && leaf.origin.y < 128 && leaf.origin.z < 128;
  });
  tiles.tiles.push_back({{0, 0, 0}, 128, glm::vec3(0.7f)});
  const TransferFunction f({{0, 0.02, {1, 0, 0}}, {1, 0.02, {0, 1, 0}}}, true,
                           {.gradients = {0, 0.1, 0.2},
                            .attenuation = {0, 0.02, 0, 0.02, 0.2, 0.02},
                            .isosurfaces = {{0.69, 0.5, 0.5}}});
  const Scene scene = looking(small_scene(16), {300, 360, 420}, {90, 95, 100});
  for (const Classification when : {Classification::post, Classification::pre}) {
    Scene own = scene;
    own.classification = when;
    const View a = view_by(own, f, leaves), b = view_by(own, f, tiles);
    ASSERT_FALSE(b.medium.density->tiles.empty());
    const Image picture = double_picture(b);
    expect_content(picture);
    // the same values in other kinds of bricks; the bound is the rounding of float32 pictures
    EXPECT_LT(difference("tiles", double_picture(a), picture).max, 1e-6);
    const Image reference = render_reference(b).image;
    View fine = b;
    fine.scene.segments = 16;
    EXPECT_LT(difference("reference", double_picture(fine), reference).rms, 5e-4);
  }
}

// --- extinction, classification, light -----------------------------------------------------------

TEST(GradientView, ResolvesExtinctionByVoxels) {
  Scene scene = scene_of();
  scene.extinction.reset();
  const View post = view_by(scene, table, blobs());
  scene.classification = Classification::pre;
  const View pre = view_by(scene, table, blobs());
  EXPECT_EQ(*post.scene.extinction, *pre.scene.extinction);
  EXPECT_FALSE(pre.medium.transfer);
  EXPECT_FALSE(pre.medium.gradient);
  EXPECT_EQ(*post.scene.extinction, auto_extinction(*pre.medium.density));
  EXPECT_NE(*post.scene.extinction, 1);
}

TEST_F(GradientMarch, LightIsTheSameFromAllThree) {
  Scene scene = scene_of();
  scene.lights = {{{-1, -0.5, -0.3}, glm::dvec3(1)}};
  View view = view_by(scene, shells, blobs());
  const MediumAtlas atlas = build_medium_atlas(view);
  const auto all = visible_blocks(*view.medium.density, density_options(view));
  ASSERT_GT(all.size(), 10u);
  const auto some = std::span(all).subspan(all.size() / 2, 5);
  const std::vector<double> reference = depths_of(view, reference_light_depths(view), some);
  EXPECT_GT(*std::max_element(reference.begin(), reference.end()), 0.5);
  const auto rms = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / double(a.size()));
  };
  const auto error = [&](int segments) {
    view.scene.segments = segments;
    return rms(depths_of(view, march_double_light_depths(view, atlas), some), reference);
  };
  const double coarse = error(2), fine = error(32);
  std::printf("  step error %.1e to %.1e\n", coarse, fine);
  EXPECT_GT(order(coarse, fine, 4), 1.6);
  view.scene.segments = 2;
  Gpu::renderer()->upload(atlas);
  const double arithmetic = rms(depths_of(view, Gpu::renderer()->light_depths(view), some),
                                depths_of(view, march_double_light_depths(view, atlas), some));
  std::printf("  arithmetic %.1e\n", arithmetic);
  EXPECT_LT(arithmetic, 2e-6);  // for depths up to 10
  // Compares the picture that it lights.
  view = lit(view, march_double_light_depths(view, atlas));
  const Image gl = gl_picture(view);
  expect_content(gl);
  expect_same("lit", gl, double_picture(view));
}

}  // namespace
}  // namespace psivox
