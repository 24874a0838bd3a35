// psivox verify passes correct pictures and rejects slightly wrong ones.

#include "psivox/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "march_cases.h"
#include "shader_copy.h"
#include "thrown.h"
#include "verify/case.h"

namespace psivox {
namespace {

class Verify : public GpuTest {};
class BrokenShader : public ShaderTest {};

std::string failures(const VerifyReport& report) {
  std::string names;
  for (const VerifyCase& c : report.cases)
    if (!c.passed()) names += c.name + "; ";
  return names;
}

TEST_F(Verify, PassesWithEitherFilter) {
  std::size_t called = 0;
  const VerifyReport exact = verify({.progress = [&](const VerifyCase&) { ++called; }});
  EXPECT_EQ(failures(exact), "");
  EXPECT_EQ(exact.failed(), 0u);
  EXPECT_EQ(called, exact.cases.size());
  EXPECT_GT(exact.cases.size(), 20u);
  EXPECT_TRUE(exact.left_out.empty());
  EXPECT_NE(exact.renderer, "");

  const VerifyReport hardware = verify({.filter = Filter::hardware});
  EXPECT_EQ(failures(hardware), "");
  EXPECT_EQ(hardware.cases.size() + hardware.left_out.size(), exact.cases.size());
  std::size_t wider = 0;
  for (const VerifyCase& h : hardware.cases)
    for (const VerifyCase& e : exact.cases) {
      EXPECT_TRUE(h.name != e.name || h.bound >= e.bound) << h.name;
      wider += h.name == e.name && h.bound > 10 * e.bound;
    }
  // all but the furnaces, whose values are all 1, and opaque cases, which do not depend on the
  // weights
  EXPECT_EQ(wider + 4, hardware.cases.size());
  EXPECT_TRUE(has(verify_note(Filter::hardware), "wider"));
}

TEST_F(Verify, EveryCaseIsNamedOnceAndHasItsReason) {
  std::vector<std::string> names;
  for (const auto& group : {opacity_cases(), radiance_cases(), source_cases(), invariance_cases()})
    for (const Case& c : group) {
      names.push_back(c.name);
      EXPECT_FALSE(c.reason.empty()) << c.name;
      EXPECT_GT(c.bound, 0) << c.name;
    }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

TEST_F(Verify, APictureThatIsALittleOffIsSeen) {
  const Plate plate{profile(12, [](int) { return 2; })};
  Scene scene = looking(small_scene(8), {-40, 3, 2}, {6, 0, 0});
  scene.fov = 20;
  scene.extinction = 0.05;
  const View view = view_of(scene, plate.field());
  Image image = gl_picture(view);
  const auto depth = [&](const WorldRay& ray) { return 0.05 * plate.along(ray); };
  EXPECT_LE(opacity_error(view, image, depth), 1e-6);
  // it detects a depth 1e-5 too large, one wrong pixel, and a NaN anywhere
  EXPECT_GT(opacity_error(view, image, [&](const WorldRay& r) { return 1.00001 * depth(r); }),
            1e-6);
  Image other = image;
  other.rgba()[45] += 1e-5f;
  EXPECT_GT(opacity_error(view, other, depth), 5e-6);
  EXPECT_GT(picture_difference(image, other), 5e-6);
  other.rgba()[45] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(opacity_error(view, other, depth)));
  EXPECT_FALSE((VerifyCase{"", "", picture_difference(image, other), 1}.passed()));
  // blank pictures are never accepted as equal
  std::fill(image.rgba().begin(), image.rgba().end(), 0.0f);
  EXPECT_FALSE(picture_difference(image, image) <= 1);
}

TEST_F(Verify, ARayThatPassesThePlatesSidesHasNoClosedForm) {
  const Plate plate{profile(12, [](int) { return 2; })};
  EXPECT_TRUE(std::isnan(plate.along({{-40, 0, 0}, glm::normalize(glm::dvec3(1, 0.7, 0))})));
  EXPECT_NEAR(plate.along({{-40, 0, 0}, {1, 0, 0}}), 24, 1e-12);
  EXPECT_NEAR(plate.along({{5, 0, 0}, {-1, 0, 0}}), 11, 1e-12);
}

// A wrong line in a shader makes the cases that need it fail, and no others.

std::string failures(const std::vector<Case>& cases) {
  GlRenderer gl;  // its own, so that no program is cached
  const Painter painter(gl, Filter::exact);
  VerifyReport report;
  for (const Case& c : cases) report.cases.push_back(run_case(c, painter));
  return failures(report);
}

TEST_F(BrokenShader, SwappedWeightsOfTheFit) {
  edit("integrators/psi_weighted.glsl", "x.front < x.back ? real(0.27) : real(0.73)",
       "x.front < x.back ? real(0.73) : real(0.27)");
  EXPECT_EQ(failures(radiance_cases()), "ramp that glows, psi-weighted; ");
}

TEST_F(BrokenShader, RaysThatStandStill) {
  // one ulp before their end, where drivers found another time of the same face
  edit("stretch.glsl", "s.t_exit = max(m.t, min(far.t, ray.end));",
       "s.t_exit = min(max(m.t, min(far.t, ray.end)), ray.end - abs(ray.end) * t_epsilon);");
  GlRenderer gl;
  const Painter painter(gl, Filter::exact);
  for (const Case& c : invariance_cases()) {
    if (c.name != "back to front") continue;
    const VerifyCase found = run_case(c, painter);
    EXPECT_LE(found.error, found.bound);
    EXPECT_GT(found.stuck, 1000u);
    EXPECT_FALSE(found.passed());
  }
}

TEST_F(BrokenShader, SwappedEnds) {
  edit("integrators/psi_balanced.glsl",
       "Weights(front.a + front.e * p, real(0.0), front.e * (back.a - p)",
       "Weights(front.e * (back.a - p), real(0.0), front.a + front.e * p");
  EXPECT_EQ(failures(radiance_cases()), "ramp that glows, psi-balanced; ");
}

TEST_F(BrokenShader, DepthOfTheMiddle) {
  // a homogeneous step with the cell's middle: correct if the value is linear
  edit("composite.glsl", "length * antiderivative(attenuation, real(1.0))",
       "length * polynomial(attenuation, real(0.5))");
  EXPECT_EQ(failures(opacity_cases()), "single voxel's tent; ");
}

}  // namespace
}  // namespace psivox
