#include "study/report.h"

#include <algorithm>

#include "psivox/parameters.h"
#include "psivox/text_file.h"
#include "study/html.h"
#include "study/number_format.h"
#include "study/results_table.h"
#include "study/study_plots.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;
constexpr int thumbnail_width = 256;

std::string head(const StudyResults& r) {
  const std::string version = r.version + (r.git.empty() ? "" : " (" + r.git + ")");
  return html_table({{"study", ""},
                     {"file", escaped(r.input) + ", FNV-1a " + r.input_hash},
                     {"psivox", escaped(version)},
                     {"GL", escaped(r.renderer)},
                     {"machine", escaped(r.processor) + ", " + std::to_string(r.threads) +
                                     " threads, " + escaped(r.system)},
                     {"reference", "adaptive quadrature in double; its error is at most " +
                                       two_digits(r.reference_bound) + " at any pixel"},
                     {"points", std::to_string(r.points.size()) + ", each timed " +
                                    std::to_string(r.repeats) + " times"}},
                    Cells::words);
}

std::string spread_text(const Spread& s) {
  if (s.max <= 0) return "–";
  return decimals(s.median, 1) + " (" + decimals(s.min, 1) + "–" + decimals(s.max, 1) + ")";
}

std::string max_text(const Deviation& d) {
  return two_digits(d.max) + " at " + std::to_string(d.max_x) + "," + std::to_string(d.max_y);
}

std::string points_table(const StudyResults& results) {
  std::vector<std::vector<std::string>> rows = {
      {"variant", "RMS", "radiance RMS", "max, pixel", "99 %", "mean", "alpha RMS", "max, pixel",
       "99 %", "mean", "step error RMS", "arithmetic RMS", "look-ups a ray", "segments a ray",
       "GPU ms", "wall ms", "CPU ms", "atlas MiB"}};
  const auto rms = [](const std::optional<PictureError>& error) {
    return error ? two_digits(error->rms()) : "–";
  };
  for (const StudyPoint& p : results.points) {
    const std::string chosen = p.chosen ? ": " + variant_name(*p.chosen) : "";
    std::vector<std::string> row = {variant_name(p.variant) + chosen, two_digits(p.error.rms())};
    for (const Deviation* d : {&p.error.radiance, &p.error.alpha})
      row.insert(row.end(),
                 {two_digits(d->rms), max_text(*d), two_digits(d->p99), two_digits(d->mean)});
    row.insert(row.end(),
               {rms(p.step_error), rms(p.arithmetic), decimals(p.samples_per_ray, 1),
                decimals(p.steps_per_ray, 1), spread_text(gpu_ms(p)), spread_text(wall_ms(p)),
                spread_text(cpu_ms(p)), decimals(double(p.atlas_bytes) / (1 << 20), 2)});
    rows.push_back(std::move(row));
  }
  return html_table(rows);
}

/// Rules by samplings.
std::string rms_table(const StudyResults& results) {
  std::vector<std::vector<std::string>> rows = {{"RMS"}};
  for (const StudyPoint& p : results.points) {
    const auto place = [](std::vector<std::string>& in, const std::string& name) {
      const auto at = std::find(in.begin(), in.end(), name) - in.begin();
      if (at == std::ptrdiff_t(in.size())) in.push_back(name);
      return std::size_t(at);
    };
    const std::size_t column = place(rows[0], sampling_name(p.variant));
    const std::string rule = rule_name(p.variant);
    auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r[0] == rule; });
    if (row == rows.end()) row = rows.insert(row, {rule});
    if (row->size() <= column) row->resize(column + 1);
    (*row)[column] = two_digits(p.error.rms());
  }
  for (auto& row : rows) row.resize(rows[0].size());
  return html_table(rows);
}

std::string gallery(const StudyResults& results, const fs::path& folder) {
  std::string out =
      "<p>Of each: the picture, and its difference from the reference, blue below and red above "
      "it; full colour is the number beside it.</p>\n<div class=\"gallery\">\n";
  for (const StudyPoint& p : results.points) {
    const std::string name = variant_name(p.variant), file = file_name(p.variant) + ".png";
    out += html_figure(folder / pictures_folder / file, name, thumbnail_width);
    out += html_figure(folder / differences_folder / file,
                       name + ": ±" + two_digits(p.difference_scale), thumbnail_width);
  }
  return out + "</div>\n";
}

/// One a resolution.
std::string references(const StudyResults& results, const fs::path& folder) {
  std::vector<std::string> names;
  std::string out;
  for (const StudyPoint& p : results.points) {
    const std::string name = reference_name(p.variant);
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    names.push_back(name);
    out += html_figure(folder / (name + ".png"), "the reference", 2 * thumbnail_width);
  }
  return out;
}

}  // namespace

std::string reference_name(const Variant& variant) {
  if (variant.resolution.x == 0) return "reference";
  return "reference_" + parameter_text(scene_of(variant, {}), *find_parameter("resolution"));
}

void write_report(const StudyResults& results, const fs::path& folder) {
  write_text((folder / "results.md").string(), results_markdown(results));
  std::string body = head(results);
  body += references(results, folder);
  body +=
      "<h2>Plots</h2>\n<p>Error is the RMS over R G B A of the GPU's picture less the "
      "reference, in linear radiance.</p>\n";
  for (const NamedPlot& named : plots_of(results)) body += write_plot(named, folder);
  body += "<h2>Rules by samplings</h2>\n" + rms_table(results);
  body +=
      "<h2>What an error takes</h2>\n<p>Field look-ups a ray and processor time of the march for "
      "an "
      "RMS, between measured points straight in the logarithms; –: no point gets there.</p>\n" +
      html_table(needs_table(results));
  body +=
      "<h2>All numbers</h2>\n<p>Times are medians, with the least and the greatest. Step error: "
      "march in double less reference; arithmetic error: GPU less march in double.</p>\n" +
      points_table(results);
  if (!results.skipped.empty()) {
    std::vector<std::vector<std::string>> rows = {{"left out", "why"}};
    for (const auto& [variants, reason] : skipped_lines(results.skipped))
      rows.push_back({variants, escaped(reason)});
    body += "<h2>Left out</h2>\n" + html_table(rows, Cells::words);
  }
  body += "<h2>Pictures</h2>\n" + gallery(results, folder);
  body += "<h2>Scene</h2>\n<pre>" + escaped(results.scene) + "</pre>\n";
  write_text((folder / "index.html").string(), html_page("psivox study", body));
}

}  // namespace psivox
