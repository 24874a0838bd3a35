// Moreland's picture of two spheres of different colours, one behind the other, at one coarse step.
// The better a rule interpolates luminance and attenuation together, the smaller its error.

#include "figure.h"
#include "march_cases.h"

namespace psivox {
namespace {

/// Red before blue along z, both dense in the middle; they touch.
View two_spheres(Integrator rule, double step) {
  const auto sphere = [](const glm::dvec3& p, const glm::dvec3& c) {
    const glm::dvec3 d = (p - c) / 12.0;
    return std::max(0.0, 1 - glm::dot(d, d));
  };
  const Box box{{0, 0, 0}, {31, 31, 55}};
  Field density = make_field(box, [&](glm::ivec3 v) {
    const glm::dvec3 p(v);
    return float(sphere(p, {17, 17, 40}) + sphere(p, {14, 14, 16}));
  });
  Field color = make_vector_field(box, [](glm::ivec3 v) {
    const float red = float(std::clamp((v.z - 22) / 12.0, 0.0, 1.0));
    return glm::vec3(0.05f + 0.95f * red, 0.15f, 1.0f - 0.95f * red);
  });
  Scene scene = looking(small_scene(96), {15.5, 15.5, 200}, {15.5, 15.5, 28}, 32.0);
  scene.extinction = 0.12;
  return view_of(with(scene, rule, step), std::move(density), std::move(color));
}

class ThesisSpheres : public GpuTest {};

TEST_F(ThesisSpheres, ErrorsFallFromAverageToLinearLuminanceToWeightedOpacity) {
  constexpr double step = 12;  // three samples per sphere
  const Image reference = render_reference(two_spheres(Integrator::average, step)).image;
  expect_content(reference);
  write_figure("spheres_reference", reference);
  const auto error = [&](Integrator rule) {
    const Image picture = gl_picture(two_spheres(rule, step));
    write_figure(std::string("spheres_") + info(rule).name, picture);
    return difference(info(rule).name, picture, reference).rms;
  };
  const double average = error(Integrator::average);
  const double linear = error(Integrator::linear_luminance);
  EXPECT_LT(linear, average);
  EXPECT_LT(error(Integrator::psi_weighted), linear);
  EXPECT_LT(error(Integrator::opacity_linear), linear);
}

}  // namespace
}  // namespace psivox
