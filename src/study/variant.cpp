#include "study/results.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "base/text.h"
#include "medium/density_function.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Fills a list of the sweep from scenes that hold its items, without duplicates.
using Fill = std::function<void(Sweep&, const std::vector<Scene>&)>;

template <typename T, typename Held>
Fill filled(std::vector<T> Sweep::*list, Held Scene::*member) {
  return [=](Sweep& sweep, const std::vector<Scene>& scenes) {
    std::vector<T>& items = sweep.*list;
    items.clear();
    for (const Scene& scene : scenes)
      if (const T item = std::optional<T>(scene.*member).value(); !std::ranges::count(items, item))
        items.push_back(item);
  };
}

/// A list, and the scene's parameter that reads and writes its items.
struct List : SweepList {
  const char* parameter;
  Fill fill;
};

const List lists[] = {
    {{"integrators", "rules, or all", "all"},
     "integrator",
     filled(&Sweep::integrators, &Scene::integrator)},
    {{"samplings", "of cells, uniform, template, or all", "cells,uniform"},
     "sampling",
     filled(&Sweep::samplings, &Scene::sampling)},
    {{"segments", "linear segments per cell, under cells", "1,2,4"},
     "segments",
     filled(&Sweep::segments, &Scene::segments)},
    {{"steps", "uniform steps [voxels]", "4,2,1,0.5,0.25"},
     "step",
     filled(&Sweep::steps, &Scene::step)},
    {{"filters", "of exact, hardware, or all", "exact"},
     "filter",
     filled(&Sweep::filters, &Scene::filter)},
    {{"texels", "of float32, code7, code12, code16, or all", "float32"},
     "texel",
     filled(&Sweep::texels, &Scene::texel)},
    {{"tolerances", "tolerances, each with the method that it chooses", ""},
     "tolerance",
     filled(&Sweep::tolerances, &Scene::tolerance)},
    {{"resolutions", "of WxH [pixels], in place of --resolution", ""},
     "resolution",
     filled(&Sweep::resolutions, &Scene::resolution)},
};

/// The variant without what does not change a picture of the scene.
Variant what_counts(Variant variant, const Scene& base) {
  if (has_rules(base)) return variant;
  variant.method.integrator = Integrator{};
  variant.method.segments = 0;
  return variant;
}

/// The reason why the scene refuses this variant, or empty. `gradient`: the scene's transfer
/// function is one of the gradient too.
std::string refusal(const Variant& variant, const Scene& base, bool gradient) {
  try {
    validate(scene_of(variant, base));
    if (gradient && !variant.tolerance) check_gradient_rules(scene_of(variant, base));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

Sweep::Sweep() {
  for (const List& list : lists)
    if (!list.usual.empty()) set_sweep(*this, list.name, list.usual);
}

std::vector<SweepList> sweep_lists() { return {std::begin(lists), std::end(lists)}; }

std::vector<std::string> swept_parameters() {
  std::vector<std::string> names = names_in(lists, &List::parameter);
  names.back() = "renderer";  // without resolutions the scene's counts
  return names;
}

void set_sweep(Sweep& sweep, std::string_view name, std::string_view text) {
  const auto list = std::ranges::find(lists, name, &List::name);
  if (list == std::end(lists))
    throw Error(ExitCode::usage, "a study has no list " + in_quotes(name) +
                                     suggestion(name, names_in(lists, &List::name)));
  const Parameter& parameter = *find_parameter(list->parameter);
  std::vector<std::string> names = split(parameter.metavar, '|');
  std::erase(names, "auto");  // one of the others
  const std::vector<std::string> items = text == "all" && names.size() > 1 ? names : split(text);
  if (items.empty())
    throw Error(ExitCode::usage, "--" + std::string(name) + " is empty; give values with commas");
  std::vector<Scene> scenes(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    set_parameter(scenes[i], parameter.name, items[i]);
    if (items[i] == parameter.unset || items[i] == "auto")
      throw Error(ExitCode::usage,
                  "--" + std::string(name) + ": " + in_quotes(items[i]) + " is no value to study");
  }
  list->fill(sweep, scenes);
}

Variant variant_of(Method method, const glm::ivec2& resolution) {
  if (is_cell_rule(method.integrator)) method.segments = 0;
  Variant variant{method};
  variant.resolution = resolution;
  return variant;
}

bool differ_in_rule(Variant a, const Variant& b) {
  a.method.integrator = b.method.integrator;
  return a == b && !a.tolerance;
}

Scene scene_of(const Variant& variant, const Scene& base) {
  Scene scene = studied_scene(base);
  if (variant.resolution.x > 0) scene.resolution = variant.resolution;
  if (variant.tolerance) {
    if (*variant.tolerance > 0) scene.tolerance = variant.tolerance;
    scene.early_termination.reset();  // the tolerance sets its own
    return scene;
  }
  scene = with_method(scene, variant.method);
  scene.filter = variant.filter;
  scene.texel = variant.texel;
  return scene;
}

Scene studied_scene(const Scene& scene) {
  Scene out = scene;
  for (const std::string& name : swept_parameters()) set_default(out, *find_parameter(name));
  out.early_termination = out.resolved_early_termination();
  // one light for all variants, so that they differ by their method alone
  out.light_quality = LightQuality::exact;
  return out;
}

bool has_rules(const Scene& scene) { return scene.attenuates(); }

std::string no_rules_note(const Scene& scene) {
  return "--mode " + parameter_text(scene, "mode") +
         " integrates nothing, so that the rule and the segments change no picture";
}

std::string rule_name(const Variant& variant) {
  if (variant.tolerance) return "chosen";
  return parameter_text(scene_of(variant, {}), "integrator");
}

std::string sampling_name(const Variant& variant) {
  const Scene scene = scene_of(variant, {});
  std::string name = scene.tolerance           ? "for " + parameter_text(scene, "tolerance")
                     : variant.tolerance       ? "by tolerance"
                     : variant.method.step > 0 ? "step " + parameter_text(scene, "step")
                                               : parameter_text(scene, "sampling");
  if (variant.method.segments) name += " " + parameter_text(scene, "segments");
  if (variant.filter != Filter::exact) name += " " + parameter_text(scene, "filter");
  if (variant.texel == TexelType::automatic)
    name += " in codes";
  else if (variant.texel != TexelType::float32)
    name += " " + parameter_text(scene, "texel");
  if (variant.resolution.x > 0) name += " " + parameter_text(scene, "resolution");
  return name;
}

Variant refinement(Variant variant) {
  variant.method.segments = 0;
  variant.method.step = 0;
  if (variant.tolerance) variant.tolerance = 0;
  return variant;
}

bool is_coarser(const Variant& a, const Variant& b) {
  return std::tuple(-a.method.step, a.method.segments, -a.tolerance.value_or(0)) <
         std::tuple(-b.method.step, b.method.segments, -b.tolerance.value_or(0));
}

std::string variant_name(const Variant& variant) {
  return rule_name(variant) + " " + sampling_name(variant);
}

std::string file_name(const Variant& variant) { return file_name(variant_name(variant)); }

std::string file_name(std::string name) {
  std::ranges::replace(name, ' ', '_');
  return name;
}

StudyPlan plan_study(const Sweep& sweep, const Scene& base) {
  StudyPlan plan;
  const bool gradient = !base.transfer_function.empty() &&
                        read_transfer_function(base.transfer_function).has_gradient();
  const auto consider_one = [&](const Variant& variant) {
    if (std::ranges::count(plan.variants, variant) ||
        std::ranges::count(plan.skipped, variant, &SkippedVariant::variant))
      return;
    std::string reason = refusal(variant, base, gradient);
    const auto no_other = [&](const Variant& other) {
      return what_counts(other, base) == what_counts(variant, base);
    };
    if (reason.empty() && std::ranges::any_of(plan.variants, no_other))
      reason = no_rules_note(base);
    if (reason.empty())
      plan.variants.push_back(variant);
    else
      plan.skipped.push_back({variant, reason});
  };
  const auto consider = [&](Variant variant) {
    if (sweep.resolutions.empty()) return consider_one(variant);
    for (const glm::ivec2& resolution : sweep.resolutions) {
      variant.resolution = resolution;
      consider_one(variant);
    }
  };
  for (const TexelType texel : sweep.texels)
    for (const Filter filter : sweep.filters)
      for (const Sampling sampling : sweep.samplings)
        for (const Integrator rule : sweep.integrators) {
          Variant variant{{rule, sampling}, filter, texel};
          if (sampling == Sampling::cells && !is_cell_rule(rule))
            for (const int segments : sweep.segments) {
              variant.method.segments = segments;
              consider(variant);
            }
          else if (sampling == Sampling::uniform)
            for (const double step : sweep.steps) {
              variant.method.step = step;
              consider(variant);
            }
          else  // a cell is one segment of such a rule; a template sets its own step
            consider(variant);
        }
  for (const double tolerance : sweep.tolerances) {
    Variant variant;
    variant.tolerance = tolerance;
    consider(variant);
  }
  return plan;
}

}  // namespace psivox
