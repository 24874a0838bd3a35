// The precision suite's tables, plots and page.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "study/page.h"
#include "study/suite.h"

namespace psivox {
namespace {

TextTable scenes_table(const std::vector<SuiteResult>& results) {
  TextTable table = {{"scene", "medium", "reference's own bound", "closed form less reference"}};
  for (const SuiteResult& r : results)
    table.push_back({r.scene.name, r.scene.medium, two_digits(r.reference_bound),
                     r.scene.truth ? two_digits(r.truth_error) + " in " +
                                         (r.scene.channel == 3 ? "alpha" : "radiance")
                                   : "none known"});
  return table;
}

TextTable rules_table(const std::vector<SuiteResult>& results) {
  TextTable table = {{"rule", "what it takes a segment as"}};
  std::set<Integrator> drawn;
  for (const SuiteResult& r : results)
    for (const SuiteRow& row : r.rows) drawn.insert(row.point.variant.method.integrator);
  for (const Integrator rule : drawn)
    table.push_back({rule_name({.method = {.integrator = rule}}), info(rule).help});
  return table;
}

std::string verdict(const OrderRow& row) {
  if (row.expected == 0) return "not held";
  if (!row.is_measured()) return "too few errors above rounding";
  return row.holds() ? "as expected" : "NOT AS EXPECTED";
}

TextTable orders_table(const std::vector<OrderRow>& rows) {
  TextTable table = {{"scene", "rule, sampling", "expected", "measured", "verdict"}};
  for (const OrderRow& row : rows)
    if (row.expected > 0 || row.is_measured())
      table.push_back({row.scene, row.way, row.expected > 0 ? number_text(row.expected) : "none",
                       row.is_measured() ? decimals(row.observed(), 2) : "–", verdict(row)});
  return table;
}

/// The pictures of Marschner and Lobb's scenes, or of all others.
TextTable rows_table(const std::vector<SuiteResult>& results, bool marschner_lobb) {
  TextTable table = {{"scene", "rule, sampling", "RMS", "99.9 % below", "largest", "PSNR [dB]",
                      "look-ups a ray", "time [ms]"}};
  for (int bin = 1; bin <= suite_bins; ++bin)
    table[0].push_back("> 1e-" + std::to_string(bin) + " [%]");
  for (const SuiteResult& r : results) {
    if (r.scene.name.starts_with("marschner") != marschner_lobb) continue;
    for (const SuiteRow& row : r.rows) {
      const StudyPoint& p = row.point;
      table.push_back({r.scene.name, variant_name(p.variant), two_digits(p.rms()),
                       two_digits(row.p999), two_digits(row.max), decimals(row.psnr(), 1),
                       decimals(p.samples_per_ray, 1), decimals(cpu_ms(p).median, 1)});
      for (const double above : row.above)
        table.back().push_back(above > 0.01 ? decimals(100 * above, 1) : two_digits(100 * above));
    }
  }
  return table;
}

std::string suite_csv(const std::vector<SuiteResult>& results) {
  std::vector<Json> rows;
  for (const SuiteResult& r : results)
    for (const SuiteRow& row : r.rows) {
      const StudyPoint& p = row.point;
      Json out = {{"scene", r.scene.name},
                  {"rule", rule_name(p.variant)},
                  {"sampling", sampling_name(refinement(p.variant))},
                  {"step", p.variant.method.step},
                  {"segments", p.variant.method.segments},
                  {"rms", p.rms()},
                  {"p999", row.p999},
                  {"max", row.max},
                  {"psnr", row.psnr()},
                  {"rays", row.rays},
                  {"samples_per_ray", p.samples_per_ray},
                  {"steps_per_ray", p.steps_per_ray},
                  {"cpu_ms", cpu_ms(p).median}};
      for (int bin = 1; bin <= suite_bins; ++bin)
        out["above_1e-" + std::to_string(bin)] = row.above[std::size_t(bin - 1)];
      const auto order =
          std::ranges::find(r.orders, variant_name(refinement(p.variant)), &OrderRow::way);
      const bool measured = order != r.orders.end() && order->is_measured();
      out["expected_order"] = measured && order->expected > 0 ? Json(order->expected) : Json();
      out["order"] = measured ? Json(order->observed()) : Json();
      rows.push_back(std::move(out));
    }
  return csv_text(rows);
}

// --- plots ---------------------------------------------------------------------------------------

StudyResults study_of(const SuiteResult& result, bool few_rules) {
  StudyResults study;
  study.name = result.scene.name;
  for (const SuiteRow& row : result.rows) {
    const Method& m = row.point.variant.method;
    const bool few =
        is_cell_rule(m.integrator) ||
        (m.sampling == Sampling::uniform &&
         (m.integrator == Integrator::porter_duff || m.integrator == Integrator::psi_weighted ||
          m.integrator == Integrator::psi_balanced || m.integrator == Integrator::preintegrated));
    if (few || !few_rules) study.points.push_back(row.point);
  }
  return study;
}

/// The rules of the mission: geometric means of the scenes with or without a transfer function.
Plot mission_plot(const std::vector<SuiteResult>& results, bool functions) {
  std::vector<StudyResults> studies;
  for (const SuiteResult& r : results)
    if (bool(r.scene.views.front().medium.transfer) == functions &&
        !r.scene.views.front().medium.gradient)
      studies.push_back(study_of(r, true));
  Plot plot = look_ups_plot(studies);
  plot.name = functions ? "suite-functions" : "suite-values";
  plot.title = std::string(functions ? "Through transfer functions" : "Values that glow") +
               ": geometric mean of " + std::to_string(studies.size()) + " scenes";
  return plot;
}

constexpr char suite_intro[] =
    "<p>A volume renderer integrates light along each pixel's ray: the radiance is ∫ L τ T ds, "
    "where τ is the attenuation, L the luminance of the medium and T the transmittance in front. "
    "Each rule is one way to do that from samples of the volume (look-ups): at uniform steps, or "
    "from voxel face to voxel face in so many segments a cell. In every scene here the truth is "
    "known: the reference integrates the trilinear data in double precision, by another algorithm, "
    "with a bound on its own error at each pixel; where a closed form is known too, it confirms "
    "the reference. Errors are over R, G, B and A of linear radiance, in float32, as drawn by the "
    "GL driver named below. Times are processor times of one march; everything else is the same "
    "on every run.</p>\n";

std::vector<OrderRow> all_orders(const std::vector<SuiteResult>& results) {
  std::vector<OrderRow> all;
  for (const SuiteResult& r : results) std::ranges::copy(r.orders, std::back_inserter(all));
  return all;
}

std::vector<Section> sections_of(const std::vector<SuiteResult>& results) {
  return {
      {"Rules", "A segment lies between two samples, or is a part of a cell.", rules_table(results),
       Cells::words},
      {"Scenes", "Each with what its truth rests on.", scenes_table(results), Cells::words},
      {"Orders of convergence",
       "The error falls as a power of the step, which theory gives: the expected order. The "
       "measured one is the slope in logarithms over the finest four errors above four times "
       "float32's rounding. The field has kinks at faces of cells, and no rule between uniform "
       "samples keeps more than order 2.",
       orders_table(all_orders(results))},
      {"Marschner and Lobb's signal",
       "As Weiss and Westermann (2021) measure it: PSNR over R G B A with a peak of 1, and the "
       "share of the absolute differences above powers of ten. preintegrated-fast is their 1-D "
       "pre-integration, preintegrated their 2-D one. psivox has neither a trapezoid nor a Simpson "
       "rule within intervals; cell-exact takes their place.",
       rows_table(results, true)},
      {"All other pictures", "", rows_table(results, false)}};
}

std::vector<std::string> all_misses(const std::vector<SuiteResult>& results) {
  std::vector<std::string> misses;
  for (const SuiteResult& r : results) std::ranges::copy(r.misses(), std::back_inserter(misses));
  return misses;
}

std::string conclusion_of(const std::vector<SuiteResult>& results, std::size_t misses) {
  std::size_t rows = 0;
  for (const SuiteResult& r : results) rows += r.rows.size();
  const auto orders = std::ranges::count_if(all_orders(results), &OrderRow::is_held);
  return std::to_string(results.size()) + " scenes, " + std::to_string(rows) + " pictures, " +
         std::to_string(orders) + " orders of convergence held: " +
         (misses == 0 ? "all as expected" : std::to_string(misses) + " not as expected") + ".";
}

/// What stands above the tables. Writes the plots.
Section first_section(const std::string& conclusion, const std::vector<std::string>& misses,
                      const std::vector<SuiteResult>& results, const std::string& renderer,
                      const std::filesystem::path& folder) {
  Section first{.html = Html("<p class=\"conclusion\">") + conclusion + "</p>\n",
                .markdown = conclusion + "\n\n"};
  for (const std::string& miss : misses) {
    first.html += Html("<p><b>Not as expected:</b> ") + miss + "</p>\n";
    first.markdown += "- " + miss + "\n\n";
  }
  first.html += Html(suite_intro) + "<p>psivox " + PSIVOX_VERSION + " " + std::string(git_hash()) +
                ", " + renderer + "</p>\n<div class=\"gallery\">\n";
  for (const SuiteResult& r : results)
    first.html += html_figure(folder / (r.scene.name + ".png"), r.scene.name, 160);
  first.html += "</div>\n<h2>Error by look-ups</h2>\n";
  for (const bool functions : {false, true})
    first.html += write_plot(mission_plot(results, functions), folder);
  return first;
}

/// The plots of each scene, which it writes.
Section scenes_section(const std::vector<SuiteResult>& results,
                       const std::filesystem::path& folder) {
  Section scenes{.title = "Each scene"};
  for (const SuiteResult& r : results)
    for (Plot& plot : plots_of(study_of(r, false)))
      if (plot.name == "error-samples") {
        plot.name = plot.title = r.scene.name;
        scenes.html += write_plot(plot, folder);
      }
  return scenes;
}

}  // namespace

std::string write_suite(const std::vector<SuiteResult>& results, const std::string& renderer,
                        const std::filesystem::path& folder) {
  const std::vector<std::string> misses = all_misses(results);
  const std::string conclusion = conclusion_of(results, misses.size());
  std::vector<Section> sections = sections_of(results);
  sections.insert(sections.begin(), first_section(conclusion, misses, results, renderer, folder));
  sections.push_back(scenes_section(results, folder));
  write_text((folder / "suite.csv").string(), suite_csv(results));
  write_sections(folder, "suite", "psivox study --suite", sections);
  if (!misses.empty()) throw Error(ExitCode::verification, joined(misses, "; "));
  return conclusion;
}

}  // namespace psivox
