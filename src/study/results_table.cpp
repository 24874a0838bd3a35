// A study's numbers as CSV and as Markdown.

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "psivox/parameters.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/report.h"
#include "study/study_plots.h"

namespace psivox {
namespace {

void add_header(CsvLine& line, const std::string& prefix) {
  for (const char* channels : {"radiance", "alpha"})
    for (const char* number : {"rms", "max", "max_x", "max_y", "p99", "mean", "not_finite"})
      line << prefix + channels + "_" + number;
}

void add(CsvLine& line, const Deviation& d) {
  line << d.rms << d.max << d.max_x << d.max_y << d.p99 << d.mean << double(d.not_finite);
}

void add_short(CsvLine& line, const std::optional<PictureError>& error) {
  for (const Deviation PictureError::*part : {&PictureError::radiance, &PictureError::alpha})
    for (const double Deviation::*number : {&Deviation::rms, &Deviation::max})
      line << (error ? number_text((*error).*part.*number) : std::string());
}

/// Cells of what is not known of another renderer are empty.
std::string csv_line(const ForeignPoint& point) {
  const auto [x, y] = std::pair(point.resolution.x, point.resolution.y);
  CsvLine line;
  const auto leave = [&](int cells) {
    for (int i = 0; i < cells; ++i) line << "";
  };
  line << point.picture.name;
  leave(6);
  line << std::to_string(x) + "x" + std::to_string(y);
  leave(2);
  line << point.rms();
  add(line, point.error.radiance);
  if (point.opaque)
    leave(7);
  else
    add(line, point.error.alpha);
  leave(8 + 3 + 1 + 5);
  line << (point.picture.time_ms > 0 ? number_text(point.picture.time_ms) : "");
  leave(4 + 5);
  return line.str();
}

/// Distinct names in the order of first appearance.
template <typename Name>
std::vector<std::string> names(const StudyResults& results, Name name) {
  std::vector<std::string> out;
  for (const StudyPoint& point : results.points)
    if (std::find(out.begin(), out.end(), name(point.variant)) == out.end())
      out.push_back(name(point.variant));
  return out;
}

const StudyPoint* find(const StudyResults& results, const std::string& rule,
                       const std::string& sampling) {
  for (const StudyPoint& point : results.points)
    if (rule_name(point.variant) == rule && sampling_name(point.variant) == sampling) return &point;
  return nullptr;
}

std::string cell(const StudyPoint* point, const StudyPoint* baseline) {
  if (!point) return "–";
  std::string text = two_digits(point->error.rms());
  const double own = cpu_ms(*point).median;
  const double whole = baseline ? cpu_ms(*baseline).median : 0;
  if (own > 0 && whole > 0) text += " (" + decimals(own / whole, 2) + ")";
  return text;
}

/// "34.1, 12 ms"; upper bounds have "≤" in front.
std::string need_text(const Need& need) {
  if (!need.samples_per_ray) return "–";
  std::string text = (need.at_most ? "≤ " : "") + decimals(*need.samples_per_ray, 1);
  if (*need.cpu_ms > 0) text += ", " + decimals(*need.cpu_ms, 1) + " ms";
  return text;
}

}  // namespace

TextTable needs_table(const StudyResults& results) {
  TextTable rows = {{"rule"}};
  const std::vector<Need> needs = needs_of(results);
  for (const Need& need : needs) {
    const std::string name = variant_name(need.variant);
    if (rows.size() == 1 || rows.back()[0] != name) rows.push_back({name});
    rows.back().push_back(need_text(need));
    if (rows.size() == 2) rows[0].push_back("RMS " + power_text(need.rms));
  }
  return rows;
}

std::string results_csv(const StudyResults& results) {
  CsvLine header;
  for (const char* name : {"renderer", "integrator", "sampling", "segments", "step", "filter",
                           "texel", "resolution", "tolerance", "estimate", "rms"})
    header << std::string(name);
  add_header(header, "");
  for (const char* error : {"step_error_", "arithmetic_error_"})
    for (const char* channels : {"radiance", "alpha"})
      for (const char* number : {"rms", "max"})
        header << std::string(error) + channels + "_" + number;
  header << "samples_per_ray"
         << "steps_per_ray"
         << "atlas_bytes"
         << "repeats";
  for (const char* clock : {"gpu", "wall", "cpu"})
    for (const char* number : {"median", "lower", "upper", "min", "max"})
      header << std::string(clock) + "_ms_" + number;
  std::string out = header.str();
  const Scene base = scene_from_json(results.scene, "the study's scene");
  for (const StudyPoint& point : results.points) {
    const Variant marched = point.chosen.value_or(point.variant);
    const Scene scene = scene_of(marched, base);
    const auto text = [&](const char* name) { return parameter_text(scene, name); };
    CsvLine line;
    line << "psivox" << text("integrator") << text("sampling") << double(marched.method.segments)
         << marched.method.step << text("filter") << text("texel") << text("resolution")
         << point.variant.tolerance.value_or(0) << point.estimate << point.error.rms();
    add(line, point.error.radiance);
    add(line, point.error.alpha);
    add_short(line, point.step_error);
    add_short(line, point.arithmetic);
    line << point.samples_per_ray << point.steps_per_ray << double(point.atlas_bytes)
         << double(point.times.size());
    for (const Spread& spread : {gpu_ms(point), wall_ms(point), cpu_ms(point)})
      line << spread.median << spread.lower << spread.upper << spread.min << spread.max;
    out += line.str();
  }
  for (const ForeignPoint& point : results.foreign) out += csv_line(point);
  return out;
}

TextTable rules_table(const StudyResults& results) {
  TextTable rows = {{"rule"}};
  for (const std::string& column : names(results, sampling_name)) rows[0].push_back(column);
  for (const std::string& rule : names(results, rule_name)) {
    rows.push_back({rule});
    bool measured = false;  // what a tolerance chooses is in no column
    for (std::size_t i = 1; i < rows[0].size(); ++i) {
      const StudyPoint* point = find(results, rule, rows[0][i]);
      measured |= point != nullptr;
      rows.back().push_back(cell(point, find(results, "porter-duff", rows[0][i])));
    }
    if (!measured) rows.pop_back();
  }
  return rows;
}

std::string results_markdown(const StudyResults& results) {
  TextTable rules = rules_table(results);
  for (std::size_t i = 1; i < rules.size(); ++i) rules[i][0] = "`" + rules[i][0] + "`";
  std::string out = conclusion_text(results) + " " + eight_bits_note + "\n\n```sh\n" +
                    command_of(results) + "\n```\n\n" + rules_note + "\n\n" +
                    markdown_table(rules) + "\n" + needs_note + "\n\n" +
                    markdown_table(needs_table(results));
  if (const std::string note = clock_note(results); !note.empty()) out += "\n" + note + "\n";
  if (!results.foreign.empty())
    out += "\n" + std::string(foreign_note) + "\n\n" + markdown_table(foreign_table(results));
  if (results.skipped.empty()) return out;
  out += "\nSkipped:\n\n";
  for (const auto& [variants, reason] : skipped_lines(results.skipped))
    out += "- " + variants + ": " + reason + "\n";
  return out;
}

}  // namespace psivox
