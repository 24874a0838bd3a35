#include "scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <limits>

#include "base/text.h"
#include "psivox/error.h"
#include "scene/color.h"

namespace psivox {
namespace {

constexpr double float_max = std::numeric_limits<float>::max();

[[noreturn]] void refuse(std::size_t index, const std::string& problem) {
  throw Error(ExitCode::input,
              "point " + std::to_string(index + 1) + " of the transfer function: " + problem);
}

/// What is wrong with a number, which must be a float32 of at least `min`; empty: nothing.
std::string problem_of(const std::string& what, double number, double min) {
  if (!(std::abs(number) <= float_max))
    return what + " " + number_text(number) + " is no finite float32";
  return number < min ? what + " " + number_text(number) + " is negative" : "";
}

void check_number(const std::string& what, double number, double min) {
  const std::string problem = problem_of(what, number, min);
  if (!problem.empty()) throw Error(ExitCode::input, problem);
}

/// Throws Error(input) unless the points are what TransferFunction says.
void check(const std::vector<TransferPoint>& points) {
  if (points.empty()) throw Error(ExitCode::input, "the transfer function has no points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto check_own = [&](const char* what, double number, double min) {
      const std::string problem = problem_of(what, number, min);
      if (!problem.empty()) refuse(i, problem);
    };
    check_own("value", points[i].value, -float_max);
    check_own("attenuation", points[i].attenuation, 0);
    for (int c = 0; c < 3; ++c) check_own("color", points[i].color[c], 0);
    if (i > 0 && points[i].value < points[i - 1].value)
      refuse(i, "values must ascend, but " + number_text(points[i].value) + " follows " +
                    number_text(points[i - 1].value));
    if (i > 1 && points[i].value == points[i - 2].value)
      refuse(i, "a third point of value " + number_text(points[i].value) +
                    "; a jump is two points of one value");
  }
}

/// Position of a number among ascending ones: fraction `t` between two of them, clamped to the
/// ends. std::lerp is exact at both ends, monotonic, and exact between equals: despite rounding, no
/// value lies beyond those at the ends.
struct Place {
  std::size_t below = 0, above = 0;
  double t = 0;
};
template <typename Knots, typename Of = std::identity>
Place place_among(const Knots& knots, double x, Of of = {}) {
  const auto next = std::size_t(std::ranges::upper_bound(knots, x, {}, of) - knots.begin());
  if (next == 0) return {};
  if (next == knots.size()) return {next - 1, next - 1, 0};
  const double a = std::invoke(of, knots[next - 1]), b = std::invoke(of, knots[next]);
  return {next - 1, next, (x - a) / (b - a)};
}

/// Fraction of an isosurface's attenuation at a distance [value] from its value.
double share(const Isosurface& surface, double distance, double gradient) {
  const double reach = surface.thickness * gradient;
  if (distance < reach) return 1 - distance / reach;
  return distance == 0 ? 1 : 0;
}

class Window {
 public:
  Window(const Scene& scene, const glm::dvec2& range) : scene_(scene), range_(range) {}

  double place(double value) const { return (value - range_.x) / (range_.y - range_.x); }

  double attenuation(double value) const {
    const double u = place(value);
    if (scene_.opacity) return scene_.opacity->at(u);
    if (scene_.shows(Shows::value)) return std::max(u, 0.0);
    if (scene_.value_scale.kind == ValueScale::Kind::symlog) return std::abs(value);
    return scene_.colormap ? std::max(value, 0.0) : std::clamp(u, 0.0, 1.0);
  }

  glm::dvec3 color(double value) const {
    const double u = place(value);
    if (scene_.colormap) return colormap_color(*scene_.colormap, u);
    return glm::dvec3(scene_.shows(Shows::value) ? std::max(u, 0.0) : 1);
  }

  /// Values at which attenuation or colour bend.
  std::vector<double> knots() const {
    std::vector<double> values = {0, range_.x, range_.y};
    const auto add = [&](double u) { values.push_back(std::lerp(range_.x, range_.y, u)); };
    if (scene_.opacity)
      for (const glm::dvec2& point : scene_.opacity->points) add(point.x);
    if (scene_.colormap)
      for (const double u : colormap_knots(*scene_.colormap)) add(u);
    return values;
  }

 private:
  const Scene& scene_;
  glm::dvec2 range_;
};

}  // namespace

TransferFunction::TransferFunction(std::vector<TransferPoint> points, bool has_color,
                                   GradientPart gradient_part)
    : points_(std::move(points)), has_color_(has_color), part_(std::move(gradient_part)) {
  place_gradient_part();
  check(points_);
  // Two values that round to one float32 are a jump as well; the later one moves up.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    float value = float(points_[i].value) + 0.0f;  // not -0
    if (i > 0 && !(value > points_[i - 1].value))
      value = std::nextafter(float(points_[i - 1].value), std::numeric_limits<float>::infinity());
    if (!std::isfinite(value)) refuse(i, "no float32 is left above the value before it");
    points_[i].value = value;
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
  const auto above = std::ranges::upper_bound(points_, value, {}, &TransferPoint::value);
  return int(above - points_.begin()) - 1;
}

TransferPoint TransferFunction::at(double value) const {
  if (std::isnan(value)) return {value, 0, glm::dvec3(0)};
  const Place place = place_among(points_, value, &TransferPoint::value);
  const TransferPoint &a = points_[place.below], &b = points_[place.above];
  TransferPoint point{value, std::lerp(a.attenuation, b.attenuation, place.t), {}};
  for (int c = 0; c < 3; ++c) point.color[c] = std::lerp(a.color[c], b.color[c], place.t);
  return point;
}

double TransferFunction::attenuation(double value) const {
  if (std::isnan(value)) return 0;
  const Place place = place_among(points_, value, &TransferPoint::value);
  return std::lerp(points_[place.below].attenuation, points_[place.above].attenuation, place.t);
}

double TransferFunction::max_attenuation(double min_value, double max_value) const {
  double most = std::max(attenuation(min_value), attenuation(max_value));
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = std::max(most, points_[std::size_t(k)].attenuation);
  return most;
}

glm::dvec3 TransferFunction::max_color(double min_value, double max_value) const {
  glm::dvec3 most = glm::max(at(min_value).color, at(max_value).color);
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = glm::max(most, points_[std::size_t(k)].color);
  return most;
}

/// Checks the part, rounds to float32 the numbers that are compared with values of grids, and takes
/// the points' attenuations from the table.
void TransferFunction::place_gradient_part() {
  std::vector<double>& gradients = part_.gradients;
  for (std::size_t j = 0; j < gradients.size(); ++j) {
    check_number("gradient", gradients[j], 0);
    const double gradient = float(gradients[j]);
    if (j > 0 && !(gradient > gradients[j - 1]))
      throw Error(ExitCode::input, "gradients must ascend, but " + number_text(gradients[j]) +
                                       " follows " + number_text(gradients[j - 1]));
    gradients[j] = gradient;
  }
  if (part_.attenuation.size() != points_.size() * gradients.size())
    throw Error(ExitCode::input,
                "the transfer function needs an attenuation of each point at each gradient");
  for (const double attenuation : part_.attenuation) check_number("attenuation", attenuation, 0);
  for (std::size_t k = 0; k < points_.size() && !gradients.empty(); ++k) {
    const double* row = part_.attenuation.data() + k * gradients.size();
    points_[k].attenuation = *std::max_element(row, row + gradients.size());
  }
  for (Isosurface& surface : part_.isosurfaces) {
    check_number("value of an isosurface", surface.value, -float_max);
    check_number("attenuation of an isosurface", surface.attenuation, 0);
    check_number("thickness of an isosurface", surface.thickness, 0);
    if (surface.thickness == 0)
      throw Error(ExitCode::input, "thickness of an isosurface is 0; nothing of it would be seen");
    surface.value = double(float(surface.value)) + 0.0;  // not -0
  }
}

double TransferFunction::table(double value, double gradient) const {
  if (part_.gradients.empty()) return attenuation(value);
  const Place column = place_among(part_.gradients, gradient);
  const auto row = [&](std::size_t point) {
    const double* of = part_.attenuation.data() + point * part_.gradients.size();
    return std::lerp(of[column.below], of[column.above], column.t);
  };
  const Place place = place_among(points_, value, &TransferPoint::value);
  return std::lerp(row(place.below), row(place.above), place.t);
}

double TransferFunction::attenuation(double value, double gradient) const {
  if (std::isnan(value)) return 0;
  double sum = table(value, gradient);
  for (const Isosurface& surface : part_.isosurfaces)
    sum += surface.attenuation * share(surface, std::abs(value - surface.value), gradient);
  return sum;
}

double TransferFunction::max_attenuation(const glm::dvec2& values,
                                         const glm::dvec2& gradients) const {
  // A bilinear function is greatest at a corner of its rectangle.
  double most = 0;
  const auto see_row = [&](double value) {
    most = std::max({most, table(value, gradients.x), table(value, gradients.y)});
    for (const double gradient : part_.gradients)
      if (gradient > gradients.x && gradient < gradients.y)
        most = std::max(most, table(value, gradient));
  };
  see_row(values.x);
  see_row(values.y);
  for (int k = interval(values.x) + 1; k <= interval(values.y); ++k)
    see_row(points_[std::size_t(k)].value);
  for (const Isosurface& surface : part_.isosurfaces) {
    const double nearest = std::max({values.x - surface.value, surface.value - values.y, 0.0});
    most += surface.attenuation * share(surface, nearest, gradients.y);
  }
  return most;
}

double OpacityCurve::at(double place) const {
  if (points.empty()) return 1;
  const Place at = place_among(points, place, &glm::dvec2::x);
  return std::lerp(points[at.below].y, points[at.above].y, at.t);
}

TransferFunction scaled_function(const TransferFunction& function, const ValueScale& scale) {
  if (scale.is_linear()) return function;
  std::vector<TransferPoint> points = function.points();
  GradientPart part = function.gradient_part();
  std::size_t gone = 0;
  if (scale.kind == ValueScale::Kind::log)
    while (gone + 1 < points.size() && points[gone + 1].value <= *scale.unit) ++gone;
  points.erase(points.begin(), points.begin() + std::ptrdiff_t(gone));
  part.attenuation.erase(part.attenuation.begin(),
                         part.attenuation.begin() + std::ptrdiff_t(gone * part.gradients.size()));
  for (TransferPoint& point : points) point.value = scale.scaled(point.value);
  for (Isosurface& surface : part.isosurfaces) surface.value = scale.scaled(surface.value);
  return TransferFunction(std::move(points), function.has_color(), std::move(part));
}

TransferFunction window_function(const Scene& scene, const glm::dvec2& range,
                                 const glm::dvec2& stored) {
  const Window window(scene, range);
  const double least = std::min(stored.x, 0.0), greatest = std::max(stored.y, 0.0);
  std::vector<double> values = {least, greatest};
  for (const double value : window.knots())
    if (value > least && value < greatest) values.push_back(value);
  // Rounded here, so that none becomes a jump of its neighbour.
  for (double& value : values) value = double(float(value));
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<TransferPoint> points;
  for (const double value : values)
    points.push_back({value, window.attenuation(value), window.color(value)});
  return TransferFunction(std::move(points), scene.colormap || scene.shows(Shows::value));
}

}  // namespace psivox
