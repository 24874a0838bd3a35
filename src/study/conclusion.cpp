#include "study/conclusion.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "psivox/parameters.h"

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
    if (pixels(p) == most && !p.error.not_finite()) points.push_back(&p);
  return points;
}

/// Keeps the points whose number is at most `factor` times the least.
template <typename Number>
void keep_least(std::vector<const StudyPoint*>& points, double factor, Number number) {
  double least = HUGE_VAL;
  for (const StudyPoint* p : points) least = std::min(least, std::invoke(number, *p));
  std::erase_if(points,
                [&](const StudyPoint* p) { return std::invoke(number, *p) > factor * least; });
}

const StudyPoint* cheapest(std::vector<const StudyPoint*> points, const Condition& good) {
  std::erase_if(points, [&](const StudyPoint* p) { return !good(*p); });
  if (points.empty()) return nullptr;
  keep_least(points, same_samples, &StudyPoint::samples_per_ray);
  keep_least(points, same_time, median_cpu_ms);
  keep_least(points, same_error, &StudyPoint::rms);
  return points.front();
}

std::string look_ups(const StudyPoint& p) {
  return decimals(p.samples_per_ray, 0) + " look-ups a ray";
}

bool by_default_rule(const StudyPoint& p) {
  Scene scene = scene_of(p.variant, {});
  scene.integrator.reset();
  return scene.resolved_integrator() == p.variant.method.integrator;
}

/// The point that stands for all points with its picture.
const StudyPoint* first_of_same(const StudyResults& results, const StudyPoint* point) {
  if (!point) return nullptr;
  const auto same = same_pictures(results, *point);
  const auto found = std::ranges::find_if(same, [](auto* p) { return by_default_rule(*p); });
  return found == same.end() ? same.front() : *found;
}

/// Points of one refinement(), from coarse to fine.
using StudyCurve = std::vector<const StudyPoint*>;

/// The points' curves, in the order of their first points.
std::vector<StudyCurve> curves_of(const std::vector<const StudyPoint*>& points) {
  std::vector<StudyCurve> curves;
  for (const StudyPoint* point : points) {
    auto curve = std::ranges::find_if(curves, [&](const StudyCurve& c) {
      return refinement(c.front()->variant) == refinement(point->variant);
    });
    if (curve == curves.end()) curve = curves.insert(curve, StudyCurve{});
    curve->push_back(point);
  }
  for (StudyCurve& curve : curves)
    std::ranges::stable_sort(curve, [](const StudyPoint* a, const StudyPoint* b) {
      return is_coarser(a->variant, b->variant);
    });
  return curves;
}

/// A sentence on points whose error is greater than that of a wider step before them; empty if
/// there are none. Errors that are those of float32 say nothing about steps.
std::string rises_note(const StudyResults& results) {
  constexpr double rises = 1.05, rounding = 3;
  std::vector<std::string> all;
  for (const StudyCurve& curve : curves_of(largest_pictures(results)))
    for (std::size_t i = 1; i < curve.size(); ++i) {
      const StudyPoint &coarse = *curve[i - 1], &fine = *curve[i];
      const double noise = fine.arithmetic ? rounding * fine.arithmetic->rms() : 1e-6;
      if (fine.variant.tolerance || !(fine.rms() > std::max(noise, rises * coarse.rms()))) continue;
      all.push_back(rule_name(fine.variant) + " " + two_digits(fine.rms()) + " at " +
                    sampling_name(fine.variant) + ", " + two_digits(coarse.rms()) + " at " +
                    sampling_name(coarse.variant));
    }
  return all.empty() ? "" : " The error rises with a smaller step: " + joined(all, ". ") + ".";
}

}  // namespace

bool within_eight_bits(const StudyPoint& p) {
  return !p.error.not_finite() && std::max(p.error.radiance.p99, p.error.alpha.p99) <= 0.5 / 255;
}

std::string same_as(const StudyPoint& point) {
  return point.same_as.empty() ? variant_name(point.variant) : point.same_as;
}

std::vector<const StudyPoint*> same_pictures(const StudyResults& results, const StudyPoint& point) {
  std::vector<const StudyPoint*> same;
  for (const StudyPoint& p : results.points)
    if (same_as(p) == same_as(point)) same.push_back(&p);
  return same;
}

std::string settings_text(const Scene& scene, const std::vector<Variant>& same) {
  Variant variant = same.front();
  if (!has_rules(scene) && !variant.tolerance) {
    variant.method.segments = 0;
    return "`" + options_of(variant, false) + "`";
  }
  if (same.size() == 1) return "`" + options_of(variant) + "`";
  std::string text = "`" + options_of(variant, false) + "` with";
  for (std::size_t i = 0; i < same.size(); ++i)
    text += (i == 0 ? " " : i + 1 < same.size() ? ", " : " or ") + rule_name(same[i]);
  return text;
}

std::string no_winner_note(const Scene& scene, bool lists_rules) {
  if (!has_rules(scene)) return " " + no_rules_note(scene) + ".";
  return lists_rules ? " Pictures by the rules of one list are the same but for rounding." : "";
}

std::string options_of(const Variant& variant, bool with_rule) {
  const Scene scene = scene_of(variant, {});
  std::string text;
  const auto add = [&](const std::string& name) {
    text += (text.empty() ? "--" : " --") + name + " " + parameter_text(scene, name);
  };
  if (variant.tolerance) {
    add("tolerance");
    return text;
  }
  const bool cells_alone = variant.method.step == 0 && variant.method.segments == 0 && !with_rule;
  if (variant.method.sampling == Sampling::template_ || cells_alone) add("sampling");
  if (variant.method.step > 0) add("step");
  if (variant.method.segments > 0) add("segments");
  if (with_rule) add("integrator");
  if (variant.filter != Filter::exact) add("filter");
  if (variant.texel != TexelType::float32) add("texel");
  return text;
}

Conclusion conclusion_of(const StudyResults& results) {
  const std::vector<const StudyPoint*> points = largest_pictures(results);
  Conclusion conclusion;
  conclusion.eight_bits = first_of_same(results, cheapest(points, within_eight_bits));
  // from the smallest RMS up, as long as the same point is the cheapest
  constexpr double limits[] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
  for (const double rms : limits) {
    const StudyPoint* best = first_of_same(
        results, cheapest(points, [&](const StudyPoint& p) { return p.rms() <= rms; }));
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
  const Scene scene = scene_in(results);
  bool lists_rules = false;
  const auto settings = [&](const StudyPoint& p) {
    std::vector<Variant> same;
    for (const StudyPoint* other : same_pictures(results, p)) same.push_back(other->variant);
    lists_rules |= same.size() > 1;
    return settings_text(scene, same);
  };
  const auto cost = [&](const StudyPoint& p) {
    return settings(p) + ": RMS " + two_digits(p.rms()) + ", " + look_ups(p);
  };
  const auto from = [&] {
    return formatted("for an RMS of 1e%.0f or less use ", std::log10(fine_rms));
  };
  std::string text;
  if (!coarse && !fine) {
    const auto best = std::ranges::min_element(results.points, {}, &StudyPoint::rms);
    text = "No setting of this study is within 8 bits or an RMS of 1e-2; the least RMS is " +
           two_digits(best->rms()) + ", by " + settings(*best);
  } else if (!coarse) {
    text = "No setting of this study is within 8 bits; " + from() + cost(*fine);
  } else {
    text = "For 8 bits use " + cost(*coarse) + "; ";
    text += fine == coarse ? "no setting is cheaper"
            : !fine        ? "no setting reaches an RMS of 1e-2"
                           : from() + settings(*fine) + ": " + look_ups(*fine);
  }
  return text + "." + no_winner_note(scene, lists_rules) + rises_note(results);
}

Json conclusion_json(const StudyResults& results) {
  const Conclusion conclusion = conclusion_of(results);
  const auto advice = [&](const StudyPoint* p) -> Json {
    if (!p) return nullptr;
    Json rules = Json::array();
    for (const StudyPoint* same : same_pictures(results, *p))
      rules.push_back(rule_name(same->variant));
    return {{"options", options_of(p->variant)},
            {"rules", std::move(rules)},
            {"rms", p->rms()},
            {"samples_per_ray", p->samples_per_ray}};
  };
  Json out = {{"sentence", conclusion_text(results)},
              {"eight_bits", advice(conclusion.eight_bits)},
              {"fine", advice(conclusion.fine)}};
  if (conclusion.fine) out["fine"]["from_rms"] = conclusion.fine_rms;
  return out;
}

}  // namespace psivox
