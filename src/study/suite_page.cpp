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
  if (row.about) return "approximates Ψ: not held";
  if (row.expected == 0) return "not held";
  if (!row.is_measured()) return "too few errors above rounding";
  return row.holds() ? "as expected" : "NOT AS EXPECTED";
}

TextTable orders_table(const std::vector<OrderRow>& rows) {
  TextTable table = {{"scene", "rule, sampling", "expected", "measured", "verdict"}};
  for (const OrderRow& row : rows)
    if (row.expected > 0 || row.is_measured())
      table.push_back({row.rays, row.way, row.expected > 0 ? number_text(row.expected) : "none",
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

// --- Moreland's numbers --------------------------------------------------------------------------

struct Spot {
  double a_f, a_b, opacity, psi;
};

/// RMS and largest magnitude of error(spot).
template <typename Error>
ErrorSum over(const std::vector<Spot>& spots, Error error) {
  ErrorSum sum;
  for (const Spot& spot : spots) sum.add(error(spot), 0);
  return sum;
}

TextTable thesis_table() {
  constexpr int n = 400;
  std::vector<Spot> spots;
  double weighted = 0, squares = 0;  // for the parabola's least squares
  for (int i = 0; i < n * n; ++i) {
    const double a_f = (i / n + 0.5) / n, a_b = (i % n + 0.5) / n;
    const LinearOpacity segment{1 - a_f, 1 - a_b};
    spots.push_back({a_f, a_b, 1 - segment.zeta(), segment.psi()});
    const double d2 = (a_b - a_f) * (a_b - a_f);
    weighted += d2 * (spots.back().opacity - 0.5 * (a_f + a_b));
    squares += d2 * d2;
  }
  const auto psi_error = [&](double w) {
    return over(spots, [=](const Spot& s) { return psi_65(s.a_f, s.a_b, w) - s.psi; });
  };
  const auto zeta_error = [&](double bend) {
    return over(spots, [=](const Spot& s) { return opacity_64(s.a_f, s.a_b, bend) - s.opacity; });
  };
  double low = 0.2, high = 0.4;  // thirds: the RMS has one minimum there
  while (high - low > 1e-4) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (psi_error(a).rms() < psi_error(b).rms())
      high = b;
    else
      low = a;
  }
  const auto row = [](const std::string& what, double printed, double fitted, const auto& error) {
    const ErrorSum theirs = error(printed), ours = error(fitted);
    const auto text = [](const ErrorSum& e) {
      return decimals(e.rms(), 4) + ", " + decimals(e.max, 3);
    };
    return std::vector<std::string>{what,
                                    number_text(printed),
                                    decimals(fitted, 4),
                                    decimals(fitted - printed, 4),
                                    text(theirs),
                                    text(ours)};
  };
  return {{"number", "printed", "least squares here", "difference", "RMS, max with the printed one",
           "with ours"},
          row("weight of the back end's opacity in Ψ, eq. 65", 0.27, 0.5 * (low + high), psi_error),
          row("bend of the opacity, eq. 64", 0.108165, weighted / squares, zeta_error)};
}

/// Along the segments whose mean opacity is 1/2.
TextTable cross_section_table() {
  TextTable table = {
      {"α front", "α back", "opacity", "eq. 64", "difference", "Ψ", "eq. 65", "difference"}};
  for (int i = 0; i <= 8; ++i) {
    const double a_b = std::clamp(i / 8.0, 1e-9, 1 - 1e-9), a_f = 1 - a_b;
    const LinearOpacity segment{1 - a_f, 1 - a_b};
    const double opacity = opacity_64(a_f, a_b), psi = psi_65(a_f, a_b);
    table.push_back({decimals(a_f, 3), decimals(a_b, 3), decimals(1 - segment.zeta(), 4),
                     decimals(opacity, 4), decimals(opacity - 1 + segment.zeta(), 4),
                     decimals(segment.psi(), 4), decimals(psi, 4),
                     decimals(psi - segment.psi(), 4)});
  }
  return table;
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

/// Orders on the smooth rays, and then in the scenes.
std::vector<OrderRow> all_orders(const std::vector<SuiteResult>& results,
                                 const std::vector<OrderRow>& rays) {
  std::vector<OrderRow> all = rays;
  for (const SuiteResult& r : results) std::ranges::copy(r.orders, std::back_inserter(all));
  return all;
}

std::vector<Section> sections_of(const std::vector<SuiteResult>& results,
                                 const std::vector<OrderRow>& rays) {
  return {
      {"Rules", "A segment lies between two samples, or is a part of a cell.", rules_table(results),
       Cells::words},
      {"Scenes", "Each with what its truth rests on.", scenes_table(results), Cells::words},
      {"Orders of convergence",
       "The error falls as a power of the step, which theory gives: the expected order. The "
       "measured one is the slope in logarithms over the finest four errors above four times "
       "float32's rounding. Smooth rays have no voxels, and their integral is known to 1e-16; "
       "there is no arithmetic in float32. In voxels the field has kinks at faces of cells, and no "
       "rule between uniform samples keeps more than order 2.",
       orders_table(all_orders(results, rays))},
      {"Marschner and Lobb's signal",
       "As Weiss and Westermann (2021) measure it: PSNR over R G B A with a peak of 1, and the "
       "share of the absolute differences above powers of ten. preintegrated-fast is their 1-D "
       "pre-integration, preintegrated their 2-D one. psivox has neither a trapezoid nor a Simpson "
       "rule within intervals; cell-exact takes their place.",
       rows_table(results, true)},
      {"Moreland's numbers",
       "The thesis fits two numbers to segments of linear opacity. Here they are fitted to 400 x "
       "400 pairs of end opacities by least squares.",
       thesis_table()},
      {"Along a cross-section", "The same approximations where the mean opacity is 1/2.",
       cross_section_table()},
      {"All other pictures", "", rows_table(results, false)}};
}

std::vector<std::string> all_misses(const std::vector<SuiteResult>& results,
                                    const std::vector<OrderRow>& rays) {
  std::vector<std::string> misses;
  for (const OrderRow& row : rays)
    if (!row.holds()) misses.push_back(row.miss());
  for (const SuiteResult& r : results) std::ranges::copy(r.misses(), std::back_inserter(misses));
  return misses;
}

std::string conclusion_of(const std::vector<SuiteResult>& results,
                          const std::vector<OrderRow>& rays, std::size_t misses) {
  std::size_t rows = 0;
  for (const SuiteResult& r : results) rows += r.rows.size();
  const auto orders = std::ranges::count_if(all_orders(results, rays), &OrderRow::is_held);
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

std::string write_suite(const std::vector<SuiteResult>& results, const std::vector<OrderRow>& rays,
                        const std::string& renderer, const std::filesystem::path& folder) {
  const std::vector<std::string> misses = all_misses(results, rays);
  const std::string conclusion = conclusion_of(results, rays, misses.size());
  std::vector<Section> sections = sections_of(results, rays);
  sections.insert(sections.begin(), first_section(conclusion, misses, results, renderer, folder));
  sections.push_back(scenes_section(results, folder));
  write_text((folder / "suite.csv").string(), suite_csv(results));
  write_sections(folder, "suite", "psivox study --suite", sections);
  if (!misses.empty()) throw Error(ExitCode::verification, joined(misses, "; "));
  return conclusion;
}

}  // namespace psivox
