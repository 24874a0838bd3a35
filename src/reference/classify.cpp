#include "piece.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace psivox {
namespace {

/// Attenuation and colour as linear functions of the value, between two knots or outside all knots.
struct Interval {
  TransferPoint a, b;

  Interval(const TransferFunction& function, int k) {
    const auto& points = function.points();
    const int last = int(points.size()) - 1;
    a = points[std::size_t(std::clamp(k, 0, last))];
    b = points[std::size_t(std::clamp(k + 1, 0, last))];
  }

  /// The linear function that is at_a at a and at_b at b, applied to values accurate to a few
  /// epsilon of `size`. A jump narrower than the rounding counts as its middle.
  Cubic of(const Cubic& value, double size, double at_a, double at_b) const {
    if (is_blurred(size)) return constant_cubic(0.5 * (at_a + at_b));
    const double slope = (at_b - at_a) / (b.value - a.value);
    Cubic c;
    for (std::size_t i = 0; i < 4; ++i) c[i] = at_a + (value[i] - a.value) * slope;
    return c;
  }

  double error(double size, double at_a, double at_b) const {
    if (is_blurred(size)) return std::abs(at_b - at_a);
    const double slope = std::abs(at_b - at_a) / (b.value - a.value);
    return 8 * epsilon * (slope * size + std::max(at_a, at_b));
  }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  bool is_blurred(double size) const { return !(b.value - a.value > 64 * epsilon * size); }
};

/// Places where the values pass through knots, ascending.
std::vector<double> knot_crossings(const TransferFunction& function, const Cubic& value) {
  std::vector<double> cuts;
  const MonotoneEnds ends = monotone_ends(value);
  for (std::size_t i = 0; i < ends.parts; ++i) {
    double a = ends.u[i];
    const double b = ends.u[i + 1];
    const int from = function.interval(evaluate(value, a)),
              to = function.interval(evaluate(value, b));
    const int step = from < to ? 1 : -1;
    for (int k = from; k != to; k += step) {
      const auto knot = std::size_t(step > 0 ? k + 1 : k);
      a = crossing(value, function.points()[knot].value, a, b);
      cuts.push_back(a);
    }
  }
  return cuts;
}

}  // namespace

ClassifiedPart classify_part(const TransferFunction& function, const Cubic& value, double begin,
                             double end) {
  ClassifiedPart result;
  result.begin = begin;
  result.end = end;
  const Interval interval(function, function.interval(evaluate(value, 0.5 * (begin + end))));
  const Cubic own = begin > 0 || end < 1 ? part(value, begin, end) : value;
  const double size = max_magnitude(value);
  const TransferPoint &a = interval.a, &b = interval.b;
  result.attenuation = interval.of(own, size, a.attenuation, b.attenuation);
  result.attenuation_error = interval.error(size, a.attenuation, b.attenuation);
  for (int c = 0; c < 3; ++c) {
    result.color[std::size_t(c)] = interval.of(own, size, a.color[c], b.color[c]);
    result.color_error = std::max(result.color_error, interval.error(size, a.color[c], b.color[c]));
  }
  return result;
}

void classify(const TransferFunction& function, const Cubic& value,
              std::vector<ClassifiedPart>& parts) {
  parts.clear();
  const auto [low, high] = std::minmax_element(value.begin(), value.end());
  double begin = 0;
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * max_magnitude(value);
  if (*high - *low <= rounding) {  // must not be extrapolated from a steep neighbour of a knot
    const TransferPoint p = function.at(*low);
    ClassifiedPart whole;
    whole.attenuation = constant_cubic(p.attenuation);
    for (int c = 0; c < 3; ++c) whole.color[std::size_t(c)] = constant_cubic(p.color[c]);
    for (const double side : {-2 * rounding, 2 * rounding}) {
      if (*low == *high) break;
      const TransferPoint off = function.at(*low + side);
      whole.attenuation_error =
          std::max(whole.attenuation_error, std::abs(off.attenuation - p.attenuation));
      for (int c = 0; c < 3; ++c)
        whole.color_error = std::max(whole.color_error, std::abs(off.color[c] - p.color[c]));
    }
    parts.push_back(whole);
    return;
  }
  if (function.interval(*low) != function.interval(*high)) {
    for (const double end : knot_crossings(function, value)) {
      if (!(begin < end)) continue;
      parts.push_back(classify_part(function, value, begin, end));
      begin = end;
    }
  }
  if (begin < 1) parts.push_back(classify_part(function, value, begin, 1));
}

}  // namespace psivox
