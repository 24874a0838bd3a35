#include "study/study_cost.h"

#include <algorithm>
#include <set>

#include "study/page.h"
#include "study/report.h"

namespace psivox {
namespace {

constexpr double worth_a_line = 60, short_study = 300;  ///< [s]

/// "40 seconds", "7 minutes", "1.5 hours".
std::string duration_text(double seconds) {
  if (seconds < 90) return decimals(seconds, 0) + " seconds";
  if (seconds < 90 * 60) return decimals(seconds / 60, 0) + " minutes";
  return decimals(seconds / 3600, 1) + " hours";
}

}  // namespace

double StudyCost::pixels(const Variant& v) const {
  const glm::dvec2 own(scene_of(v, scene_).resolution), all(scene_.resolution);
  return own.x * own.y / (all.x * all.y);
}

double StudyCost::picture(const Variant& v) const {
  const Method& method = v.method;
  // as processor times of all rules go by step and segments: a fog of one emission, llvmpipe
  const double work = v.tolerance                            ? 3
                      : method.sampling == Sampling::uniform ? 0.5 / method.step
                      : method.segments == 0                 ? 0.6
                                                             : 0.2 + 0.4 * method.segments;
  return unit_ * (0.1 + work * pixels(v));
}

double StudyCost::references() const {
  double sum = 0;
  std::set<std::string> names;
  for (const Variant& v : plan_.variants)
    if (names.insert(reference_name(v)).second) sum += reference_ * pixels(v);
  return sum;
}

double StudyCost::measuring(std::size_t i) const {
  const Variant& v = plan_.variants[i];
  const Variant& last = plan_.variants[i > 0 ? i - 1 : 0];
  const bool new_program = i == 0 || last.method.integrator != v.method.integrator ||
                           last.method.sampling != v.method.sampling || last.filter != v.filter ||
                           v.tolerance;
  return picture(v) * (2 + (options_.split ? march_ : 0)) + (new_program ? compile_ : 0);
}

double StudyCost::left(const std::vector<std::optional<StudyPoint>>& points) const {
  double sum = references();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i] || (options_.split && !points[i]->arithmetic)) sum += measuring(i);
    const auto timed = points[i] ? int(points[i]->times.size()) : 0;
    sum += std::max(options_.repeats - timed, 0) * picture(plan_.variants[i]);
  }
  return sum;
}

std::string StudyCost::forecast(const Variant& tried, const CostTrial& trial) {
  unit_ *= trial.gpu / picture(tried);
  compile_ = 2 * trial.compile;
  march_ = trial.march / trial.gpu;
  reference_ = trial.reference / pixels(tried);
  const double all = left(std::vector<std::optional<StudyPoint>>(plan_.variants.size()));
  if (all < worth_a_line) return "";
  double marching = 0, fixed = 0;  // the marches in double, and what the size does not change
  for (std::size_t i = 0; i < plan_.variants.size(); ++i) {
    const double gpu = picture(plan_.variants[i]), march = march_ * gpu;
    marching += march;
    fixed += measuring(i) - 2 * gpu - march;
  }
  int part = 2;
  const auto smaller = [&] { return fixed + (all - fixed) / (part * part); };
  while (part < 8 && smaller() > short_study) ++part;
  std::string text = "the study takes about " + duration_text(all) + ", by a trial; for less: ";
  if (options_.sweep.resolutions.empty())
    text +=
        formatted("--resolution %dx%d (", scene_.resolution.x / part, scene_.resolution.y / part) +
        duration_text(smaller()) + "), ";
  if (options_.split) text += "--no-split (" + duration_text(all - marching) + "), ";
  return text + "fewer --integrators or --steps";
}

}  // namespace psivox
