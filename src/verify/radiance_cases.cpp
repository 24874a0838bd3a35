#include <algorithm>
#include <cmath>

#include "scene/transfer_function.h"
#include "verify/case.h"
#include "verify/made_fields.h"
#include "verify/made_views.h"

// Varying luminance; where it is constant, R = L A.

namespace psivox {
namespace {

constexpr double sum_bound = 16 * 0x1p-24;
constexpr char sum_reason[] = "256 segments' sums: 16 roundings of 2^-24";

Measured furnace(const Painter& painter, std::optional<double> step, bool grid) {
  const auto density = share(mixed());
  const auto luminance = grid ? share(ones_around_mixed()) : nullptr;
  Measured found;
  for (const glm::dvec3& from : {glm::dvec3(90, 60, 75), {12.3, 9.1, 10.7}}) {
    Scene scene = looking(small_scene(24, 0.15), from, {11, 12, 8});
    scene.step = step;
    const Image image = painter.picture(make_view(scene, density, luminance));
    Image alpha = image;
    for (std::size_t i = 0; i < alpha.rgba().size(); ++i) alpha.rgba()[i] = image.rgba()[i | 3];
    found.add({picture_difference(image, alpha), 0});  // 0: interpolating ones gives 1
  }
  return found;
}

/// L = (x - 2)/4 from x = 2 on, in a homogeneous medium so thick that its back is invisible: R =
/// e^{-d}/(4 tau) times the cosine, where d is the depth in front of x = 2. The rule is exact here.
Measured linear_luminance(const Painter& painter) {
  constexpr double tau = 0.5;
  const auto density =
      share(Plate{profile(64, [](int) { return 1; }), {0, 0, 0}, glm::dmat4(1), 20}.field());
  const auto L = share(make_field({{0, -24, -24}, {66, 24, 24}}, [](glm::ivec3 v) {
    return std::max(0.0f, 0.25f * float(v.x - 2));
  }));
  Scene scene = looking(small_scene(24, tau), {-20, 2, 3}, {4, 0, 0});
  scene.fov = 25;
  const View view = make_view(scene, density, L);
  const Image image = painter.picture(view);
  Measured found;
  for_pixels(view, image, [&](const WorldRay& ray, const float* rgba) {
    const double cosine = ray.direction.x;
    const double exact = 0.25 * cosine / tau * std::exp(-tau * 2.5 / cosine);
    found.error = larger(found.error, std::abs(rgba[0] - exact));
  });
  // L changes by a quarter, and the ramp's depth by up to 1, times L below 1 where it is visible
  found.sensitivity = 0.25 + 2 * tau;
  return found;
}

/// Two slabs with vacuum between them, where L changes: R = L_1 A_1 + L_2 (1 - A_1) A_2.
Measured two_layers(const Painter& painter) {
  constexpr double K = 0.04, L[] = {2, 0.5};
  constexpr int thick = 20, gap = 8, count = 2 * thick + gap;
  const auto in_gap = [](int x) { return x >= thick && x < thick + gap; };
  const Plate all{profile(count, [&](int x) { return in_gap(x) ? 0.0 : x < thick ? 1.0 : 0.75; })};
  const double middle = thick + 0.5 * gap - 0.5;
  const double parts[] = {all.across(-1, middle), all.across(middle, count)};
  const auto luminance = share(make_field({{-8, -40, -40}, {count + 8, 40, 40}}, [&](glm::ivec3 v) {
    return float(v.x < middle ? L[0] : L[1]);
  }));
  const auto density = share(all.field());
  Measured found;
  for (const int first : {0, 1}) {
    const double side = first == 0 ? -1 : 1;
    Scene scene = looking(small_scene(24, K), glm::dvec3(middle + side * 60, 3, 2), {middle, 0, 0});
    scene.fov = 20;
    const View view = make_view(scene, density, luminance);
    for_pixels(view, painter.picture(view), [&](const WorldRay& ray, const float* rgba) {
      const double cosine = std::abs(all.slope(ray));
      const double near = parts[first] * K / cosine, far = parts[1 - first] * K / cosine;
      const double exact =
          L[first] * -std::expm1(-near) - L[1 - first] * std::exp(-near) * std::expm1(-far);
      found.add({std::abs(rgba[0] - exact) / L[0], 2 * K * all.variation() / cosine});
    });
  }
  return found;
}

Scene along_x(double K) { return looking(small_scene(8, K), {-40, 0.4, 0.3}, {0, 0.4, 0.3}, 5.0); }

/// L = value on a ramp, seen along x. Every pixel is the rule's sum over segments of 1/parts of a
/// voxel, computed by the printed formula.
Measured printed_rule(const Painter& painter, Integrator id, std::optional<double> step, int parts,
                      SegmentSum (*rule)(double, double), std::optional<Sampling> sampling = {}) {
  constexpr int count = 33;  // odd: the lattice lies on voxels
  constexpr double K = 0.6;
  const Plate ramp{profile(count, [](int x) { return 0.125 * std::min(x, 14); })};
  Scene scene = with(along_x(K), id, step);
  scene.sampling = sampling;
  const Image image = painter.picture(view_of(scene, ramp.field(), Glow::density));
  const double exact = rule_across(ramp, K, parts, rule);
  // sensitive once to a step of the ramp in L and twice to the depth, with L up to 1.75
  return {radiance_error(image, exact), 0.125 + 2 * 1.75 * K * ramp.variation()};
}

/// A plate that rises towards an invisible back, with L = value. Attenuation and luminance are
/// linear, which psi-exact integrates exactly. The error is the larger of the radiance's, relative
/// to the exact one, and A's against 1.
struct Rise {
  double K, slope;
  int width;  ///< [voxels], followed by a plateau
};
Measured rising(const Painter& painter, const Rise& rise, int channel) {
  const Plate plate{
      profile(rise.width + 24, [&](int x) { return rise.slope * std::min(x + 1, rise.width); })};
  Scene scene = looking(small_scene(16, rise.K), {-20, 2, 3}, {4, 0, 0});
  scene.fov = 25;
  scene.integrator = Integrator::psi_exact;
  const View view = view_of(scene, plate.field(), Glow::density);
  Measured found;
  for_pixels(view, painter.picture(view), [&](const WorldRay& ray, const float* rgba) {
    const double exact = channel == 3 ? 1 : rising_glow(rise.K, rise.slope * plate.slope(ray));
    // If values are off by d, then in R = int v K v T the two factors lose d each and T loses 2
    // d. A does not change.
    const double sensitivity = channel == 3 ? 0 : 4 * rise.slope / exact;
    found.add({std::abs(rgba[channel] / exact - 1), sensitivity});
  });
  return found;
}

/// Rays are placed to 64 * 2^-24 voxels: four roundings of coordinates below 32, 16 * 2^-24 each.
/// The light comes from values of about (slope/K)^(1/2), at a depth of (slope K)^(-1/2) voxels.
Case rising_case(const std::string& name, const Rise& rise, bool hardware = true) {
  return {name, "relative: rays placed to 64 * 2^-24 voxels of the (slope K)^-1/2 that glow",
          sum_bound + 64 * 0x1p-24 * std::sqrt(rise.slope * rise.K),
          [=](const Painter& p) { return rising(p, rise, 0); }, hardware};
}

// --- sources other than the value itself, and ray templates --------------------------------------

// The bound covers sums of 256 segments, and a depth d with up to 40 roundings, which change e^{-d}
// by 40 * 2^-24 * 0.37.
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
    Scene scene = looking(small_scene(24, K), {12 + side, 3.3, 1.8}, {12, 0.3, -0.2});
    scene.fov = 30;
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
  Scene scene = looking(small_scene(24, 0), {-40, 3, 2}, {6, 0, 0});
  scene.fov = 20;
  View view = view_of(scene, slab.field());
  view.medium.emission = {{view.medium.density, scale}};
  Measured found;
  for_pixels(view, painter.picture(view), [&](const WorldRay& ray, const float* rgba) {
    const double exact = scale * slab.along(ray);
    const double sensitivity = scale * slab.variation() / std::abs(slab.slope(ray)) / exact;
    found.add({std::abs(rgba[0] / exact - 1), sensitivity});
    found.add({std::abs(double(rgba[3])), 0});
  });
  return found;
}

/// A ramp seen along the light. At voxels L = e^{-d}, where d is the depth in front, and L is
/// linear in between. The picture is the default rule's sum by its printed formula.
Measured lit_ramp(const Painter& painter) {
  constexpr double K = 0.12;
  const Plate ramp{profile(20, [](int x) { return 0.25 * std::min(x + 1, 8); })};
  Scene scene = along_x(K);
  scene.lights = {{{1, 0, 0}, {1, 0.5, 2}}};
  const View view = view_of(scene, ramp.field());
  const Image image = painter.picture(view);
  const double exact = rule_across(ramp, K, scene.segments, weighted_opacity,
                                   [&](int x) { return std::exp(-K * ramp.across(-1, x)); });
  Measured found;
  for_pixels(view, image, [&](const WorldRay&, const float* rgba) {
    for (int c = 0; c < 3; ++c)
      found.error = larger(found.error, std::abs(rgba[c] / scene.lights[0].color[c] - exact));
  });
  // L changes by a voxel's K v, and the depth counts twice, times L below 1
  found.sensitivity = K * 2 + 2 * K * ramp.variation();
  return found;
}

}  // namespace

std::vector<Case> radiance_cases() {
  const auto furnace_case = [](const std::string& name, std::optional<double> step, bool grid) {
    return Case{"furnace, " + name, "R = A; " + std::string(sum_reason), sum_bound,
                [=](const Painter& p) { return furnace(p, step, grid); }};
  };
  return {
      furnace_case("cells", {}, false),
      furnace_case("cells, grid of 1", {}, true),
      furnace_case("uniform, grid of 1", 0.73, true),
      {"linear luminance, psi-weighted", sum_reason, sum_bound, linear_luminance},
      {"two layers", sum_reason, sum_bound, two_layers},
      {"ramp that glows, psi-weighted", sum_reason, sum_bound,
       [](const Painter& p) {
         return printed_rule(p, Integrator::psi_weighted, {}, Scene{}.segments, weighted_opacity);
       }},
      {"ramp that glows, psi-balanced", sum_reason, sum_bound,
       [](const Painter& p) {
         return printed_rule(p, Integrator::psi_balanced, 0.5, 2, balanced);
       }},
      rising_case("ramp that glows, psi-exact", {0.5, 0.125, 32}),
      rising_case("opaque end that glows, K 1e2", {1e2, 1, 1}),
      rising_case("opaque end that glows, K 1e6", {1e6, 1, 1}, false),
      {"opaque end, A", "nothing comes through: 1 to 16 roundings", sum_bound,
       [](const Painter& p) {
         return rising(p, {1e6, 1, 1}, 3);
       }},
  };
}

std::vector<Case> source_cases() {
  return {
      {"ramp under a tent function", "a depth d to 40 roundings of 2^-24; d e^-d <= 0.37",
       source_depth_bound, transfer_tent},
      {"emission alone, relative", "an integral to 40 roundings of 2^-24; A = 0", 40 * 0x1p-24,
       emitting_slab},
      {"ramp lit from the front", "L <= 1 to 40 roundings, 64 segments' sums to 16",
       source_depth_bound + sum_bound, lit_ramp},
      {"ramp that glows, template", "40 segments' sums: 16 roundings of 2^-24", sum_bound,
       [](const Painter& p) {  // samples lie on voxels
         return printed_rule(p, Integrator::psi_weighted, {}, 1, weighted_opacity,
                             Sampling::template_);
       }},
  };
}

}  // namespace psivox
