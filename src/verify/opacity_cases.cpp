#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "verify/case.h"
#include "verify/made_fields.h"
#include "verify/made_views.h"

// Constant luminance: the picture depends on the optical depth alone, which cells integrate
// exactly.

namespace psivox {
namespace {

// A ray's depth d has up to 40 roundings of 2^-24 (a length, values, their sum). They change A = 1
// - e^{-d} by 40 * 2^-24 * d e^{-d}, and d e^{-d} is at most 0.37.
constexpr double depth_bound = 1e-6;
constexpr char depth_reason[] = "a depth d to 40 roundings of 2^-24; d e^-d <= 0.37";

/// Opacity errors of a plate with optical depth K times its values, seen from `from` towards `to`
/// in its index space.
Measured plate_opacity(const Painter& painter, const Plate& plate, double K, const glm::dvec3& from,
                       const glm::dvec3& to, double fov = 30) {
  const auto world = [&](const glm::dvec3& p) {
    return glm::dvec3(plate.world_from_index * glm::dvec4(glm::dvec3(plate.at) + p, 1));
  };
  Scene scene = looking(small_scene(24, K), world(from), world(to));
  scene.fov = fov;
  scene.luminance = {1, 2, 0.5};
  const View view = view_of(scene, plate.field());
  Measured found;
  const auto depth = [&](const WorldRay& ray) {
    found.sensitivity =
        larger(found.sensitivity, K * plate.variation() / std::abs(plate.slope(ray)));
    return K * plate.along(ray);
  };
  found.error = opacity_error(view, painter.picture(view), depth);
  return found;
}

Measured plate_opacities(const Painter& painter, const Plate& plate, double K) {
  const glm::dvec3 middle(0.5 * double(plate.values.size()), 0.3, -0.2);
  Measured found;
  for (const double side : {-40.0, 40.0})
    found.add(plate_opacity(painter, plate, K, middle + glm::dvec3(side, 3, 2), middle));
  return found;
}

Plate slab() {
  return {profile(12, [](int) { return 2; })};
}
/// A rise and a plateau. The plateau has bricks of one value, like the slab, so one program draws
/// both.
Plate ramp() {
  return {profile(33, [](int x) { return 0.125 * std::min(x, 12); })};
}

glm::dmat4 moved(const glm::dvec3& origin, double scale = 1) {
  return glm::scale(glm::translate(glm::dmat4(1), origin), glm::dvec3(scale));
}

/// A ramp elsewhere with the same optical depth.
Measured placed_ramp(const Painter& painter, const glm::dmat4& m, double scale = 1,
                     const glm::ivec3& at = {0, 0, 0}) {
  Plate plate = ramp();
  plate.world_from_index = m;
  plate.at = at;
  return plate_opacities(painter, plate, 0.05 / scale);
}

Measured thin_slab(const Painter& painter) {
  // Depths are about 3e-6, so the error is relative to A.
  constexpr double K = 1e-7;
  Measured found = plate_opacities(painter, slab(), K);
  const double least = K * slab().across(-1, 12);
  return {found.error / least, found.sensitivity / least};
}

Measured camera_inside(const Painter& painter) {
  Measured found;
  for (const double x : {8.3, 12.0, 20.9})
    for (const double side : {-1.0, 1.0}) {
      const glm::dvec3 at(x, 0.4, -0.7);
      found.add(plate_opacity(painter, ramp(), 0.05, at, at + glm::dvec3(side, 0.1, 0.2), 60));
    }
  return found;
}

Measured tent(const Painter& painter) {
  constexpr double K = 0.9, peak = 1.5;
  const glm::ivec3 at(8, 0, -8);
  const glm::dvec3 voxel(at);
  const auto field = share(make_field({at, at}, [](glm::ivec3) { return float(peak); }));
  Measured found;
  // a change of 1 a voxel along each axis, over the diagonal of a cube of 2 voxels
  found.sensitivity = K * peak * 3 * std::sqrt(12.0);
  for (const glm::dvec3& from : {glm::dvec3(20, 0, 0), {-3, 1, 20}, {12, 9, 7}}) {
    const View view = view_of(looking(small_scene(33, K), voxel + from, voxel, 3.0), field);
    const auto depth = [&](const WorldRay& ray) { return K * peak * tent_along(ray, at); };
    found.add({opacity_error(view, painter.picture(view), depth), 0});
  }
  return found;
}

/// Along x, the trilinear interpolation of a product of Gaussians is its sum over x times a factor
/// that is linear in y and in z.
Measured gaussian(const Painter& painter) {
  constexpr double K = 0.3, width = 4;
  constexpr int radius = 16;
  const auto g = [](int i) { return std::exp(-double(i * i) / (width * width)); };
  const auto linear = [&](double p) {
    const int i = int(std::floor(p));
    return std::lerp(g(i), g(i + 1), p - i);
  };
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) sum += g(i);
  const Field field = make_field({glm::ivec3(-radius), glm::ivec3(radius)},
                                 [&](glm::ivec3 v) { return float(g(v.x) * g(v.y) * g(v.z)); });
  const View view = view_of(looking(small_scene(40, K), {-40, 0, 0}, {0, 0, 0}, 20.0), field);
  const auto depth = [&](const WorldRay& ray) {
    return K * sum * linear(ray.origin.y) * linear(ray.origin.z);
  };
  // 2 up and down along x; along y and z a slope of at most 0.86/width, over sum voxels
  return {opacity_error(view, painter.picture(view), depth), K * (2 + 2 * 0.86 / width * sum)};
}

}  // namespace

std::vector<Case> opacity_cases() {
  const auto depth_case = [](const std::string& name, std::function<Measured(const Painter&)> f) {
    return Case{name, depth_reason, depth_bound, std::move(f)};
  };
  const auto placed = [&](const std::string& name, const glm::dmat4& m, double scale = 1,
                          const glm::ivec3& at = {0, 0, 0}) {
    return depth_case(name, [=](const Painter& p) { return placed_ramp(p, m, scale, at); });
  };
  const glm::ivec3 far(1'000'000, -1'000'003, 999'998);
  return {
      depth_case("slab", [](const Painter& p) { return plate_opacities(p, slab(), 0.05); }),
      {"thin slab, relative", "a depth of 3e-6 to 40 roundings of 2^-24", 40 * 0x1p-24, thin_slab},
      depth_case("ramp", [](const Painter& p) { return plate_opacities(p, ramp(), 0.05); }),
      depth_case("single voxel's tent", tent),
      depth_case("Gaussian", gaussian),
      depth_case("camera inside", camera_inside),
      placed("rotated, sheared, anisotropic", sheared),
      placed("origin 1e6 away", moved({1e6, -1e6, 1e6})),
      placed("voxels 1e6 from index 0", moved(-glm::dvec3(far)), 1, far),
      placed("transform of scale 1e-4", moved({0, 0, 0}, 1e-4), 1e-4),
      placed("transform of scale 1e4", moved({0, 0, 0}, 1e4), 1e4),
  };
}

}  // namespace psivox
