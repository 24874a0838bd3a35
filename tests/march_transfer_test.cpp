// Transfer functions in the march: compared with the reference, and the GPU with the march in
// double.

#include <string>
#include <vector>

#include "blobs_scene.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/parameters.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Broad ramps over the values of `mixed`.
const auto smooth = [] {
  return function(
      {{0, 0, {0, 0, 1}}, {0.4, 0.2, {0, 1, 0}}, {1, 0.8, {1, 0.5, 0}}, {2, 0.4, {1, 1, 1}}});
};
/// Two peaks of a twentieth of the range, each of changing colour.
const auto tents = [] {
  return function({{0.2, 0, {1, 0, 0}},
                   {0.25, 1, {1, 0.4, 0}},
                   {0.3, 0, {1, 1, 0}},
                   {0.65, 0, {0, 0, 1}},
                   {0.7, 1, {0, 0.5, 1}},
                   {0.75, 0, {0.5, 1, 1}}});
};
/// Vacuum below 0.35 and between 0.7 and 0.8.
const auto jumps = [] {
  return function({{0.35, 0, {0, 0, 1}},
                   {0.35, 0.4, {1, 0.5, 0}},
                   {0.7, 0.4, {0, 1, 1}},
                   {0.7, 0, {0, 1, 1}},
                   {0.8, 0, {1, 1, 0}},
                   {0.8, 0.3, {1, 1, 0}}});
};

struct Case {
  const char* name;
  std::shared_ptr<const TransferFunction> function;
  double slope;  ///< greatest slope of the attenuation, without jumps
};
const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"smooth", smooth(), 1}, {"tents", tents(), 20}, {"jumps", jumps(), 0}};
  return all;
}

View view_under(const Case& c, LuminanceSource source, int side = 40) {
  const Scene scene = looking(small_scene(side), {60, 70, 90}, {10, 12, 11});
  View view =
      view_of(scene, mixed(), source == LuminanceSource::density ? Glow::density : Glow::constant);
  view.medium.transfer = c.function;
  view.medium.source = source;
  view.medium.extinction = 0.3;
  return view;
}

constexpr LuminanceSource sources_of_classes[] = {
    LuminanceSource::constant, LuminanceSource::density, LuminanceSource::transfer};

TEST(MarchTransferDouble, CellsCutAtKnotsAreTheReference) {
  for (const Case& c : cases())
    for (const LuminanceSource source : sources_of_classes) {
      View view = view_under(c, source);
      const Image reference = render_reference(view).image;
      expect_content(reference);
      const std::string what = std::string(c.name) + name_of(source);
      view.scene.integrator = Integrator::cell_exact;
      EXPECT_LE(difference(what + ", cell-exact", double_picture(view), reference).rms, 2e-6);
      // If the attenuation is linear in the value, it is a cubic whose depth Simpson's rule gives
      // exactly; under constant L nothing else is visible. Otherwise two segments have second
      // order.
      view.scene.integrator = Integrator::psi_weighted;
      view.scene.split_knots = true;
      const Comparison split = difference(what + ", split", double_picture(view), reference);
      EXPECT_LE(split.channel_rms[3], 2e-6);
      if (source == LuminanceSource::constant) {
        EXPECT_LE(split.rms, 2e-6);
      }
    }
}

TEST(MarchTransferDouble, EveryClassificationConverges) {
  for (const Case& c : cases()) {
    const View view = view_under(c, LuminanceSource::transfer, 24);
    const Image reference = render_reference(view).image;
    const auto converges = [&](Integrator rule, bool uniform, bool split, double order) {
      View v = view;
      v.scene.integrator = rule;
      v.scene.split_knots = split;
      if (uniform) v.scene.sampling = Sampling::uniform;
      expect_convergence(std::string(c.name) + ' ' + info(rule).name + (split ? " split" : ""), v,
                         reference, order);
    };
    // Samples of a function have second order between its knots, but first order where it jumps and
    // where a segment's values cross a whole tent. Values that are linear in a segment have second
    // order for any function. 0.8 and 1.3 allow for so few segments.
    const double sampled = c.slope == 1 ? 1.3 : 0.8;
    converges(Integrator::psi_weighted, false, false, sampled);
    converges(Integrator::psi_weighted, false, true, 1.8);
    converges(Integrator::psi_balanced, true, false, sampled);
    for (const bool uniform : {false, true}) {
      converges(Integrator::preintegrated, uniform, false, 1.3);
      converges(Integrator::preintegrated_fast, uniform, false, 1.3);
    }
  }
}

class MarchTransfer : public GpuTest {};

/// One program per kind of rule, because building them takes most of this test's time.
TEST_F(MarchTransfer, GpuIsTheMarchInDouble) {
  struct Way {
    Integrator rule;
    bool uniform, split;
    LuminanceSource source;
  };
  const Way ways[] = {{Integrator::psi_weighted, false, true, LuminanceSource::constant},
                      {Integrator::cell_exact, false, false, LuminanceSource::transfer},
                      {Integrator::preintegrated_fast, false, false, LuminanceSource::constant},
                      {Integrator::midpoint, true, false, LuminanceSource::transfer},
                      {Integrator::preintegrated, false, false, LuminanceSource::transfer},
                      {Integrator::preintegrated, true, false, LuminanceSource::transfer}};
  for (const Way& way : ways)
    for (const Case& c : cases()) {
      View view = view_under(c, way.source);
      view.scene.integrator = way.rule;
      view.scene.split_knots = way.split;
      if (way.uniform) view.scene.sampling = Sampling::uniform;
      view.scene.step = 0.7;
      const MediumAtlas atlas = build_medium_atlas(view);
      const Image gpu = render_gl(view, atlas).image;
      expect_content(gpu);
      const Comparison d =
          difference(std::string(info(way.rule).name) + (way.uniform ? " uniform " : " cells ") +
                         c.name + name_of(way.source),
                     gpu, render_double(view, atlas).image);
      // The tents' slope is 20 times that of the smooth function, which has 2e-7, wherever the
      // function is applied to samples.
      EXPECT_LE(d.rms, c.slope > 1 && is_segment_rule(way.rule) && !way.split ? 4e-6 : 1e-6);
    }
}

/// A piece of a cell that ends where it began, up to rounding, is not crossed by ulps. In heptane's
/// plateaus some rays took 47,000 turns, and their sums lost enough for an error of 6e-4.
TEST_F(MarchTransfer, PlateausOfRoundingAreCrossedAtOnce) {
  View view = view_under(cases()[0], LuminanceSource::transfer);
  view.medium.density = share(make_field({{-20, -12, -8}, {43, 35, 31}}, [](glm::ivec3 v) {
    return 0.7f + std::floor(4 * noise(v)) * 6e-8f;  // an ulp
  }));
  view.scene.integrator = Integrator::cell_exact;
  const MediumAtlas atlas = build_medium_atlas(view);
  const RenderOptions count{.count = true};
  const RenderResult gpu = render_gl(view, atlas, {.render = count});
  const RenderResult truth = render_double(view, atlas, count);
  expect_content(gpu.image);
  EXPECT_LE(difference("plateau", gpu.image, truth.image).rms, 1e-6);
  // double has as many cells, and more turns because it resolves more values
  EXPECT_LE(gpu.stats.samples, truth.stats.samples);
}

/// A study draws all its rules by one session; `preintegrated` needs bricks that others leave out.
TEST(Session, DrawsEachRuleOverTheBricksThatItNeeds) {
  Scene scene = blobs_scene();
  set_parameter(scene, "colormap", "inferno");
  set_parameter(scene, "opacity", "0:0,0.2:0,0.4:0.1,1:1");
  scene.sampling = Sampling::uniform;
  scene.step = 4;
  const std::shared_ptr<Marcher> marcher = open_double();
  Session session(scene);
  for (const Integrator rule :
       {Integrator::psi_balanced, Integrator::preintegrated, Integrator::psi_balanced}) {
    scene.integrator = rule;
    Wish wish;
    wish.scene = scene;
    const Image drawn = session.draw(*marcher, wish).image;
    EXPECT_EQ(compare_images(drawn, Session(scene).draw(*marcher).image).max, 0);
  }
}

}  // namespace
}  // namespace psivox
