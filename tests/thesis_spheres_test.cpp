// Moreland's picture of two spheres of different colours, one behind the other, at one coarse step.
// The better a rule interpolates luminance and attenuation together, the smaller its error.

#include "march_cases.h"
#include "study/suite.h"

namespace psivox {
namespace {

View two_spheres(Integrator rule, double step) {
  Spheres spheres = thesis_spheres();
  Scene scene = looking(small_scene(96), {15.5, 15.5, 200}, {15.5, 15.5, 28}, 32.0);
  scene.extinction = 0.12;
  return view_of(with(scene, rule, step), std::move(spheres.density), std::move(spheres.color));
}

class ThesisSpheres : public GpuTest {};

TEST_F(ThesisSpheres, ErrorsFallFromAverageToLinearLuminanceToWeightedOpacity) {
  constexpr double step = 12;  // three samples per sphere
  const Image reference = render_reference(two_spheres(Integrator::average, step)).image;
  expect_content(reference);
  const auto error = [&](Integrator rule) {
    return difference(info(rule).name, gl_picture(two_spheres(rule, step)), reference).rms;
  };
  const double average = error(Integrator::average);
  const double linear = error(Integrator::linear_luminance);
  EXPECT_LT(linear, average);
  EXPECT_LT(error(Integrator::psi_weighted), linear);
  EXPECT_LT(error(Integrator::opacity_linear), linear);
}

}  // namespace
}  // namespace psivox
