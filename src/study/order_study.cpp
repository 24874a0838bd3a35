// Observed orders of convergence as tables, plots and a page.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/study.h"
#include "study/page.h"
#include "study/suite.h"

namespace psivox {
namespace {

struct Refinement {
  Refined refined;
  const char* name;
  const char* axis;
  const char* measured;
};
constexpr Refinement refinements[] = {
    {Refined::step, "step", "step [widths of the medium]",
     "One ray passes through tau = K e^(-s^2), L = 1 + 0.6 sin(1.3 s + 0.4), without voxels; the "
     "width of the medium is s = 1. The error is the radiance less the exact integral, RMS over 8 "
     "phases of the lattice. A ray from inside begins at s = -0.6 and ends at s = 0.9."},
    {Refined::voxel, "voxel", "voxel [widths of the medium]",
     "Voxels sample the same medium around a point, tau = K e^(-p^2), and 24x24 rays cross it. The "
     "error is the radiance less the exact integral of the medium itself, RMS over the pixels. "
     "Only the interpolation between voxels adds to it."},
    {Refined::pixel, "pixel", "pixel [widths of the picture]",
     "Voxels hold this medium exactly, so the pixels are exact. The error is that of the picture "
     "between pixels, nearest or bilinear, RMS over 4x4 points per pixel; and the mean of the "
     "pixels less the mean of the exact picture."}};

const Refinement& of(const OrderRow& row) { return refinements[int(row.refined)]; }

TextTable order_table(const std::vector<OrderRow>& rows) {
  TextTable table = {{"shrinks", "rays", "way", "K", "expected", "observed", "errors fitted"}};
  for (const OrderRow& row : rows) {
    const auto fitted = row.fitted();
    table.push_back(
        {of(row).name, row.rays, row.way, number_text(row.K),
         (row.about ? "≈ " : "") + number_text(row.expected), decimals(row.observed(), 2),
         two_digits(fitted.front().second) + " to " + two_digits(fitted.back().second) + " at " +
             two_digits(fitted.front().first) + " to " + two_digits(fitted.back().first)});
  }
  return table;
}

Json json_of(const OrderRow& row) {
  Json json = {{"shrinks", of(row).name},
               {"rays", row.rays},
               {"way", row.way},
               {"K", row.K},
               {"expected", row.expected},
               {"expected_about", row.about},
               {"observed", row.observed()},
               {"floor", row.floor}};
  for (const auto& [length, rms] : row.errors)
    json["errors"].push_back({{"length", length}, {"rms", rms}});
  return json;
}

std::string order_csv(const std::vector<OrderRow>& rows) {
  std::vector<Json> lines;
  for (const OrderRow& row : rows) {
    const auto fitted = row.fitted();
    std::string way = row.way;
    std::ranges::replace(way, ',', ';');
    Json line = json_of(row);
    line["way"] = way;
    for (const LengthError& error : row.errors) {
      line["length"] = error.first;
      line["rms"] = error.second;
      line["fitted"] = std::ranges::count(fitted, error);
      lines.push_back(line);
    }
  }
  return csv_text(lines, "shrinks,rays,way,K,length,rms,fitted,expected,observed");
}

std::string order_json(const std::vector<OrderRow>& rows) {
  Json out = {{"psivox_orders", 1}, {"version", PSIVOX_VERSION}, {"git", git_hash()}};
  for (const OrderRow& row : rows) out["orders"].push_back(json_of(row));
  return out.dump(1) + "\n";
}

/// A dashed line for each expected order, above the largest error of the rows that expect it.
void add_guides(Plot& plot, const std::vector<const OrderRow*>& rows) {
  constexpr Ink guide{150, 150, 150};
  for (const double order : {1.0, 2.0, 4.0}) {
    LengthError top{0, 0};
    double finest = HUGE_VAL, least = HUGE_VAL;
    for (const OrderRow* row : rows)
      for (const LengthError& error : row->errors) {
        finest = std::min(finest, error.first);
        if (error.second > row->floor) least = std::min(least, error.second);
        if (row->expected == order && error.second > top.second) top = error;
      }
    if (top.second == 0) continue;
    const double shortest = std::max(finest, top.first * std::pow(least / top.second, 1 / order));
    const double end = top.second * std::pow(shortest / top.first, order);
    const std::string text = "order " + number_text(order);
    plot.series.push_back(
        {{{top.first, 1.5 * top.second}, {shortest, 1.5 * end}}, guide, Shape::ring, true, {text}});
    plot.legend.push_back({text, guide, Shape::ring, true, true});
  }
}

Plot order_plot(const std::string& name, const std::string& title,
                const std::vector<const OrderRow*>& rows) {
  Plot plot;
  plot.name = name;
  plot.title = title;
  plot.x_label = of(*rows.front()).axis;
  plot.y_label = "RMS error of the radiance";
  add_guides(plot, rows);
  constexpr Shape shapes[] = {Shape::disc, Shape::square, Shape::diamond};
  std::size_t i = 0;
  for (const OrderRow* row : rows) {
    const bool steps = row->refined == Refined::step;
    const bool corrected = steps && row->way.find(',') != std::string::npos;
    // Colours tell rules apart, or methods if the rows share a rule.
    const Ink ink = steps ? ink_of(row->rule) : ink_of(Integrator(i));
    const Shape shape = steps ? shapes[corrected ? 2 : 0] : shapes[i % 3];
    const std::string text = row->way + ": " + decimals(row->observed(), 2);
    plot.series.push_back({{}, ink, shape, corrected, {text}});
    for (const auto& [length, rms] : row->errors)
      if (rms > row->floor) plot.series.back().points.push_back({length, rms, row->way});
    plot.legend.push_back({text, ink, shape, true, corrected});
    ++i;
  }
  return plot;
}

std::vector<Plot> order_plots(const std::vector<OrderRow>& rows) {
  std::vector<Plot> plots;
  for (const Refinement& refinement : refinements)
    for (const char* rays : {"vacuum to vacuum", "from inside"}) {
      std::vector<const OrderRow*> chosen;
      for (const OrderRow& row : rows)
        if (row.refined == refinement.refined && row.rays == rays &&
            (row.refined != Refined::step || row.K == 3))
          chosen.push_back(&row);
      if (chosen.empty()) continue;
      const std::string where = std::string(rays) == "from inside" ? "-inside" : "";
      plots.push_back(order_plot("order-" + std::string(refinement.name) + where,
                                 "Error by " + std::string(refinement.name) + ", rays " + rays +
                                     ", K " + number_text(chosen.front()->K) +
                                     "; the legend has the observed orders",
                                 chosen));
    }
  return plots;
}

}  // namespace

void run_order_study(const std::filesystem::path& folder, const Progress& progress) {
  const WrittenFolder written = study_folder(folder, false);
  const auto part = [&](double from, double to) -> Progress {
    if (!progress) return {};
    return [=](double fraction) { progress(from + (to - from) * fraction); };
  };
  std::vector<OrderRow> rows = step_orders(part(0, 0.5));
  std::ranges::move(voxel_orders(part(0.5, 0.95)), std::back_inserter(rows));
  std::ranges::move(pixel_orders(part(0.95, 1)), std::back_inserter(rows));
  write_text((folder / "orders.csv").string(), order_csv(rows));
  write_text((folder / "orders.json").string(), order_json(rows));
  Html html;
  for (const Refinement& refinement : refinements)
    html += Html("<p><b>") + std::string(refinement.name) +
            "</b>: " + std::string(refinement.measured) + "</p>\n";
  for (const Plot& plot : order_plots(rows)) html += write_plot(plot, folder);
  write_sections(
      folder, "orders", "psivox study --orders",
      {{.text = "One length shrinks at a time. An order is the slope of the error over the length "
                "in logarithms, by least squares over the finest four lengths whose error is above "
                "rounding. ≈ marks rules that approximate Ψ: the error of the approximation does "
                "not fall with the step.",
        .table = order_table(rows),
        .html = html}});
}

}  // namespace psivox
