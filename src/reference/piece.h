#pragma once

#include <array>

#include "cubic.h"

namespace psivox {

/// A stretch of a ray along which all properties of the medium are polynomials of u; u is 0 at its
/// front.
struct Piece {
  Cubic x{};                 ///< tau * length; its integral is the optical depth
  std::array<Cubic, 3> L{};  ///< luminance, `channels` of them
  int channels = 0;
  bool glows = false;
  std::array<Cubic, 3> glow{};  ///< emission * length, `channels` of them; read if it glows
  double glow_share = 0;        ///< of the tolerance, for the emission's part
  double x_error = 0;           ///< bounds on rounding in x and L, beyond a few epsilon of
  double L_error = 0;           ///< themselves

  double optical_depth() const { return mean(x); }
  double max_luminance() const;  ///< a bound on |L|
  double max_glow() const;       ///< a bound on |emission * length|
};

/// Accuracy of the quadrature.
struct Accuracy {
  double tolerance;  ///< of a ray's radiance
  double T_stop;     ///< transparency at which the sum stops
};

struct PieceRadiance {
  std::array<double, 3> radiance{};
  double error = 0;  ///< bound on each channel's quadrature error
};

/// int_0^1 (L x + glow) T du with T = T_front exp(-int_0^u x), x >= 0.
PieceRadiance integrate(const Piece& piece, double T_front, const Accuracy& accuracy);

}  // namespace psivox
