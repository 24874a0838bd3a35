// The cost of a rule at a given error.

#include "study/needs.h"

#include <algorithm>
#include <cmath>

#include "study/number_format.h"

namespace psivox {
namespace {

/// The value at `rms` on the line between two points, in logarithms; `a_error` is above `rms`.
double between(double rms, double a_error, double b_error, double a, double b) {
  if (a <= 0 || b <= 0 || b_error <= 0) return b;
  const double u = std::log(rms / a_error) / std::log(b_error / a_error);
  return a * std::pow(b / a, u);
}

/// The need of a curve whose points go from coarse to fine. Steps and segments are close enough for
/// the error to fall along a line between two points.
Need need_of(const std::vector<const StudyPoint*>& points, double rms) {
  Need need{refinement(points.front()->variant), rms, {}, {}, false};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double error = points[i]->error.rms();
    if (error > rms) continue;
    const StudyPoint& fine = *points[i];
    need.at_most = i == 0;
    if (i == 0) {
      need.samples_per_ray = fine.samples_per_ray;
      need.cpu_ms = cpu_ms(fine).median;
      return need;
    }
    const StudyPoint& coarse = *points[i - 1];
    need.samples_per_ray =
        between(rms, coarse.error.rms(), error, coarse.samples_per_ray, fine.samples_per_ray);
    need.cpu_ms =
        between(rms, coarse.error.rms(), error, cpu_ms(coarse).median, cpu_ms(fine).median);
    return need;
  }
  return need;
}

}  // namespace

std::string power_text(double rms) { return "1e" + decimals(std::log10(rms), 0); }

std::vector<Need> needs_of(const StudyResults& results, const std::vector<double>& rms_wanted) {
  std::vector<std::vector<const StudyPoint*>> curves;
  for (const StudyPoint& point : results.points) {
    const auto same = [&](const auto& curve) {
      return refinement(curve.front()->variant) == refinement(point.variant);
    };
    const auto curve = std::find_if(curves.begin(), curves.end(), same);
    if (curve == curves.end())
      curves.push_back({&point});
    else
      curve->push_back(&point);
  }
  std::vector<Need> needs;
  for (auto& curve : curves) {
    std::stable_sort(curve.begin(), curve.end(), [](const StudyPoint* a, const StudyPoint* b) {
      return is_coarser(a->variant, b->variant);
    });
    for (const double rms : rms_wanted) needs.push_back(need_of(curve, rms));
  }
  return needs;
}

}  // namespace psivox
