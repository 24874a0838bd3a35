#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "scene/transfer_function.h"

namespace psivox {

/// A cubic over u in [0,1] by its Bernstein coefficients: for data without negative values they are
/// not negative either, so their sums lose no digits where powers of u would cancel.
using Cubic = std::array<double, 4>;

/// The trilinear interpolant of a cell's corners (at 4 dx + 2 dy + dz) from one point of the cell
/// to another.
Cubic cubic_along(const std::array<double, 8>& corners, const glm::dvec3& from,
                  const glm::dvec3& to);

inline Cubic constant_cubic(double v) { return {v, v, v, v}; }

inline void add_cubic(Cubic& sum, const Cubic& more) {
  for (std::size_t k = 0; k < 4; ++k) sum[k] += more[k];
}

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

/// A part of a cubic of values between two knots of a transfer function: attenuation and colour are
/// cubics over it.
struct ClassifiedPart {
  double begin = 0, end = 1;  ///< u
  Cubic attenuation{};
  std::array<Cubic, 3> color{};
  double attenuation_error = 0;  ///< bounds on both from rounding of the value and from fits
  double color_error = 0;
};

/// Cuts the values where they pass through the knots.
void classify(const TransferFunction& function, const Cubic& value,
              std::vector<ClassifiedPart>& parts);

/// Cuts a function of value and gradient, whose magnitude is another cubic, into parts that cubics
/// fit. `attenuation_error` has the error of the fit.
void classify(const TransferFunction& function, const Cubic& value, const Cubic& gradient,
              std::vector<ClassifiedPart>& parts);

/// One part between two knots of the values, from the points alone.
ClassifiedPart classify_part(const TransferFunction& function, const Cubic& value, double begin,
                             double end);

/// A volume along a stretch of a ray.
struct Source {
  Cubic x;                 ///< its tau * length
  std::array<Cubic, 3> L;  ///< its luminance
};

/// A stretch of a ray along which all properties of the medium are polynomials of u; u is 0 at its
/// front.
struct Piece {
  Cubic x{};                 ///< tau * length; its integral is the optical depth
  std::array<Cubic, 3> L{};  ///< luminance, `channels` of them
  int channels = 0;
  std::optional<std::array<Cubic, 3>> tint{};  ///< a factor of L
  bool glows = false;
  std::array<Cubic, 3> glow{};    ///< emission * length, `channels` of them; read if it glows
  double glow_share = 0;          ///< of the tolerance, for the emission's part
  std::vector<Source> sources{};  ///< of several volumes, in place of L; their x add up to x
  double x_error = 0;             ///< bounds on rounding in x and L, beyond a few epsilon of
  double L_error = 0;             ///< themselves

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
