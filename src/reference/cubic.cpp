#include "cubic.h"

#include <algorithm>
#include <cmath>

namespace psivox {

// The interpolant is linear in each coordinate, so its polar form at (0,..,1) is its mean over the
// corners of the box `from`..`to` with that many coordinates at `to`: coefficient k of the cubic.
Cubic cubic_along(const std::array<double, 8>& corners, const glm::dvec3& from,
                  const glm::dvec3& to) {
  auto mix = [](double a, double b, double f) { return a * (1 - f) + b * f; };
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

}  // namespace psivox
