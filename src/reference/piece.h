#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace psivox {

/// A cubic over u in [0,1] by its Bernstein coefficients: of data that is nowhere negative they are
/// not negative either, so sums of them lose no digits where powers of u would cancel.
using Cubic = std::array<double, 4>;

/// The trilinear interpolant of a cell's corners (at 4 dx + 2 dy + dz) from one point of the cell
/// to another.
Cubic cubic_along(const std::array<double, 8>& corners, const glm::dvec3& from,
                  const glm::dvec3& to);

/// A stretch of a ray in which attenuation and luminance are polynomials of u, 0 at its front.
struct Piece {
  Cubic x{};                 ///< tau * length; its integral is the optical depth
  std::array<Cubic, 3> L{};  ///< luminance, `channels` of them
  int channels = 0;

  double optical_depth() const { return (x[0] + x[1] + x[2] + x[3]) / 4; }
  double max_luminance() const;  ///< a bound on |L|
};

/// How far the quadrature goes.
struct Accuracy {
  double tolerance;  ///< of a ray's radiance
  double T_stop;     ///< transparency behind which nothing is summed any more
};

struct PieceRadiance {
  std::array<double, 3> radiance{};
  double error = 0;  ///< bound on each channel's quadrature error
};

/// int_0^1 L x T du with T = T_front exp(-int_0^u x), x >= 0.
PieceRadiance integrate(const Piece& piece, double T_front, const Accuracy& accuracy);

}  // namespace psivox
