#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace psivox {

/// A cubic over u in [0,1] by its Bernstein coefficients: for data without negative values they are
/// not negative either, so their sums lose no digits where powers of u would cancel.
using Cubic = std::array<double, 4>;

/// The trilinear interpolant of a cell's corners (at 4 dx + 2 dy + dz) from one point of the cell
/// to another.
Cubic cubic_along(const std::array<double, 8>& corners, const glm::dvec3& from,
                  const glm::dvec3& to);

inline Cubic constant_cubic(double v) { return {v, v, v, v}; }

inline Cubic scaled(const Cubic& c, double factor) {
  return {c[0] * factor, c[1] * factor, c[2] * factor, c[3] * factor};
}

/// The integral over [0,1].
inline double mean(const Cubic& c) { return (c[0] + c[1] + c[2] + c[3]) / 4; }

inline double evaluate(const Cubic& c, double u) {
  const double w = 1 - u;
  return w * w * (c[0] * w + 3 * c[1] * u) + u * u * (3 * c[2] * w + c[3] * u);
}

double max_magnitude(const Cubic& c);  ///< of the coefficients, which bounds the values

/// The cubic over [a,b], stretched to [0,1].
Cubic part(const Cubic& c, double a, double b);

/// Ends of the parts of [0,1] in which a cubic is monotone: 0, where it turns, 1.
struct MonotoneEnds {
  std::array<double, 4> u{0, 1, 1, 1};
  std::size_t parts = 1;  ///< part i is [u[i], u[i + 1]]
};
MonotoneEnds monotone_ends(const Cubic& c);

/// Where a cubic that is monotone over [a,b] passes through `value`, to neighbouring doubles; b if
/// it does not.
double crossing(const Cubic& c, double value, double a, double b);

}  // namespace psivox
