#include "study/study_plots.h"

#include <algorithm>
#include <functional>
#include <iterator>

#include "psivox/text_file.h"
#include "study/pareto.h"

namespace psivox {
namespace {

constexpr Ink inks[] = {{31, 119, 180},  {255, 127, 14}, {44, 160, 44},   {214, 39, 40},
                        {148, 103, 189}, {140, 86, 75},  {227, 119, 194}, {127, 127, 127},
                        {188, 189, 34},  {23, 190, 207}, {0, 0, 0},       {0, 90, 160},
                        {120, 200, 120}, {170, 110, 40}};

constexpr Ink chosen_ink{230, 60, 140};
Ink ink_of(const Variant& variant) {
  return variant.tolerance ? chosen_ink : ink_of(variant.integrator);
}

Drawing::Shape shape_of(Sampling sampling) {
  return sampling == Sampling::cells     ? Drawing::Shape::square
         : sampling == Sampling::uniform ? Drawing::Shape::disc
                                         : Drawing::Shape::diamond;
}
Drawing::Shape shape_of(const Variant& variant) {
  return variant.tolerance ? Drawing::Shape::ring : shape_of(variant.sampling);
}

/// Cells' curves are dashed.
bool is_dashed(const Variant& variant) {
  return !variant.tolerance && variant.sampling == Sampling::cells;
}

/// Errors nearer than that are drawn as one.
constexpr double front_margin = 0.01;

using Abscissa = std::function<double(const StudyPoint&)>;

Plot plot_of(const StudyResults& results, const std::string& title, const std::string& x_label,
             const Abscissa& x) {
  std::vector<const StudyPoint*> points;
  for (const StudyPoint& point : results.points)
    if (x(point) > 0) points.push_back(&point);
  // From coarse to fine, which is how a curve joins them.
  std::stable_sort(points.begin(), points.end(), [](const StudyPoint* a, const StudyPoint* b) {
    return is_coarser(a->variant, b->variant);
  });
  std::vector<PlotCurve> curves;
  for (const StudyPoint* point : points) {
    const auto same = [&](const PlotCurve& c) {
      return refinement(c.variant) == refinement(point->variant);
    };
    auto curve = std::find_if(curves.begin(), curves.end(), same);
    if (curve == curves.end()) curve = curves.insert(curve, {point->variant, {}});
    curve->points.emplace_back(x(*point), point->error.rms());
  }
  Plot plot = plot_of_curves(curves);
  plot.title = title;
  plot.x_label = x_label;
  plot.y_label = "RMS over R G B A against the reference";
  return plot;
}

void mark_front(Plot& plot, const StudyResults& results, const Abscissa& x) {
  std::vector<Cost> costs;
  for (const StudyPoint& point : results.points)
    if (x(point) > 0) costs.push_back({x(point), point.error.rms()});
  for (const std::size_t i : pareto_front(costs, front_margin))
    plot.front.emplace_back(costs[i].time, costs[i].error);
  if (!plot.front.empty())
    plot.legend.push_back({"Pareto front", {200, 0, 0}, Drawing::Shape::ring});
}

}  // namespace

Ink ink_of(Integrator rule) { return inks[static_cast<std::size_t>(rule) % std::size(inks)]; }

std::string write_plot(const NamedPlot& named, const std::filesystem::path& folder) {
  const Drawing drawing = draw(named.plot);
  std::string svg = svg_of(drawing);
  write_text((folder / (named.name + ".svg")).string(), svg);
  write_image(picture_of(drawing), folder / (named.name + ".png"));
  return svg;
}

Plot plot_of_curves(const std::vector<PlotCurve>& curves) {
  Plot plot;
  for (const PlotCurve& curve : curves) {
    const Variant& v = curve.variant;
    plot.series.push_back({curve.points, ink_of(v), shape_of(v), is_dashed(v)});
  }
  std::vector<std::string> rules;
  for (const PlotCurve& curve : curves) {
    const std::string rule = rule_name(curve.variant);
    if (std::find(rules.begin(), rules.end(), rule) != rules.end()) continue;
    rules.push_back(rule);
    plot.legend.push_back({rule, ink_of(curve.variant)});
  }
  constexpr Ink ink{60, 60, 60};
  const std::pair<Sampling, const char*> samplings[] = {{Sampling::uniform, "uniform"},
                                                        {Sampling::cells, "cells"},
                                                        {Sampling::template_, "template"}};
  for (const auto& [sampling, name] : samplings) {
    const auto has = [&](const PlotCurve& c) {
      return !c.variant.tolerance && c.variant.sampling == sampling;
    };
    if (std::any_of(curves.begin(), curves.end(), has))
      plot.legend.push_back({name, ink, shape_of(sampling), true, sampling == Sampling::cells});
  }
  return plot;
}

std::vector<NamedPlot> plots_of(const StudyResults& results) {
  std::vector<NamedPlot> plots;
  const auto add = [&](const char* name, const char* title, const char* x_label, const Abscissa& x,
                       bool front) {
    const auto has = [&](const StudyPoint& p) { return x(p) > 0; };
    if (std::none_of(results.points.begin(), results.points.end(), has)) return;
    Plot plot = plot_of(results, title, x_label, x);
    if (front) mark_front(plot, results, x);
    plots.push_back({name, std::move(plot)});
  };
  add(
      "error-step", "Error by step", "uniform step [voxels]",
      [](const StudyPoint& p) { return p.variant.step; }, false);
  add(
      "error-samples", "Error by look-ups", "field look-ups a ray",
      [](const StudyPoint& p) { return p.samples_per_ray; }, true);
  add(
      "error-time", "Error by the GPU's time", "time of the draws by the GPU's timer [ms], median",
      [](const StudyPoint& p) { return gpu_ms(p).median; }, true);
  add(
      "error-cpu", "Error by processor time", "processor time of the march [ms], median",
      [](const StudyPoint& p) { return cpu_ms(p).median; }, true);
  return plots;
}

}  // namespace psivox
