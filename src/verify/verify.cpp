#include <algorithm>
#include <cmath>
#include <limits>

#include "psivox/verify.h"
#include "verify/case.h"
#include "verify/made_views.h"

namespace psivox {

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
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double a = -std::expm1(-depth(pixel_ray(view, x, y)));
      worst = larger(worst, std::abs(pixel(image, x, y, 3) - a));
      for (int c = 0; c < 3; ++c)
        worst = larger(worst, std::abs(pixel(image, x, y, c) - color[c] * a) / scale);
    }
  return worst;
}

double radiance_error(const Image& image, double radiance) {
  double worst = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      worst = larger(worst, std::abs(pixel(image, x, y, 0) - radiance));
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
