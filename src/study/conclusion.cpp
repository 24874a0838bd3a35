#include "study/conclusion.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "psivox/parameters.h"
#include "study/needs.h"
#include "study/number_format.h"

namespace psivox {
namespace {

using Condition = std::function<bool(const StudyPoint&)>;

/// Factors within which numbers count as equal. A ray has an end segment more or less; times of one
/// march differ by this much between runs; where rules agree, errors differ by rounding.
constexpr double same_samples = 1.05, same_time = 1.2, same_error = 1.01;

std::vector<const StudyPoint*> largest_pictures(const StudyResults& results) {
  const auto pixels = [](const StudyPoint& p) {
    return p.variant.resolution.x * p.variant.resolution.y;
  };
  int most = 0;
  for (const StudyPoint& p : results.points) most = std::max(most, pixels(p));
  std::vector<const StudyPoint*> points;
  for (const StudyPoint& p : results.points)
    if (pixels(p) == most && !p.error.radiance.not_finite && !p.error.alpha.not_finite)
      points.push_back(&p);
  return points;
}

/// Keeps the points whose number is at most `factor` times the least.
template <typename Number>
void keep_least(std::vector<const StudyPoint*>& points, double factor, Number number) {
  double least = std::numeric_limits<double>::infinity();
  for (const StudyPoint* p : points) least = std::min(least, number(*p));
  std::erase_if(points, [&](const StudyPoint* p) { return number(*p) > factor * least; });
}

const StudyPoint* cheapest(std::vector<const StudyPoint*> points, const Condition& good) {
  std::erase_if(points, [&](const StudyPoint* p) { return !good(*p); });
  if (points.empty()) return nullptr;
  keep_least(points, same_samples, [](const StudyPoint& p) { return p.samples_per_ray; });
  keep_least(points, same_time, [](const StudyPoint& p) { return cpu_ms(p).median; });
  keep_least(points, same_error, [](const StudyPoint& p) { return p.error.rms(); });
  return points.front();
}

bool within_eight_bits(const StudyPoint& p) {
  return std::max(p.error.radiance.p99, p.error.alpha.p99) <= eight_bits_error;
}

std::string look_ups(const StudyPoint& p) {
  return decimals(p.samples_per_ray, 0) + " look-ups a ray";
}

std::string quoted(const StudyPoint& p) { return "`" + options_of(p.variant) + "`"; }

}  // namespace

std::string options_of(const Variant& variant) {
  const Scene scene = scene_of(variant, {});
  const auto option = [&](const std::string& name) {
    return "--" + name + " " + parameter_text(scene, *find_parameter(name));
  };
  if (variant.tolerance) return option("tolerance");
  std::string text;
  if (variant.method.sampling == Sampling::template_) text += option("sampling") + " ";
  if (variant.method.step > 0) text += option("step") + " ";
  if (variant.method.segments > 0) text += option("segments") + " ";
  text += option("integrator");
  if (variant.filter != Filter::exact) text += " " + option("filter");
  if (variant.texel != TexelType::float32) text += " " + option("texel");
  return text;
}

Conclusion conclusion_of(const StudyResults& results) {
  const std::vector<const StudyPoint*> points = largest_pictures(results);
  Conclusion conclusion;
  conclusion.eight_bits = cheapest(points, within_eight_bits);
  // from the smallest RMS up, as long as the same point is the cheapest
  constexpr double limits[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
  for (const double rms : limits) {
    const StudyPoint* best =
        cheapest(points, [&](const StudyPoint& p) { return p.error.rms() <= rms; });
    if (conclusion.fine && best != conclusion.fine) break;
    if (!best) continue;
    conclusion.fine = best;
    conclusion.fine_rms = rms;
  }
  return conclusion;
}

std::string conclusion_text(const StudyResults& results) {
  const auto [coarse, fine, fine_rms] = conclusion_of(results);
  if (results.points.empty()) return "";
  if (!coarse && !fine) {
    const auto best = std::ranges::min_element(results.points, {},
                                               [](const StudyPoint& p) { return p.error.rms(); });
    return "No setting of this study is within 8 bits or an RMS of 1e-2; the least RMS is " +
           two_digits(best->error.rms()) + ", by " + quoted(*best) + ".";
  }
  const auto cost = [](const StudyPoint& p) {
    return quoted(p) + ": RMS " + two_digits(p.error.rms()) + ", " + look_ups(p);
  };
  const auto from = [&] { return "for an RMS of " + power_text(fine_rms) + " or less use "; };
  if (!coarse) return "No setting of this study is within 8 bits; " + from() + cost(*fine) + ".";
  const std::string text = "For 8 bits use " + cost(*coarse) + "; ";
  if (fine == coarse) return text + "no setting is cheaper.";
  if (!fine) return text + "no setting reaches an RMS of 1e-2.";
  return text + from() + quoted(*fine) + ": " + look_ups(*fine) + ".";
}

}  // namespace psivox
