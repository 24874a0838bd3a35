#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "field_voxels.h"
#include "psivox/camera.h"
#include "psivox/field.h"

namespace psivox {

/// A field at points of the world. The reference integrator is compared with it and shares no code
/// with it.
class PlainField {
 public:
  explicit PlainField(const Field& field)
      : voxels_(field),
        one_(field.channels == 1),
        domain_(field.domain()),
        index_from_world_(glm::inverse(field.world_from_index)) {}

  glm::dvec3 voxel(const glm::ivec3& v) const {
    const glm::dvec3 value(voxels_(v));
    return one_ ? glm::dvec3(value.x) : value;
  }

  glm::dvec3 index_at(const glm::dvec3& world) const {
    return glm::dvec3(index_from_world_ * glm::dvec4(world, 1));
  }

  bool in_domain(const glm::dvec3& world) const {
    const glm::dvec3 p = index_at(world);
    for (int i = 0; i < 3; ++i)
      if (p[i] < domain_.min[i] || p[i] > domain_.max[i]) return false;
    return true;
  }

  glm::dvec3 value(const glm::dvec3& world) const {
    if (!in_domain(world)) return glm::dvec3(0);
    const glm::dvec3 p = index_at(world);
    const glm::dvec3 cell = glm::floor(p), f = p - cell;
    glm::dvec3 sum(0);
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 d(i & 1, (i >> 1) & 1, i >> 2);
      const double w = (d.x ? f.x : 1 - f.x) * (d.y ? f.y : 1 - f.y) * (d.z ? f.z : 1 - f.z);
      if (w != 0) sum += w * voxel(glm::ivec3(cell) + d);
    }
    return sum;
  }

  /// Adds every t in (t0, t1) where the ray meets a face of the domain's cells.
  void add_faces(const WorldRay& ray, double t0, double t1, std::vector<double>& faces) const {
    const glm::dvec3 p = index_at(ray.origin);
    const glm::dvec3 d = index_at(ray.origin + ray.direction) - p;
    for (int i = 0; i < 3; ++i) {
      for (int plane = domain_.min[i]; plane <= domain_.max[i] && d[i] != 0; ++plane) {
        const double t = (plane - p[i]) / d[i];
        if (t > t0 && t < t1) faces.push_back(t);
      }
    }
  }

 private:
  FieldVoxels voxels_;
  bool one_;  ///< channel
  Box domain_;
  glm::dmat4 index_from_world_;
};

struct PlainRadiance {
  glm::dvec3 radiance{0};
  double optical_depth = 0;
};

/// Adds the places between faces where f crosses `target`. It detects them from `samples` points
/// between neighbouring faces and bisects them. It misses a value that crosses and returns between
/// two points.
inline void add_passages(const std::function<double(double)>& f, double target,
                         std::vector<double>& faces, int samples) {
  std::vector<double> sorted = faces;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 0; k + 1 < sorted.size(); ++k) {
    const double h = (sorted[k + 1] - sorted[k]) / samples;
    for (int i = 0; i < samples; ++i) {
      double a = sorted[k] + h * (i + 1e-9), b = sorted[k] + h * (i + 1 - 1e-9);
      const bool below = f(a) < target;
      if ((f(b) < target) == below) continue;
      for (int n = 0; n < 60; ++n) {
        const double middle = 0.5 * (a + b);
        ((f(middle) < target) == below ? a : b) = middle;
      }
      faces.push_back(b);
    }
  }
}

/// int (L tau + glow) T dt over [t0, t1] by three-point Gauss rules on `panels` panels between
/// faces. The optical depth of a part of a panel uses two points, so it is exact for a cubic.
inline PlainRadiance plain_radiance(const std::function<double(double)>& tau,
                                    const std::function<glm::dvec3(double)>& L,
                                    std::vector<double> faces, double t0, double t1, int panels,
                                    const std::function<glm::dvec3(double)>& glow = {}) {
  faces.push_back(t0);
  faces.push_back(t1);
  std::sort(faces.begin(), faces.end());
  auto depth = [&](double a, double b) {
    const double off = (b - a) * std::sqrt(1.0 / 12), middle = 0.5 * (a + b);
    return (b - a) / 2 * (tau(middle - off) + tau(middle + off));
  };
  PlainRadiance sum;
  for (std::size_t k = 0; k + 1 < faces.size(); ++k) {
    const double h = (faces[k + 1] - faces[k]) / panels;
    if (h < 1e-14 * (t1 - t0)) continue;
    for (int i = 0; i < panels; ++i) {
      // Stops slightly before the faces: a domain may end there.
      const double a = faces[k] + h * (i == 0 ? 1e-12 : i);
      const double b = faces[k] + h * (i + 1 == panels ? panels - 1e-12 : i + 1);
      constexpr std::array<double, 3> x{0.1127016653792583, 0.5, 0.8872983346207417};
      constexpr std::array<double, 3> w{5.0 / 18, 8.0 / 18, 5.0 / 18};
      for (std::size_t n = 0; n < 3; ++n) {
        const double t = a + (b - a) * x[n];
        const double T = std::exp(-sum.optical_depth - depth(a, t));
        sum.radiance += w[n] * (b - a) * T * tau(t) * L(t);
        if (glow) sum.radiance += w[n] * (b - a) * T * glow(t);
      }
      sum.optical_depth += depth(a, b);
    }
  }
  return sum;
}

}  // namespace psivox
