#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "made_fields.h"
#include "psivox/medium.h"
#include "ray_quadrature.h"
#include "reference/ray_radiance.h"
#include "scene/transfer_function.h"

namespace psivox {

inline float one(const glm::ivec3&) { return 1; }

inline WorldRay ray_through(const glm::dvec3& from, const glm::dvec3& to) {
  return {from, glm::normalize(to - from)};
}

inline Medium make_medium(Field density, double extinction, LuminanceSource source) {
  Medium medium;
  medium.density = std::make_shared<Field>(std::move(density));
  medium.extinction = extinction;
  medium.source = source;
  return medium;
}

inline Medium make_medium(Field density, double extinction, Field luminance) {
  Medium medium =
      make_medium(std::move(density), extinction,
                  luminance.channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar);
  medium.luminance = std::make_shared<Field>(std::move(luminance));
  return medium;
}

/// Prepares the medium for a single ray and integrates it.
inline RayRadiance ray_radiance(const Medium& medium, const WorldRay& ray,
                                double tolerance = 1e-12) {
  const RayMedium ready(medium);
  return RayIntegrator(ready, tolerance).radiance(ray);
}

/// Optical depth of extinction * field, exact except for rounding.
inline double optical_depth(const Field& field, double extinction, const WorldRay& ray,
                            double t0 = 0, double t1 = infinity) {
  Medium medium;
  medium.density = {std::shared_ptr<const Field>(), &field};
  medium.extinction = extinction;
  const RayMedium ready(medium);
  return RayIntegrator(ready, 0).whole_depth(ray, t0, t1).optical_depth;
}

/// The same ray, by a plain quadrature of point-sampled fields.
inline PlainRadiance plain(const Medium& medium, const WorldRay& ray, double t1, int panels = 48) {
  const PlainField density(*medium.density);
  const PlainField luminance(medium.luminance ? *medium.luminance : *medium.density);
  std::vector<PlainField> emission;
  for (const auto& [field, scale, _] : medium.emission) emission.emplace_back(*field);
  std::vector<double> faces{0, t1};
  density.add_faces(ray, 0, t1, faces);
  luminance.add_faces(ray, 0, t1, faces);
  for (const PlainField& field : emission) field.add_faces(ray, 0, t1, faces);
  auto at = [&](double t) { return ray.origin + t * ray.direction; };
  auto value = [&](double t) { return density.value(at(t)).x; };
  const TransferFunction* transfer = medium.transfer.get();
  if (transfer) {
    const std::vector<double> cells = faces;
    for (const TransferPoint& point : transfer->points()) {
      std::vector<double> passages = cells;
      add_passages(value, point.value, passages, 32);
      faces.insert(faces.end(), passages.begin() + static_cast<std::ptrdiff_t>(cells.size()),
                   passages.end());
    }
  }
  auto tau = [&](double t) {
    if (!transfer) return medium.extinction * value(t);
    return density.in_domain(at(t)) ? medium.extinction * transfer->at(value(t)).attenuation : 0.0;
  };
  auto L = [&](double t) {
    if (medium.source == LuminanceSource::constant) return medium.color;
    if (medium.source == LuminanceSource::transfer)
      return medium.color * transfer->at(value(t)).color;
    return medium.color * luminance.value(at(t));
  };
  std::function<glm::dvec3(double)> glow;
  if (!emission.empty())
    glow = [&](double t) {
      glm::dvec3 sum(0);
      for (std::size_t i = 0; i < emission.size(); ++i)
        sum += medium.emission[i].scale * emission[i].value(at(t));
      return sum;
    };
  return plain_radiance(tau, L, faces, 0, t1, panels, glow);
}

/// Within `tolerance`, which is relative for numbers above 1.
inline void expect_equal(const RayRadiance& r, const PlainRadiance& p, double tolerance) {
  EXPECT_NEAR(r.optical_depth, p.optical_depth, tolerance * std::max(1.0, p.optical_depth));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(r.radiance[c], p.radiance[c], tolerance * std::max(1.0, p.radiance[c])) << c;
}

/// Checks the bound of a ray integrated with a loose tolerance against an accurate integration.
inline void expect_bounded(const Medium& medium, const WorldRay& ray) {
  const RayRadiance exact = ray_radiance(medium, ray, 1e-14);
  for (const double tolerance : {1e-4, 0.25e-4, 1e-8, 0.25e-8, 1e-12}) {
    const RayRadiance r = ray_radiance(medium, ray, tolerance);
    for (int c = 0; c < 3; ++c)
      EXPECT_LE(std::abs(r.radiance[c] - exact.radiance[c]), r.error + exact.error)
          << tolerance << " " << c;
  }
}

inline std::shared_ptr<const TransferFunction> function(std::vector<TransferPoint> points) {
  return std::make_shared<const TransferFunction>(std::move(points));
}

/// Noise in cells that are rotated, anisotropic and sheared.
inline Field sheared_noise() { return make_field({{-3, 2, 0}, {10, 12, 9}}, noise, sheared); }

/// Rays from around the box a..b to points in it.
inline std::vector<WorldRay> rays_through(const glm::dvec3& a, const glm::dvec3& b, int count) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> u(0, 1);
  auto point = [&] { return a + (b - a) * glm::dvec3(u(engine), u(engine), u(engine)); };
  std::vector<WorldRay> rays;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 through = point(), from = point() + 3.0 * (point() - point());
    rays.push_back(ray_through(from, through));
  }
  return rays;
}

/// Rays through the middle of `sheared_noise`.
inline std::vector<WorldRay> sheared_rays(int count) {
  return rays_through(glm::dvec3(sheared * glm::dvec4(0, 4, 2, 1)),
                      glm::dvec3(sheared * glm::dvec4(7, 10, 7, 1)), count);
}

/// The sheared noise with luminance of each source; of grids with lattices of their own.
struct EverySource {
  Field scalar = make_field({{-5, 0, 3}, {6, 16, 12}}, noise,
                            glm::scale(glm::dmat4(1), glm::dvec3(0.8)) * sheared);
  Field vector = make_vector_field(
      {{-1, -1, 1}, {16, 15, 12}}, [](glm::ivec3 v) { return glm::vec3(noise(v), 1, noise(-v)); },
      glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(0.7)), {3, 2, 1}) * sheared);
  std::vector<Medium> media{make_medium(sheared_noise(), 1.5, LuminanceSource::constant),
                            make_medium(sheared_noise(), 1.5, LuminanceSource::density),
                            make_medium(sheared_noise(), 1.5, LuminanceSource::transfer),
                            make_medium(sheared_noise(), 1.5, scalar),
                            make_medium(sheared_noise(), 1.5, vector)};
  EverySource() {
    for (Medium& medium : media) medium.color = {1, 0.5, 2};
  }
};

}  // namespace psivox
