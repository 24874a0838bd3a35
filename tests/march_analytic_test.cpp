// The GPU's pictures of media with known integrals, by every rule. `psivox verify` has more of
// them, which verify_test draws.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "made_fields.h"
#include "march_cases.h"

namespace psivox {
namespace {

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
