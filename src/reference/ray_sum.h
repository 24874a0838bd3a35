#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

#include "piece.h"
#include "psivox/field.h"

namespace psivox {

inline double max_component(const glm::dvec3& v) { return std::max(v.x, std::max(v.y, v.z)); }

/// Size of a crossing's coordinates in voxels; its position is off by epsilon times this size.
inline double extent(const Field& field) {
  const Box box = field.domain();
  return max_component(glm::dvec3(box.max) - glm::dvec3(box.min));
}

/// Sums over a ray. A factor of all pieces' radiance may be applied at the end.
struct RaySum {
  glm::dvec3 radiance{0};
  double optical_depth = 0;
  double T = 1;
  double error = 0;
  double depth_error = 0;  ///< bound on the rounding of the optical depth, beyond its terms'
  double glow = 0;         ///< bound on the emission's part of the radiance
  double L_max = 0;        ///< of the pieces so far
  std::uint64_t pieces = 0;
  std::uint64_t cells = 0;

  void pass(double depth) {
    optical_depth += depth;
    T = std::exp(-optical_depth);
    ++pieces;
  }

  void add(const Piece& piece, const Accuracy& accuracy) {
    const PieceRadiance r = integrate(piece, T, accuracy);
    const double depth = piece.optical_depth();
    for (int c = 0; c < piece.channels; ++c) radiance[c] += r.radiance[static_cast<std::size_t>(c)];
    error += r.error + piece.L_error * T * std::min(depth, 1.0);
    depth_error += piece.x_error;
    if (piece.glows) glow += T * piece.max_glow();
    L_max = std::max(L_max, piece.max_luminance());
    pass(depth);
  }

  double opacity() const { return -std::expm1(-optical_depth); }

  /// Bound on rounding's part of the error. A crossing is off by epsilon times its coordinates, a
  /// sum by epsilon times its terms; an error d of the optical depth changes L T, and everything
  /// behind it, by L d at most.
  double rounding(double extents) const { return rounding(extents, L_max, glow); }
  /// The same of the opacity.
  double opacity_rounding(double extents) const { return rounding(extents, 1, 0); }

 private:
  double rounding(double extents, double L, double emission) const {
    const double roundings = 16 + static_cast<double>(pieces) + extents;
    return roundings * std::numeric_limits<double>::epsilon() * (opacity() * L + emission) +
           depth_error * (2 * L + emission);
  }
};

}  // namespace psivox
