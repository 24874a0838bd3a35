#include "psivox/verify.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>

#include "verify/case.h"
#include "verify/made_fields.h"
#include "verify/made_views.h"

namespace psivox {

Field Plate::field() const {
  const int last = int(values.size()) - 1;
  const glm::ivec3 side(0, half_width, half_width);
  return make_field(
      {at - side, at + side + glm::ivec3(last, 0, 0)},
      [this](glm::ivec3 v) { return float(value(v.x - at.x)); }, world_from_index);
}

double Plate::value(int x) const {
  return x < 0 || x >= int(values.size()) ? 0 : values[std::size_t(x)];
}

double Plate::across(double from, double to) const {
  double sum = 0;
  for (int x = -1; x < int(values.size()); ++x) {
    const double a = std::clamp(from - x, 0.0, 1.0), b = std::clamp(to - x, 0.0, 1.0);
    sum += (b - a) * std::lerp(value(x), value(x + 1), 0.5 * (a + b));
  }
  return sum;
}

double Plate::variation() const {
  double sum = 0;
  for (int x = -1; x < int(values.size()); ++x) sum += std::abs(value(x + 1) - value(x));
  return sum;
}

double Plate::slope(const WorldRay& ray) const {
  return (glm::inverse(glm::dmat3(world_from_index)) * ray.direction).x;
}

double Plate::along(const WorldRay& ray) const {
  const glm::dvec3 d = glm::inverse(glm::dmat3(world_from_index)) * ray.direction;
  const glm::dvec3 p =
      glm::dvec3(glm::inverse(world_from_index) * glm::dvec4(ray.origin, 1)) - glm::dvec3(at);
  const double low = -1, high = double(values.size());
  const double first = std::clamp(p.x, low, high), last = d.x > 0 ? high : low;
  for (const double x : {first, last}) {
    const glm::dvec3 q = glm::abs(p + d * ((x - p.x) / d.x));
    if (!(std::max(q.y, q.z) <= half_width)) return std::numeric_limits<double>::quiet_NaN();
  }
  return across(std::min(first, last), std::max(first, last)) / std::abs(d.x);
}

double tent_along(const WorldRay& ray, const glm::ivec3& voxel) {
  const glm::dvec3 d = ray.direction, p = ray.origin - glm::dvec3(voxel);
  std::vector<double> faces = {0};
  for (int axis = 0; axis < 3; ++axis)
    for (const double face : {-1.0, 0.0, 1.0})
      if (d[axis] != 0) faces.push_back(std::max(0.0, (face - p[axis]) / d[axis]));
  std::sort(faces.begin(), faces.end());
  const auto value = [&](double t) {
    const glm::dvec3 w = glm::max(1.0 - glm::abs(p + t * d), 0.0);
    return w.x * w.y * w.z;
  };
  double sum = 0;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    const double a = faces[i - 1], b = faces[i];
    sum += (b - a) / 6 * (value(a) + 4 * value(0.5 * (a + b)) + value(b));
  }
  return sum;
}

double rising_glow(double K, double m) { return std::sqrt(std::numbers::pi * m / (2 * K)); }

SegmentSum weighted_opacity(double front, double back) {
  const double zeta = std::exp(-0.5 * (front + back));
  const double t = -std::log(0.27 * std::exp(-back) + 0.73 * std::exp(-front));
  const double psi = t > 0 ? -std::expm1(-t) / t : 1;
  return {1 - psi, psi - zeta, zeta};
}

SegmentSum balanced(double front, double back) {
  const auto p = [](double x) { return x > 0 ? 1 - 0.5 * x / std::sinh(0.5 * x) : 0; };
  const double e_f = std::exp(-0.5 * front), e_b = std::exp(-0.5 * back);
  const double mean = std::min(0.5 * (p(front) + p(back)), 1 - e_b);
  return {1 - e_f + e_f * mean, e_f * (1 - e_b - mean), e_f * e_b};
}

double rule_across(const Plate& plate, double K, int parts, SegmentSum (*rule)(double, double),
                   const std::function<double(int x)>& L) {
  double radiance = 0, transparency = 1;
  const std::function<double(int)> value = [&](int x) { return plate.value(x); };
  const auto at = [&](const std::function<double(int)>& f, int i) {  // i segments after -1
    const int x = i / parts - 1;
    return std::lerp(f(x), f(x + 1), double(i % parts) / parts);
  };
  const auto& glow = L ? L : value;
  for (int i = 0; i < (int(plate.values.size()) + 1) * parts; ++i) {
    const SegmentSum s = rule(K * at(value, i) / parts, K * at(value, i + 1) / parts);
    radiance += transparency * (s.front * at(glow, i) + s.back * at(glow, i + 1));
    transparency *= s.transparency;
  }
  return radiance;
}

Image Painter::picture(View view) const {
  view.scene.filter = filter_;
  Drawn drawn = Session(std::move(view)).draw(gpu_);
  stuck_ += drawn.stats.stuck;
  return std::move(drawn.image);
}

double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

void Measured::add(const Measured& other) {
  error = larger(error, other.error);
  sensitivity = larger(sensitivity, other.sensitivity);
}

VerifyCase run_case(const Case& c, const Painter& painter) {
  constexpr double weight_step = 1.0 / 256;
  const Measured found = c.measure(painter);
  const bool hardware = painter.filter() == Filter::hardware;
  return {c.name, c.reason, found.error, c.bound + (hardware ? weight_step * found.sensitivity : 0),
          painter.take_stuck()};
}

double opacity_error(const View& view, const Image& image,
                     const std::function<double(const WorldRay&)>& depth) {
  const glm::dvec3& color = view.medium.color;
  const double scale = std::max({1.0, color.x, color.y, color.z});
  double worst = 0;
  for_pixels(view, image, [&](const WorldRay& ray, const float* rgba) {
    const double a = -std::expm1(-depth(ray));
    worst = larger(worst, std::abs(rgba[3] - a));
    for (int c = 0; c < 3; ++c) worst = larger(worst, std::abs(rgba[c] - color[c] * a) / scale);
  });
  return worst;
}

double radiance_error(const Image& image, double radiance) {
  double worst = 0;
  for (std::size_t i = 0; i < image.rgba().size(); i += 4)
    worst = larger(worst, std::abs(image.rgba()[i] - radiance));
  return worst;
}

double picture_difference(const Image& a, const Image& b) {
  const double mean = mean_alpha(a);
  if (!(mean > 0.02 && mean < 0.999)) return std::numeric_limits<double>::infinity();
  double worst = 0, scale = 1;
  for (std::size_t i = 0; i < a.rgba().size(); ++i) {
    worst = larger(worst, std::abs(double(a.rgba()[i]) - double(b.rgba()[i])));
    scale = larger(scale, double(a.rgba()[i]));
  }
  return worst / scale;
}

std::size_t VerifyReport::failed() const {
  return std::size_t(
      std::count_if(cases.begin(), cases.end(), [](const VerifyCase& c) { return !c.passed(); }));
}

std::uint64_t VerifyReport::stuck() const {
  std::uint64_t sum = 0;
  for (const VerifyCase& c : cases) sum += c.stuck;
  return sum;
}

VerifyReport verify(const VerifyOptions& options) {
  const std::shared_ptr<Marcher> gpu = open_gpu({.device = options.device});
  const Painter painter(*gpu, options.filter);
  VerifyReport report;
  report.renderer = description(*gpu);
  for (const auto& group : {opacity_cases(), radiance_cases(), source_cases(), invariance_cases()})
    for (const Case& c : group) {
      if (options.filter == Filter::hardware && !c.hardware) {
        report.left_out.push_back(c.name);
        continue;
      }
      report.cases.push_back(run_case(c, painter));
      if (options.progress) options.progress(report.cases.back());
    }
  return report;
}

std::string verify_note(Filter filter) {
  if (filter == Filter::exact) return "filter exact: trilinear weights in float32";
  return "filter hardware: bounds are wider by 2^-8 of what a weight changes, since devices may "
         "round trilinear weights to 8 bits";
}

}  // namespace psivox
