#include <algorithm>
#include <cmath>

#include "scene/transfer_function.h"
#include "verify/case.h"
#include "verify/made_views.h"

// Sources other than the value itself: transfer functions, emission and light; and ray templates.

namespace psivox {
namespace {

// The bound covers sums of 256 segments, and a depth d with up to 40 roundings, which change e^{-d}
// by 40 * 2^-24 * 0.37.
constexpr double source_sum_bound = 16 * 0x1p-24;
constexpr double source_depth_bound = 1e-6;

/// Integral from 0 to v of the tent: 0 up to v = 2, 1 at 4, 0 from 6 on.
double tent_integral(double v) {
  const double u = std::clamp((v - 4) / 2, -1.0, 1.0);
  return u < 0 ? (1 + u) * (1 + u) : 2 - (1 - u) * (1 - u);
}

/// A ramp whose value passes the tent's three knots inside cells. Along x the integral of the
/// attenuation is the tent's integral divided by the slope. Segments end at the knots, so each
/// depth is exact.
Measured transfer_tent(const Painter& painter) {
  constexpr double K = 0.25;
  const Plate ramp{profile(24, [](int x) { return 0.375 * (x + 1); })};
  double area = 0;  // integral over x
  for (int x = -1; x < 24; ++x) {
    const double a = ramp.value(x), b = ramp.value(x + 1);
    area += (tent_integral(b) - tent_integral(a)) / (b - a);
  }
  Measured found;
  for (const double side : {-40.0, 40.0}) {
    Scene scene = looking(small_scene(24), {12 + side, 3.3, 1.8}, {12, 0.3, -0.2});
    scene.fov = 30;
    scene.extinction = K;
    View view = view_of(scene, ramp.field());
    view.scene.split_knots = true;
    view.medium.transfer = std::make_shared<const TransferFunction>(
        std::vector<TransferPoint>{{2, 0, {}}, {4, 1, {}}, {6, 0, {}}}, false);
    const auto depth = [&](const WorldRay& ray) {
      const double cosine = std::abs(ramp.slope(ray));
      // the tent's slope, 1/2, times the change of the value per error of a weight
      found.sensitivity = larger(found.sensitivity, K * 0.5 * ramp.variation() / cosine);
      return K * area / cosine;
    };
    found.error = larger(found.error, opacity_error(view, painter.picture(view), depth));
  }
  return found;
}

/// A slab that emits without attenuating: R is the integral of its values, and A = 0.
Measured emitting_slab(const Painter& painter) {
  constexpr double scale = 0.05;
  const Plate slab{profile(12, [](int) { return 2; })};
  Scene scene = looking(small_scene(24), {-40, 3, 2}, {6, 0, 0});
  scene.fov = 20;
  scene.extinction = 0;
  View view = view_of(scene, slab.field());
  view.medium.emission = view.medium.density;
  view.medium.emission_scale = scale;
  const Image image = painter.picture(view);
  Measured found;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const WorldRay ray = pixel_ray(view, x, y);
      const double exact = scale * slab.along(ray);
      const double sensitivity = scale * slab.variation() / std::abs(slab.slope(ray)) / exact;
      found.add({std::abs(pixel(image, x, y, 0) / exact - 1), sensitivity});
      found.add({std::abs(double(pixel(image, x, y, 3))), 0});
    }
  return found;
}

/// A ramp seen along the light. At voxels L = e^{-d}, where d is the depth in front, and L is
/// linear in between. The picture is the default rule's sum by its printed formula.
Measured lit_ramp(const Painter& painter) {
  constexpr double K = 0.12;
  const Plate ramp{profile(20, [](int x) { return 0.25 * std::min(x + 1, 8); })};
  Scene scene = looking(small_scene(8), {-40, 0.4, 0.3}, {0, 0.4, 0.3}, 5.0);
  scene.extinction = K;
  scene.lights = {{{1, 0, 0}, {1, 0.5, 2}}};
  const View view = view_of(scene, ramp.field());
  const Image image = painter.picture(view);
  const double exact = rule_across(ramp, K, scene.segments, weighted_opacity,
                                   [&](int x) { return std::exp(-K * ramp.across(-1, x)); });
  Measured found;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double color = scene.lights.front().color[c];
        found.error = larger(found.error, std::abs(pixel(image, x, y, c) / color - exact));
      }
  // L changes by a voxel's K v, and the depth counts twice, times L below 1
  found.sensitivity = K * 2 + 2 * K * ramp.variation();
  return found;
}

/// A glowing ramp along x, drawn by a ray template. Samples lie on voxels, and the rule's printed
/// sum runs over segments of one voxel.
Measured template_ramp(const Painter& painter) {
  constexpr double K = 0.6;
  const Plate ramp{profile(33, [](int x) { return 0.125 * std::min(x, 14); })};
  Scene scene = looking(small_scene(8), {-40, 0.4, 0.3}, {0, 0.4, 0.3}, 5.0);
  scene.extinction = K;
  scene.sampling = Sampling::template_;
  scene.integrator = Integrator::psi_weighted;
  const Image image = painter.picture(view_of(scene, ramp.field(), Glow::density));
  const double exact = rule_across(ramp, K, 1, weighted_opacity);
  return {radiance_error(image, exact), 0.125 + 2 * 1.75 * K * ramp.variation()};
}

}  // namespace

std::vector<Case> source_cases() {
  return {
      {"ramp under a tent function", "a depth d to 40 roundings of 2^-24; d e^-d <= 0.37",
       source_depth_bound, transfer_tent},
      {"emission alone, relative", "an integral to 40 roundings of 2^-24; A = 0", 40 * 0x1p-24,
       emitting_slab},
      {"ramp lit from the front", "L <= 1 to 40 roundings, 64 segments' sums to 16",
       source_depth_bound + source_sum_bound, lit_ramp},
      {"ramp that glows, template", "40 segments' sums: 16 roundings of 2^-24", source_sum_bound,
       template_ramp},
  };
}

}  // namespace psivox
