// psivox verify passes correct pictures and rejects slightly wrong ones.

#include "psivox/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "march_cases.h"
#include "psivox/draw.h"
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
  EXPECT_GE(exact.cases.size(), 12u);
  EXPECT_NE(exact.renderer, "");

  const VerifyReport hardware = verify({.filter = Filter::hardware});
  EXPECT_EQ(failures(hardware), "");
  EXPECT_EQ(hardware.cases.size(), exact.cases.size());
  std::size_t wider = 0;
  for (const VerifyCase& h : hardware.cases)
    for (const VerifyCase& e : exact.cases) {
      EXPECT_TRUE(h.name != e.name || h.bound >= e.bound) << h.name;
      wider += h.name == e.name && h.bound > 10 * e.bound;
    }
  EXPECT_EQ(wider, hardware.cases.size());
  EXPECT_TRUE(has(verify_note(Filter::hardware), "wider"));
}

TEST_F(Verify, APictureThatIsALittleOffIsSeen) {
  const Case slab = verify_cases().front();
  const Image image = gl_picture(slab.view);
  EXPECT_EQ(largest_difference(image, image), 0);
  Image other = image;
  other.rgba()[45] += 1e-5f;
  EXPECT_GT(largest_difference(image, other), 5e-6);
  other.rgba()[45] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(largest_difference(image, other)));
  EXPECT_FALSE((VerifyCase{"", "", largest_difference(image, other), 1}.passed()));
  // no truth is blank, which a driver's picture might be
  for (const Case& c : verify_cases()) {
    const Image truth = Session(c.view).draw(*open_double()).image;
    EXPECT_GT(largest_difference(truth, rgba_image(truth.width, truth.height)), 100 * c.bound)
        << c.name;
  }
}

// A wrong line in a shader makes the cases that need it fail, and no others.

std::string broken_cases() {
  GlRenderer gl;  // its own, so that no program is cached
  VerifyReport report;
  for (const Case& c : verify_cases()) report.cases.push_back(run_case(c, gl, Filter::exact));
  return failures(report);
}

TEST_F(BrokenShader, SwappedWeightsOfTheFit) {
  edit("integrators/psi_weighted.glsl", "x.front < x.back ? real(0.27) : real(0.73)",
       "x.front < x.back ? real(0.73) : real(0.27)");
  EXPECT_EQ(broken_cases(),
            "ramp that glows, psi-weighted; ramp lit from the front; back to front; ");
}

TEST_F(BrokenShader, RaysThatStandStill) {
  // one ulp before their end, where drivers found another time of the same face
  edit("stretch.glsl", "s.t_exit = max(m.t, min(far.t, ray.end));",
       "s.t_exit = min(max(m.t, min(far.t, ray.end)), ray.end - abs(ray.end) * t_epsilon);");
  GlRenderer gl;
  for (const Case& c : verify_cases()) {
    if (c.name != "back to front") continue;
    const VerifyCase found = run_case(c, gl, Filter::exact);
    EXPECT_LE(found.error, found.bound);
    EXPECT_GT(found.stuck, 1000u);
    EXPECT_FALSE(found.passed());
  }
}

TEST_F(BrokenShader, SwappedEnds) {
  edit("integrators/psi_balanced.glsl",
       "Weights(front.a + front.e * p, real(0.0), front.e * (back.a - p)",
       "Weights(front.e * (back.a - p), real(0.0), front.a + front.e * p");
  EXPECT_EQ(broken_cases(), "balls that glow, uniform; ramp that glows, psi-balanced; ");
}

TEST_F(BrokenShader, DepthOfTheMiddle) {
  // a homogeneous step with the cell's middle: correct if the value is linear
  edit("composite.glsl", "length * antiderivative(attenuation, real(1.0))",
       "length * polynomial(attenuation, real(0.5))");
  EXPECT_TRUE(has(broken_cases(), "single voxel's tent; "));
}

}  // namespace
}  // namespace psivox
