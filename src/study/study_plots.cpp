#include "study/page.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/marcher.h"
#include "study/report.h"

namespace psivox {

std::vector<PlotPoint> pareto_front(std::vector<PlotPoint> points, double margin) {
  std::ranges::stable_sort(points, {}, [](const PlotPoint& p) { return std::pair(p.x, p.y); });
  std::vector<PlotPoint> front;
  for (const PlotPoint& point : points)
    if (front.empty() || point.y < (1 - margin) * front.back().y) front.push_back(point);
  return front;
}

namespace {

const char* shape_name(Shape shape) {
  constexpr const char* names[] = {"disc", "square", "diamond", "ring", "triangle"};
  return names[int(shape)];
}

// Data for src/study/page/plots.js.

Json json_of(const Series& series) {
  Json out = {{"entries", series.entries},
              {"color", hex(series.ink)},
              {"shape", shape_name(series.shape)},
              {"dashed", series.dashed},
              {"points", Json::array()}};
  for (const PlotPoint& point : series.points) {
    if (!has_place(point)) continue;
    out["points"].push_back({point.x, point.y, point.name});
    if (point.lower > 0)
      out["points"].back().insert(out["points"].back().end(), {point.lower, point.upper});
  }
  if (series.front) out["front"] = true;
  return out;
}

Json json_of(const LegendEntry& entry) {
  return {{"text", entry.text},
          {"color", hex(entry.ink)},
          {"shape", shape_name(entry.shape)},
          {"joined", entry.joined},
          {"dashed", entry.dashed}};
}

Json json_of(const Plot& plot) {
  Json out = {{"title", plot.title},
              {"x", plot.x_label},
              {"y", plot.y_label},
              {"legend", Json::array()},
              {"series", Json::array()}};
  for (const LegendEntry& entry : plot.legend) out["legend"].push_back(json_of(entry));
  for (const Series& series : plot.series) out["series"].push_back(json_of(series));
  return out;
}

Html html_json(const Html& attributes, const Json& data) {
  return Html("<script type=\"application/json\"") + attributes + ">" +
         Html::of_markup(without_tags(data.dump(-1, ' ', false, Json::error_handler_t::replace))) +
         "</script>\n";
}

constexpr Ink inks[] = {{31, 119, 180},  {255, 127, 14}, {44, 160, 44},   {214, 39, 40},
                        {148, 103, 189}, {140, 86, 75},  {227, 119, 194}, {127, 127, 127},
                        {188, 189, 34},  {23, 190, 207}, {0, 0, 0},       {110, 0, 60},
                        {120, 200, 120}, {170, 110, 40}};

constexpr Ink chosen_ink{230, 60, 140};
Ink ink_of(const Variant& variant) {
  return variant.tolerance ? chosen_ink : ink_of(variant.method.integrator);
}

Shape shape_of(Sampling sampling) {
  return sampling == Sampling::cells     ? Shape::square
         : sampling == Sampling::uniform ? Shape::disc
                                         : Shape::diamond;
}
Shape shape_of(const Variant& variant) {
  return variant.tolerance ? Shape::ring : shape_of(variant.method.sampling);
}

bool is_dashed(const Variant& variant) {
  return !variant.tolerance && variant.method.sampling == Sampling::cells;
}

/// Errors within this fraction count as equal on the Pareto front.
constexpr double front_margin = 0.01;

using Abscissa = std::function<Spread(const StudyPoint&)>;

/// The points whose abscissa is above 0.
std::vector<const StudyPoint*> points_at(const StudyResults& results, const Abscissa& x) {
  std::vector<const StudyPoint*> points;
  for (const StudyPoint& point : results.points)
    if (x(point).median > 0) points.push_back(&point);
  return points;
}

Plot plot_of(std::vector<const StudyPoint*> points, const std::string& title,
             const std::string& x_label, const Abscissa& x) {
  std::ranges::stable_sort(points, [](const StudyPoint* a, const StudyPoint* b) {
    return is_coarser(a->variant, b->variant);
  });
  std::vector<PlotCurve> curves;
  for (const StudyCurve& curve : curves_of(points)) {
    curves.push_back({curve.front()->variant, {}});
    for (const StudyPoint* point : curve) {
      const Spread at = x(*point);
      curves.back().points.push_back(
          {at.median, point->rms(), variant_name(point->variant), at.lower, at.upper});
    }
  }
  Plot plot = plot_of_curves(curves);
  plot.title = title;
  plot.x_label = x_label;
  plot.y_label = "RMS over R G B A against the reference";
  return plot;
}

void mark_front(Plot& plot, const std::vector<const StudyPoint*>& points, const Abscissa& x) {
  constexpr Ink red{200, 0, 0};
  constexpr const char* text = "Pareto front";
  std::vector<PlotPoint> costs;
  for (const StudyPoint* point : points)
    costs.push_back({x(*point).median, point->rms(), variant_name(point->variant)});
  plot.series.push_back(
      {pareto_front(costs, front_margin), red, Shape::ring, true, {text}, /*front=*/true});
  plot.legend.push_back({.text = text, .ink = red, .shape = Shape::ring, .radius = front_radius});
}

/// Other renderers, where their times are known: a curve for each.
void add_foreign(Plot& plot, const StudyResults& results) {
  constexpr Ink foreign_inks[] = {{0, 110, 110}, {150, 75, 0}, {90, 0, 160}, {90, 90, 90}};
  std::size_t renderers = 0;
  for (const ForeignPoint& point : results.foreign) {
    if (point.picture.time_ms <= 0) continue;
    const std::string entry = renderer_name(point) + " (foreign, time as given)";
    auto series = std::ranges::find(plot.series, std::vector{entry}, &Series::entries);
    if (series == plot.series.end()) {
      const Ink ink = foreign_inks[renderers++ % std::size(foreign_inks)];
      series = plot.series.insert(series, {{}, ink, Shape::triangle, false, {entry}});
      plot.legend.push_back({entry, ink, Shape::triangle, true});
    }
    series->points.push_back({point.picture.time_ms, point.rms(), shown_name(point)});
  }
}

/// Median over the points of the distance between a clock's quartiles, relative to its median.
double scatter(const StudyResults& results, double TimeSample::*clock) {
  std::vector<double> all;
  for (const StudyPoint& point : results.points)
    if (const Spread s = spread(point, clock); s.median > 0)
      all.push_back((s.upper - s.lower) / s.median);
  return spread_of(all).median;
}

}  // namespace

Html write_plot(const Plot& plot, const std::filesystem::path& folder) {
  const std::string svg = svg_of(plot), file = plot.name + ".svg";
  write_text((folder / file).string(), svg);
  return Html("<section class=\"plot\" id=\"") + plot.name + "\"><header><h3>" + plot.title +
         "</h3><a href=\"" + file + "\">SVG</a></header>\n" + Html::of_markup(svg) +
         html_json("", json_of(plot)) + "</section>\n";
}

Html html_facts(const std::map<std::string, Facts>& facts) {
  return html_json(" id=\"facts\"", facts);
}

Ink ink_of(Integrator rule) { return inks[std::size_t(rule) % std::size(inks)]; }

Plot plot_of_curves(const std::vector<PlotCurve>& curves) {
  constexpr Ink ink{60, 60, 60};
  const std::pair<Sampling, const char*> samplings[] = {{Sampling::uniform, "uniform"},
                                                        {Sampling::cells, "cells"},
                                                        {Sampling::template_, "template"}};
  Plot plot;
  const auto add_entry = [&](const LegendEntry& entry) {
    if (!std::ranges::count(plot.legend, entry.text, &LegendEntry::text))
      plot.legend.push_back(entry);
  };
  for (const PlotCurve& curve : curves) {
    const Variant& v = curve.variant;
    add_entry({rule_name(v), ink_of(v), v.tolerance ? shape_of(v) : Shape::disc});
    plot.series.push_back({curve.points, ink_of(v), shape_of(v), is_dashed(v), {rule_name(v)}});
  }
  for (const auto& [sampling, name] : samplings)
    for (std::size_t i = 0; i < curves.size(); ++i) {
      const Variant& v = curves[i].variant;
      if (v.tolerance || v.method.sampling != sampling) continue;
      add_entry({name, ink, shape_of(v), true, is_dashed(v)});
      plot.series[i].entries.emplace_back(name);
    }
  return plot;
}

std::string clock_note(const StudyResults& results) {
  // 5 % is less than a mark is wide
  constexpr double visible = 0.05, more = 2;
  const double wall = scatter(results, &TimeSample::wall_ms);
  const double processor = scatter(results, &TimeSample::cpu_ms);
  if (!is_software(results.renderer) || wall < visible || wall < more * processor) return "";
  return "The machine did other work: between repeats, wall times scatter by " +
         percent_text(wall) + " and processor times by " + percent_text(processor) +
         " (the distance of the quartiles over the median; half of the points have more). The "
         "draws are the processor's, so only its time is plotted.";
}

std::vector<Plot> plots_of(const StudyResults& results) {
  std::vector<Plot> plots;
  const auto add = [&](const char* name, const char* title, const char* x_label, const Abscissa& x,
                       bool front, bool time = false) {
    const auto points = points_at(results, x);
    if (points.empty()) return;
    Plot plot = plot_of(points, title, x_label, x);
    if (time) add_foreign(plot, results);
    if (front) mark_front(plot, points, x);
    plot.name = name;
    plots.push_back(std::move(plot));
  };
  const auto step = [](const StudyPoint& p) { return Spread{p.variant.method.step}; };
  const auto look_ups = [](const StudyPoint& p) { return Spread{p.samples_per_ray}; };
  add("error-step", "Error by step", "uniform step [voxels]", step, false);
  add("error-samples", "Error by look-ups", "field look-ups per ray", look_ups, true);
  if (clock_note(results).empty())
    add("error-time", "Error by the GPU's time",
        "time of the draws by the GPU's timer [ms], median and quartiles", gpu_ms, true, true);
  add("error-cpu", "Error by processor time",
      "processor time of the march [ms], median and quartiles", cpu_ms, true, true);
  return plots;
}

}  // namespace psivox
