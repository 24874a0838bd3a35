// Compares what several studies need to reach an RMS.

#include <algorithm>
#include <cmath>

#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "study/csv_line.h"
#include "study/html.h"
#include "study/needs.h"
#include "study/results_table.h"
#include "study/study_plots.h"

namespace psivox {
namespace {

/// Thirds of a decade, for the plots.
std::vector<double> plot_rms() {
  std::vector<double> all;
  for (int i = 0; i <= 9; ++i) all.push_back(std::pow(10, -2 - i / 3.0));
  return all;
}

struct NamedStudy {
  std::string name;  ///< of its folder
  StudyResults results;
};

std::vector<NamedStudy> read_studies(const std::vector<std::filesystem::path>& folders) {
  std::vector<NamedStudy> studies;
  for (const auto& folder : folders) {
    const std::string path = (folder / "results.json").string();
    const auto place = folder.has_filename() ? folder : folder.parent_path();
    studies.push_back(
        {place.filename().string(), results_from_json(read_text(path, "study"), path)});
  }
  return studies;
}

/// The refinements of all studies, in the order of first appearance.
std::vector<Variant> refinements_of(const std::vector<NamedStudy>& studies) {
  std::vector<Variant> all;
  for (const NamedStudy& study : studies)
    for (const Need& need : needs_of(study.results, {1}))
      if (std::find(all.begin(), all.end(), need.variant) == all.end()) all.push_back(need.variant);
  return all;
}

/// The needs of a refinement in a study, in the order of `rms`; empty if the study does not have
/// it.
std::vector<Need> needs_in(const NamedStudy& study, const Variant& refinement,
                           const std::vector<double>& rms) {
  std::vector<Need> own;
  for (const Need& need : needs_of(study.results, rms))
    if (need.variant == refinement) own.push_back(need);
  return own;
}

using Amount = std::optional<double> Need::*;

struct SummaryCost {
  const char* name;
  const char* title;
  const char* axis;
  Amount amount;
  int decimals;
};
constexpr SummaryCost summary_costs[] = {
    {"needs-samples", "Field look-ups per ray", "field look-ups per ray, geometric mean",
     &Need::samples_per_ray, 0},
    {"needs-cpu", "Processor time over that of midpoint, uniform, at RMS 1e-3",
     "processor time over that of midpoint, uniform, at RMS 1e-3, geometric mean", &Need::cpu_ms,
     2}};

/// The divisor of a study's numbers, so that pictures and machines of different speed can be
/// compared: 1 for look-ups, midpoint's time at 1e-3 for times.
double unit_of(const NamedStudy& study, const SummaryCost& cost) {
  if (cost.amount == &Need::samples_per_ray) return 1;
  for (const Need& need : needs_of(study.results, {1e-3}))
    if (need.variant.method.integrator == Integrator::midpoint &&
        need.variant.method.sampling == Sampling::uniform && need.cpu_ms)
      return *need.cpu_ms;
  return 0;
}

std::string amount_text(const Need& need, const SummaryCost& cost, double unit) {
  // The time is 0 at a point that has not been timed.
  if (!(need.*cost.amount) || *(need.*cost.amount) <= 0 || unit <= 0) return "–";
  return (need.at_most ? "≤" : "") + decimals(*(need.*cost.amount) / unit, cost.decimals);
}

TextTable summary_table(const std::vector<NamedStudy>& studies, const SummaryCost& cost) {
  TextTable rows = {{"rule, sampling"}};
  for (const NamedStudy& study : studies) rows[0].push_back(study.name);
  for (const Variant& refinement : refinements_of(studies)) {
    rows.push_back({variant_name(refinement)});
    for (const NamedStudy& study : studies) {
      std::string text;
      for (const Need& need : needs_in(study, refinement, usual_rms))
        text += (text.empty() ? "" : " / ") + amount_text(need, cost, unit_of(study, cost));
      rows.back().push_back(text.empty() ? "–" : text);
    }
  }
  return rows;
}

/// Geometric means over the studies, at every RMS that all of them reach.
NamedPlot summary_plot(const std::vector<NamedStudy>& studies, const SummaryCost& cost) {
  const std::vector<double> rms = plot_rms();
  std::vector<PlotCurve> curves;
  for (const Variant& refinement : refinements_of(studies)) {
    std::vector<double> logs(rms.size(), 0);
    for (const NamedStudy& study : studies) {
      const std::vector<Need> needs = needs_in(study, refinement, rms);
      const double unit = unit_of(study, cost);
      for (std::size_t i = 0; i < rms.size(); ++i)
        logs[i] += i < needs.size() && needs[i].*cost.amount && unit > 0
                       ? std::log(*(needs[i].*cost.amount) / unit) / double(studies.size())
                       : HUGE_VAL;
    }
    PlotCurve curve{refinement, {}};
    for (std::size_t i = 0; i < rms.size(); ++i)
      if (std::isfinite(logs[i]))
        curve.points.push_back({std::exp(logs[i]), rms[i], variant_name(refinement)});
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  NamedPlot named{cost.name, plot_of_curves(curves)};
  named.plot.title =
      "What an RMS takes: geometric mean of " + std::to_string(studies.size()) + " studies";
  named.plot.x_label = cost.axis;
  named.plot.y_label = "RMS over R G B A against the reference";
  return named;
}

std::string summary_csv(const std::vector<NamedStudy>& studies) {
  std::string out = "study,variant,rms,samples_per_ray,cpu_ms,at_most\n";
  for (const NamedStudy& study : studies)
    for (const Need& need : needs_of(study.results, usual_rms)) {
      const auto text = [](const std::optional<double>& n) {
        return n ? number_text(*n) : std::string();
      };
      out += study.name + "," + variant_name(need.variant) + "," + number_text(need.rms) + "," +
             text(need.samples_per_ray) + "," + text(need.cpu_ms) + "," +
             (need.at_most ? "1" : "0") + "\n";
    }
  return out;
}

}  // namespace

void run_summary(const std::vector<std::filesystem::path>& folders,
                 const std::filesystem::path& out) {
  const std::vector<NamedStudy> studies = read_studies(folders);
  check_study_folder(out, false);
  const std::string note =
      "The numbers are for an RMS of 1e-2 / 1e-3 / 1e-4 / 1e-5, interpolated between measured "
      "points linearly in the logarithms. ≤: the coarsest point already reaches the RMS; –: no "
      "point reaches it.";
  std::string markdown = note + "\n", body = "<p>" + note + "</p>\n";
  for (const SummaryCost& cost : summary_costs) {
    const TextTable table = summary_table(studies, cost);
    markdown += "\n**" + std::string(cost.title) + "**\n\n" + markdown_table(table);
    body += "<h2>" + std::string(cost.title) + "</h2>\n" +
            write_plot(summary_plot(studies, cost), out) + html_table(table);
  }
  write_text((out / "needs.csv").string(), summary_csv(studies));
  write_text((out / "needs.md").string(), markdown);
  write_text((out / "index.html").string(), html_page("psivox study --summary", body));
}

}  // namespace psivox
