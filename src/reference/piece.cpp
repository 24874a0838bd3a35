#include "piece.h"

#include <algorithm>
#include <cmath>

#include "ray_radiance.h"

namespace psivox {

// The interpolant is linear in each coordinate, so its polar form at (0,..,1) is its mean over the
// corners of the box `from`..`to` with that many coordinates at `to`: coefficient k of the cubic.
Cubic cubic_along(const std::array<double, 8>& corners, const glm::dvec3& from,
                  const glm::dvec3& to) {
  const auto mix = [](double a, double b, double f) {  // of equal values no rounding
    return a == b ? a : a * (1 - f) + b * f;
  };
  std::array<double, 8> v = corners;
  for (int axis = 0; axis < 3; ++axis) {
    const auto stride = std::size_t{4} >> axis;
    for (std::size_t i = 0; i < 8; ++i) {
      if (i & stride) continue;
      const double a = v[i], b = v[i + stride];
      v[i] = mix(a, b, from[axis]);
      v[i + stride] = mix(a, b, to[axis]);
    }
  }
  return {v[0], (v[1] + v[2] + v[4]) / 3, (v[3] + v[5] + v[6]) / 3, v[7]};
}

double max_magnitude(const Cubic& c) {
  double largest = 0;
  for (const double b : c) largest = std::max(largest, std::abs(b));
  return largest;
}

// The polar form at (a,a,a), (a,a,b), (a,b,b), (b,b,b), by de Casteljau's steps.
Cubic part(const Cubic& c, double a, double b) {
  auto polar = [&](double u, double v, double w) {
    Cubic p = c;
    std::size_t n = 3;
    for (const double t : {u, v, w}) {
      for (std::size_t i = 0; i < n; ++i) p[i] = p[i] * (1 - t) + p[i + 1] * t;
      --n;
    }
    return p[0];
  };
  return {polar(a, a, a), polar(a, a, b), polar(a, b, b), polar(b, b, b)};
}

// The derivative is d0 (1-u)^2 + 2 d1 u (1-u) + d2 u^2 up to a factor. With w = u / (1-u) its roots
// are q / d2 and d0 / q; neither is a difference of nearly equal numbers.
MonotoneEnds monotone_ends(const Cubic& c) {
  MonotoneEnds ends;
  const double d0 = c[1] - c[0], d1 = c[2] - c[1], d2 = c[3] - c[2];
  const double discriminant = d1 * d1 - d0 * d2;
  if (!(discriminant > 0)) return ends;
  const double q = -(d1 + std::copysign(std::sqrt(discriminant), d1));
  double a = q / (q + d2), b = d0 / (d0 + q);
  if (a > b) std::swap(a, b);
  for (const double u : {a, b})
    if (u > 0 && u < 1) ends.u[ends.parts++] = u;
  ends.u[ends.parts] = 1;
  return ends;
}

double crossing(const Cubic& c, double value, double a, double b) {
  const bool below = evaluate(c, a) < value;
  if ((evaluate(c, b) < value) == below) return b;
  while (true) {
    const double middle = 0.5 * (a + b);
    if (middle <= a || middle >= b) return b;
    ((evaluate(c, middle) < value) == below ? a : b) = middle;
  }
}

namespace {

// Six-point Gauss-Legendre on [0,1]: exact to degree 11.
constexpr std::array<double, 6> node{0.033765242898423989, 0.16939530676686776,
                                     0.38069040695840156,  0.61930959304159844,
                                     0.83060469323313224,  0.96623475710157601};
constexpr std::array<double, 6> weight{0.085662246189585178, 0.18038078652406930,
                                       0.23395696728634552,  0.23395696728634552,
                                       0.18038078652406930,  0.085662246189585178};

struct Panel {
  double front, back;      ///< u
  double g_front, g_back;  ///< optical depth from the piece's front
};

/// Magnitudes of the coefficients of a cubic over v in [0,1] in powers of y = v - 1/2.
using Powers = std::array<double, 4>;

Powers centred(const Cubic& c) {
  return {std::abs(c[0] + 3 * (c[1] + c[2]) + c[3]) / 8, 0.75 * std::abs(c[3] + c[2] - c[1] - c[0]),
          1.5 * std::abs(c[0] - c[1] - c[2] + c[3]), std::abs(c[3] - 3 * (c[2] - c[1]) - c[0])};
}

/// A bound on a cubic over the complex disc |y| <= R.
double over_disc(const Powers& a, double R) { return a[0] + R * (a[1] + R * (a[2] + R * a[3])); }

/// Bernstein's ellipses about [0,1], of parameter rho, in which a panel's integrand is bounded.
constexpr std::array<double, 6> ellipses{6, 9, 14, 22, 35, 55};

/// Integrates a piece. The constant part of the luminance has a closed form, so a furnace with L =
/// const is right by construction and the quadrature integrates only the variation.
class Quadrature {
 public:
  Quadrature(const Piece& piece, double T_front, const Accuracy& accuracy)
      : piece_(piece), accuracy_(accuracy), T_front_(T_front) {
    for (std::size_t k = 0; k < 4; ++k) g_[k + 1] = g_[k] + piece.x[k] / 4;
    for (std::size_t c = 0; c < channels(); ++c) {
      if (!piece.tint) L_mean_[c] = mean(piece.L[c]);
      for (std::size_t k = 0; k < 4; ++k) L_[c][k] = piece.L[c][k] - L_mean_[c];
      const double tint = piece.tint ? max_magnitude((*piece.tint)[c]) : 1;
      L_max_ = std::max(L_max_, max_magnitude(L_[c]) * tint);
      for (const Source& source : piece.sources)
        L_max_ = std::max(L_max_, max_magnitude(source.L[c]));
      if (piece.glows) glow_max_ = std::max(glow_max_, max_magnitude(piece.glow[c]));
    }
  }

  PieceRadiance sum() {
    if (glow_max_ > 0 && piece_.x == Cubic{}) {  // in vacuum the mean is the integral
      for (std::size_t c = 0; c < channels(); ++c)
        sum_.radiance[c] += T_front_ * mean(piece_.glow[c]);
    } else if (L_max_ > 0 || glow_max_ > 0) {
      add({0, 1, 0, g_[4]});
    }
    const double drop = -T_front_ * std::expm1(-g_[4]);
    for (std::size_t c = 0; c < channels(); ++c) sum_.radiance[c] += L_mean_[c] * drop;
    return sum_;
  }

 private:
  std::size_t channels() const { return std::size_t(piece_.channels); }

  double luminance(std::size_t c, double u) const {
    const double L = evaluate(L_[c], u);
    return piece_.tint ? L * evaluate((*piece_.tint)[c], u) : L;
  }

  double optical_depth(double u) const {  // Bernstein form of the quartic, g(0) = 0
    const double w = 1 - u;
    return u * (w * w * (4 * g_[1] * w + 6 * g_[2] * u) + u * u * (4 * g_[3] * w + g_[4] * u));
  }

  std::array<double, 3> gauss(const Panel& panel) const {
    std::array<double, 3> radiance{};
    const double length = panel.back - panel.front;
    for (std::size_t k = 0; k < node.size(); ++k) {
      const double u = panel.front + length * node[k];
      const double w = weight[k] * std::exp(-optical_depth(u));
      const double S = w * evaluate(piece_.x, u);
      for (std::size_t c = 0; c < channels(); ++c) radiance[c] += S * luminance(c, u);
      for (const Source& source : piece_.sources) {
        const double own = w * evaluate(source.x, u);
        for (std::size_t c = 0; c < channels(); ++c) radiance[c] += own * evaluate(source.L[c], u);
      }
      if (glow_max_ > 0)
        for (std::size_t c = 0; c < channels(); ++c) radiance[c] += w * evaluate(piece_.glow[c], u);
    }
    for (double& r : radiance) r *= length * T_front_;
    return radiance;
  }

  /// Bound on the error of `gauss`. A function f that is at most M in the ellipse of parameter rho
  /// has Chebyshev coefficients of at most 2 M / rho^k. The rule is exact for T_k, k < 12, and, by
  /// symmetry, for odd k. For the rest it is off by at most (1 + 1/143) of T_k's greatest value.
  /// The sum over k = 12, 14, ... is below 2.02 M rho^-12 / (1 - rho^-2). The ellipse lies in the
  /// disc |y| <= R = (rho + 1/rho) / 4 about the panel's middle; there powers of y bound M.
  double gauss_error(const Panel& panel, double enough) const {
    const double length = panel.back - panel.front;
    const auto on_panel = [&](const Cubic& c) { return centred(part(c, panel.front, panel.back)); };
    const Powers x = on_panel(piece_.x);
    Powers attenuates = piece_.sources.empty() ? x : Powers{};
    std::array<Powers, 3> L{}, glow{}, tint;
    tint.fill({1});
    for (std::size_t c = 0; c < channels(); ++c) {
      L[c] = on_panel(L_[c]);
      if (glow_max_ > 0) glow[c] = on_panel(piece_.glow[c]);
      if (piece_.tint) tint[c] = on_panel((*piece_.tint)[c]);
    }
    for (const Source& source : piece_.sources) {
      const Powers own = on_panel(source.x);
      for (std::size_t k = 0; k < 4; ++k) attenuates[k] += own[k];
      for (std::size_t c = 0; c < channels(); ++c) {
        const Powers of_source = on_panel(source.L[c]);
        for (std::size_t k = 0; k < 4; ++k) L[c][k] = std::max(L[c][k], of_source[k]);
      }
    }
    const double T = T_front_ * std::exp(-optical_depth(0.5 * (panel.front + panel.back)));
    double least = infinity;
    for (const double rho : ellipses) {
      const double R = (rho + 1 / rho) / 4, rho_3 = rho * rho * rho;
      double most = 0;
      for (std::size_t c = 0; c < channels(); ++c)
        most =
            std::max(most, over_disc(attenuates, R) * over_disc(L[c], R) * over_disc(tint[c], R) +
                               over_disc(glow[c], R));
      const double depth = length * over_disc({0, x[0], x[1] / 2, x[2] / 3}, R) +
                           length * x[3] / 4 * (R * R) * (R * R);
      const double off = 2.02 * length * T * std::exp(depth) * most /
                         (rho_3 * rho_3 * rho_3 * rho_3 * (1 - 1 / (rho * rho)));
      if (!(off < least)) break;
      least = off;
      if (least <= enough) break;
    }
    return least;
  }

  /// Adds the panel's radiance, by halves until the rule is within the panel's share of the
  /// tolerance. A panel may use the share T(front) - T(back); shares sum to A <= 1. Its emission
  /// may use the panel's part of the piece's share.
  void add(const Panel& panel) {
    const double T = T_front_ * std::exp(-panel.g_front);
    const double share = std::max(0.0, -T * std::expm1(panel.g_front - panel.g_back));
    const double glow = glow_max_ * T * (panel.back - panel.front);
    if (T <= accuracy_.T_stop || (share == 0 && glow == 0)) {
      sum_.error += share * L_max_ + glow;
      return;
    }
    const double middle = 0.5 * (panel.front + panel.back);
    if (middle <= panel.front || middle >= panel.back) {  // opaque between neighbouring doubles
      for (std::size_t c = 0; c < channels(); ++c)
        sum_.radiance[c] += share * luminance(c, panel.front);
      sum_.error += share * L_max_ + glow;
      return;
    }
    // exp(-g) has a relative error of epsilon * (1 + g), the polynomials one of a few epsilon.
    const double rounding = 8 * epsilon * (1 + panel.g_back);
    double enough = std::max(accuracy_.tolerance, rounding * L_max_) * share;
    enough += piece_.x_error * (panel.back - panel.front) * T * L_max_ + piece_.L_error * share;
    if (glow > 0)
      enough += std::max(accuracy_.tolerance * piece_.glow_share * (panel.back - panel.front),
                         rounding * glow);
    const double error = gauss_error(panel, enough);
    if (error <= enough) {
      const std::array<double, 3> radiance = gauss(panel);
      for (std::size_t c = 0; c < channels(); ++c) sum_.radiance[c] += radiance[c];
      sum_.error += error;
      return;
    }
    const double g_middle = optical_depth(middle);
    add({panel.front, middle, panel.g_front, g_middle});
    add({middle, panel.back, g_middle, panel.g_back});
  }

  const Piece& piece_;
  const Accuracy& accuracy_;
  double T_front_;
  std::array<double, 5> g_{};  ///< optical depth, quartic
  std::array<double, 3> L_mean_{};
  std::array<Cubic, 3> L_{};  ///< less its mean
  double L_max_ = 0;          ///< bound on |L_|
  double glow_max_ = 0;       ///< bound on |glow|; 0 where nothing glows
  PieceRadiance sum_;
};

}  // namespace

double Piece::max_luminance() const {
  double largest = 0;
  for (std::size_t c = 0; c < std::size_t(channels); ++c)
    largest = std::max(largest, max_magnitude(L[c]) * (tint ? max_magnitude((*tint)[c]) : 1));
  for (const Source& source : sources)
    for (const Cubic& of_channel : source.L) largest = std::max(largest, max_magnitude(of_channel));
  return largest;
}

double Piece::max_glow() const {
  double largest = 0;
  for (std::size_t c = 0; c < std::size_t(channels); ++c)
    largest = std::max(largest, max_magnitude(glow[c]));
  return largest;
}

PieceRadiance integrate(const Piece& piece, double T_front, const Accuracy& accuracy) {
  return Quadrature(piece, T_front, accuracy).sum();
}

}  // namespace psivox
