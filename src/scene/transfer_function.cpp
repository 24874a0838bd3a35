#include "psivox/transfer_function.h"
#include "psivox/text.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "psivox/error.h"

namespace psivox {
namespace {

constexpr double float_max = std::numeric_limits<float>::max();

[[noreturn]] void refuse(std::size_t index, const std::string& problem) {
  throw Error(ExitCode::input,
              "point " + std::to_string(index + 1) + " of the transfer function: " + problem);
}

void check_number(std::size_t index, const char* what, double number, double min) {
  if (!(std::abs(number) <= float_max))
    refuse(index, std::string(what) + " " + number_text(number) + " is no finite float32");
  if (number < min) refuse(index, std::string(what) + " " + number_text(number) + " is negative");
}

/// Throws Error(input) unless the points are what TransferFunction says.
void check(const std::vector<TransferPoint>& points) {
  if (points.empty()) throw Error(ExitCode::input, "the transfer function has no points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    check_number(i, "value", points[i].value, -float_max);
    check_number(i, "attenuation", points[i].attenuation, 0);
    for (int c = 0; c < 3; ++c) check_number(i, "color", points[i].color[c], 0);
    if (i > 0 && points[i].value < points[i - 1].value)
      refuse(i, "values must ascend, but " + number_text(points[i].value) + " follows " +
                    number_text(points[i - 1].value));
    if (i > 1 && points[i].value == points[i - 2].value)
      refuse(i, "a third point of value " + number_text(points[i].value) +
                    "; a jump is two points of one value");
  }
}

/// std::lerp is exact at both ends, monotonic, and exact between equals: despite rounding, no value
/// lies beyond those at the ends.
TransferPoint between(const TransferPoint& a, const TransferPoint& b, double value) {
  const double t = (value - a.value) / (b.value - a.value);
  TransferPoint p{value, std::lerp(a.attenuation, b.attenuation, t), {}};
  for (int c = 0; c < 3; ++c) p.color[c] = std::lerp(a.color[c], b.color[c], t);
  return p;
}

}  // namespace

TransferFunction::TransferFunction(std::vector<TransferPoint> points, bool has_color,
                                   GradientPart gradient_part)
    : points_(std::move(points)), has_color_(has_color), part_(std::move(gradient_part)) {
  place_gradient_part();
  check(points_);
  // Two values that round to one float32 are a jump as well; the later one moves up.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    float value = static_cast<float>(points_[i].value) + 0.0f;  // not -0
    if (i > 0 && !(value > points_[i - 1].value))
      value = std::nextafter(static_cast<float>(points_[i - 1].value),
                             std::numeric_limits<float>::infinity());
    if (!std::isfinite(value)) refuse(i, "no float32 is left above the value before it");
    points_[i].value = value;
  }
  integrals_.resize(points_.size());
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const TransferPoint &a = points_[i - 1], &b = points_[i];
    integrals_[i] = integrals_[i - 1] + (b.value - a.value) * 0.5 * (a.attenuation + b.attenuation);
  }
}

TransferFunction TransferFunction::attenuation_alone() const {
  double most = 0;
  for (const TransferPoint& point : points_) most = std::max(most, point.attenuation);
  const double rounding = std::ldexp(most, -23);
  std::vector<TransferPoint> kept;
  for (std::size_t i = 0; i < points_.size();) {
    kept.push_back({points_[i].value, points_[i].attenuation});
    // slopes of the lines from here that pass all points so far
    double least = -HUGE_VAL, greatest = HUGE_VAL;
    std::size_t next = i + 1;
    for (std::size_t k = i + 1; k < points_.size(); ++k) {
      const double width = points_[k].value - points_[i].value;
      const double rise = points_[k].attenuation - points_[i].attenuation;
      if (rise < least * width || rise > greatest * width) break;
      next = k;
      least = std::max(least, (rise - rounding) / width);
      greatest = std::min(greatest, (rise + rounding) / width);
      // a table of gradients has a row for each point
      if (!part_.gradients.empty()) break;
    }
    i = next;
  }
  return TransferFunction(std::move(kept), false, part_);
}

int TransferFunction::interval(double value) const {
  const auto above =
      std::upper_bound(points_.begin(), points_.end(), value,
                       [](double v, const TransferPoint& point) { return v < point.value; });
  return static_cast<int>(above - points_.begin()) - 1;
}

TransferPoint TransferFunction::at(double value) const {
  const int k = interval(value);
  const auto below = static_cast<std::size_t>(std::max(k, 0)), above = below + 1;
  if (k >= 0 && above < points_.size()) return between(points_[below], points_[above], value);
  TransferPoint point = points_[below];
  point.value = value;
  return point;
}

double TransferFunction::max_attenuation(double min_value, double max_value) const {
  double most = std::max(at(min_value).attenuation, at(max_value).attenuation);
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = std::max(most, points_[static_cast<std::size_t>(k)].attenuation);
  return most;
}

glm::dvec3 TransferFunction::max_color(double min_value, double max_value) const {
  glm::dvec3 most = glm::max(at(min_value).color, at(max_value).color);
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = glm::max(most, points_[static_cast<std::size_t>(k)].color);
  return most;
}

double TransferFunction::attenuation_integral(double value) const {
  const auto k = static_cast<std::size_t>(std::max(interval(value), 0));
  const double mean = 0.5 * (points_[k].attenuation + at(value).attenuation);
  return integrals_[k] + (value - points_[k].value) * mean;
}

}  // namespace psivox
