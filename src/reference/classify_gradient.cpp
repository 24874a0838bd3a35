// Functions of value and gradient. If both are cubics, the attenuation is a polynomial of sixth
// degree (the table) plus quotients of cubics (isosurfaces). It is fitted by cubics over parts,
// which are halved until a bound on the difference is small.

#include <algorithm>
#include <cmath>

#include "ray_radiance.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Tolerance of the fitted cubics, relative to the greatest attenuation in the stretch.
constexpr double fit_tolerance = 1e-11;
/// Width below which parts of a stretch are not halved. There a fit may be off by the whole
/// attenuation, over 1e-11 of the stretch.
constexpr double least_width = 0x1p-36;

/// Bernstein coefficients of a polynomial of sixth degree.
using Sextic = std::array<double, 7>;

Sextic product(const Cubic& a, const Cubic& b) {
  constexpr std::array<double, 4> choose_3{1, 3, 3, 1};
  constexpr std::array<double, 7> choose_6{1, 6, 15, 20, 15, 6, 1};
  Sextic c{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      c[i + j] += choose_3[i] * choose_3[j] / choose_6[i + j] * a[i] * b[j];
  return c;
}

/// Bound on |a - b| over [0, 1].
double max_difference(const Sextic& a, const Sextic& b) {
  double most = 0;
  for (std::size_t i = 0; i < 7; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// A cubic that approximates a function of u.
struct Fit {
  Cubic cubic{};
  double error = 0;  ///< bound on their difference
};

/// The cubic with the function's values at the nodes of the fourth Chebyshev polynomial.
template <typename Function>
Cubic interpolate(const Function& f) {
  // 1/2 - cos((2 i + 1) pi/8)/2
  constexpr std::array<double, 4> node{0.038060233744356631, 0.30865828381745514,
                                       0.69134171618254492, 0.96193976625564337};
  // Newton's divided differences, then the Bernstein form of each product of (u - node).
  std::array<double, 4> d{};
  for (std::size_t i = 0; i < 4; ++i) d[i] = f(node[i]);
  for (std::size_t order = 1; order < 4; ++order)
    for (std::size_t i = 3; i >= order; --i) d[i] = (d[i] - d[i - 1]) / (node[i] - node[i - order]);
  Cubic c = constant_cubic(d[0]);
  const double a = node[0], b = node[1], e = node[2];
  // blossoms at (0,0,0), (0,0,1), (0,1,1), (1,1,1)
  for (int k = 0; k < 4; ++k) {
    const double s = k / 3.0, pairs = k == 2 ? 1.0 / 3 : k == 3 ? 1.0 : 0.0;
    const double triple = k == 3 ? 1.0 : 0.0;
    c[std::size_t(k)] +=
        d[1] * (s - a) + d[2] * (pairs - (a + b) * s + a * b) +
        d[3] * (triple - (a + b + e) * pairs + (a * b + a * e + b * e) * s - a * b * e);
  }
  return c;
}

/// Position of a cubic's values between two knots, as weights of both, with a bound on rounding.
struct Share {
  Cubic low{}, high{};  ///< weights of both knots, 1 together
  double error = 0;
};

Share share_between(const Cubic& number, double size, double a, double b) {
  if (!(b - a > 64 * epsilon * size)) {
    // a jump narrower than the rounding counts as its middle
    if (b > a) return {constant_cubic(0.5), constant_cubic(0.5), 1};
    return {constant_cubic(1), constant_cubic(0), 0};
  }
  Share share;
  for (std::size_t i = 0; i < 4; ++i) {
    share.high[i] = (number[i] - a) / (b - a);
    share.low[i] = (b - number[i]) / (b - a);
  }
  share.error = 8 * epsilon * (1 + size / (b - a));
  return share;
}

/// Fits cubics to one function along one stretch.
class Fitter {
 public:
  Fitter(const TransferFunction& function, const Cubic& value, const Cubic& gradient,
         std::vector<ClassifiedPart>& parts)
      : function_(function),
        value_(value),
        gradient_(gradient),
        parts_(parts),
        value_size_(max_magnitude(value)),
        gradient_size_(max_magnitude(gradient)) {
    const auto [v_low, v_high] = std::minmax_element(value.begin(), value.end());
    const auto [g_low, g_high] = std::minmax_element(gradient.begin(), gradient.end());
    most_ = function.max_attenuation({*v_low, *v_high}, {*g_low, *g_high});
    if (*v_low == *v_high) only_value_ = v_low;
  }

  void run() {
    double begin = 0;
    for (const double end : cuts()) {
      if (!(begin < end)) continue;
      fit(begin, end);
      begin = end;
    }
  }

 private:
  /// Places where the attenuation may have a kink, ascending; the last is 1.
  std::vector<double> cuts() const {
    std::vector<double> cuts{1};
    const auto cut = [&](const Cubic& c, double level) {
      const MonotoneEnds ends = monotone_ends(c);
      for (std::size_t i = 0; i < ends.parts; ++i) {
        const double u = crossing(c, level, ends.u[i], ends.u[i + 1]);
        if (u < ends.u[i + 1]) cuts.push_back(u);
      }
    };
    const GradientPart& part = function_.gradient_part();
    for (const TransferPoint& point : function_.points()) cut(value_, point.value);
    for (const double gradient : part.gradients) cut(gradient_, gradient);
    for (const Isosurface& surface : part.isosurfaces) {
      cut(value_, surface.value);
      for (const double side : {-1.0, 1.0}) cut(inside_shell(surface, side, value_, gradient_), 0);
    }
    std::sort(cuts.begin(), cuts.end());
    return cuts;
  }

  /// thickness g - side (v - f): depth inside the shell [value].
  static Cubic inside_shell(const Isosurface& surface, double side, const Cubic& value,
                            const Cubic& gradient) {
    Cubic c;
    for (std::size_t i = 0; i < 4; ++i)
      c[i] = surface.thickness * gradient[i] - side * (value[i] - surface.value);
    return c;
  }

  void fit(double begin, double end) {
    const Cubic value = part(value_, begin, end), gradient = part(gradient_, begin, end);
    const double middle = only_value_ ? *only_value_ : evaluate(value, 0.5);
    Fit sum = fit_table(value, gradient, middle);
    for (const Isosurface& surface : function_.gradient_part().isosurfaces) {
      const Fit shell = fit_shell(surface, value, gradient, middle);
      for (std::size_t i = 0; i < 4; ++i) sum.cubic[i] += shell.cubic[i];
      sum.error += shell.error;
    }
    // the quadrature needs coefficients that are not negative
    double cut = 0;
    for (double& c : sum.cubic) {
      cut = std::max(cut, -c);
      c = std::max(c, 0.0);
    }
    sum.error = std::min(sum.error + cut, most_);
    if (sum.error > fit_tolerance * most_ + rounding_ && end - begin > least_width) {
      fit(begin, 0.5 * (begin + end));
      fit(0.5 * (begin + end), end);
      return;
    }
    ClassifiedPart result = classify_part(function_, value_, begin, end);
    for (int c = 0; c < 3 && only_value_; ++c)  // a value on a knot has the knot's own colour
      result.color[std::size_t(c)] = constant_cubic(function_.at(*only_value_).color[c]);
    result.attenuation = sum.cubic;
    result.attenuation_error = sum.error;
    parts_.push_back(result);
  }

  Fit fit_table(const Cubic& value, const Cubic& gradient, double middle) {
    rounding_ = 0;
    const std::vector<TransferPoint>& points = function_.points();
    const GradientPart& gradients = function_.gradient_part();
    const std::size_t columns = std::max<std::size_t>(gradients.gradients.size(), 1);
    const int k = function_.interval(middle);
    const auto last = int(points.size()) - 1;
    const auto below = std::size_t(std::clamp(k, 0, last));
    const auto above = std::size_t(std::clamp(k + 1, 0, last));
    std::size_t left = 0, right = 0;
    Share w{constant_cubic(1), constant_cubic(0), 0};
    if (!gradients.gradients.empty()) {
      const auto next = std::upper_bound(gradients.gradients.begin(), gradients.gradients.end(),
                                         evaluate(gradient, 0.5)) -
                        gradients.gradients.begin();
      const auto last_column = std::ptrdiff_t(columns) - 1;
      left = std::size_t(std::clamp<std::ptrdiff_t>(next - 1, 0, last_column));
      right = std::size_t(std::clamp<std::ptrdiff_t>(next, 0, last_column));
      w = share_between(gradient, gradient_size_, gradients.gradients[left],
                        gradients.gradients[right]);
    }
    const auto at = [&](std::size_t point, std::size_t column) {
      return gradients.gradients.empty() ? points[point].attenuation
                                         : gradients.attenuation[point * columns + column];
    };
    const double t[] = {at(below, left), at(below, right), at(above, left), at(above, right)};
    const auto [least, greatest] = std::minmax_element(t, t + 4);
    if (*least == *greatest) return {constant_cubic(t[0]), 0};
    const Share u = share_between(value, value_size_, points[below].value, points[above].value);
    const std::array<Sextic, 4> terms{product(u.low, w.low), product(u.low, w.high),
                                      product(u.high, w.low), product(u.high, w.high)};
    Sextic exact{};
    for (std::size_t n = 0; n < 4; ++n)
      for (std::size_t i = 0; i < 7; ++i) exact[i] += t[n] * terms[n][i];
    const double rounding = (*greatest - *least) * (u.error + w.error) + 16 * epsilon * *greatest;
    rounding_ += 2 * rounding;
    const Cubic fitted = interpolate([&](double x) {
      const double ux = evaluate(u.high, x), wx = evaluate(w.high, x);
      const double uy = evaluate(u.low, x), wy = evaluate(w.low, x);
      return uy * (t[0] * wy + t[1] * wx) + ux * (t[2] * wy + t[3] * wx);
    });
    return {fitted, max_difference(exact, product(fitted, constant_cubic(1))) + rounding};
  }

  /// a (1 - N / D) with N = |v - f| and D = thickness g.
  Fit fit_shell(const Isosurface& surface, const Cubic& value, const Cubic& gradient,
                double middle) {
    if (only_value_ && *only_value_ == surface.value)
      return {constant_cubic(surface.attenuation), 0};
    const double side = middle < surface.value ? -1 : 1;
    const Cubic inside = inside_shell(surface, side, value, gradient);
    if (!(evaluate(inside, 0.5) > 0)) return {};
    const Cubic D = scaled(gradient, surface.thickness);
    const double least = *std::min_element(D.begin(), D.end());
    const Cubic fitted = interpolate([&](double x) {
      const double d = evaluate(D, x);
      return d > 0 ? std::clamp(evaluate(inside, x) / d, 0.0, 1.0) : 0.0;
    });
    double error = 1, rounding = 1;
    if (least > 0) {
      rounding =
          std::min(1.0, 16 * epsilon *
                            (1 + value_size_ / least + surface.thickness * gradient_size_ / least));
      error = max_difference(product(inside, constant_cubic(1)), product(fitted, D)) / least;
    }
    rounding_ += 2 * surface.attenuation * (least > 0 ? rounding : 0);
    return {scaled(fitted, surface.attenuation),
            surface.attenuation * std::min(1.0, error + rounding)};
  }

  const TransferFunction& function_;
  const Cubic &value_, &gradient_;
  std::vector<ClassifiedPart>& parts_;
  double value_size_, gradient_size_;
  double most_;                         ///< bound on the attenuation in the stretch
  const double* only_value_ = nullptr;  ///< set if the stretch has one value
  double rounding_ = 0;                 ///< of the current fit; halving cannot reduce it
};

}  // namespace

void classify(const TransferFunction& function, const Cubic& value, const Cubic& gradient,
              std::vector<ClassifiedPart>& parts) {
  parts.clear();
  Fitter(function, value, gradient, parts).run();
}

}  // namespace psivox
