// A study's numbers as CSV and as Markdown.

#include <algorithm>

#include "base/text.h"
#include "psivox/parameters.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/report.h"
#include "study/study_plots.h"

namespace psivox {
namespace {

void add(Facts& row, const std::string& prefix, const Deviation& d) {
  const std::pair<const char*, double> numbers[] = {
      {"rms", d.rms}, {"max", d.max},   {"max_x", d.max_x},          {"max_y", d.max_y},
      {"p99", d.p99}, {"mean", d.mean}, {"not_finite", d.not_finite}};
  for (const auto& [name, number] : numbers) row.emplace_back(prefix + name, number_text(number));
}

void add_short(Facts& row, const std::string& prefix, const std::optional<PictureError>& error) {
  for (const auto& [channels, deviation] :
       {std::pair("radiance_", &PictureError::radiance), std::pair("alpha_", &PictureError::alpha)})
    for (const auto& [name, number] :
         {std::pair("rms", &Deviation::rms), std::pair("max", &Deviation::max)})
      row.emplace_back(prefix + channels + name,
                       error ? number_text((*error).*deviation.*number) : "");
}

/// A row of results.csv.
Facts cells_of(const StudyPoint& point, const Scene& base) {
  const Variant marched = point.chosen.value_or(point.variant);
  const Scene scene = scene_of(marched, base);
  Facts row = {{"renderer", "psivox"}};
  const auto add_texts = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) row.emplace_back(name, parameter_text(scene, name));
  };
  const auto add_number = [&](const std::string& name, double number) {
    row.emplace_back(name, number_text(number));
  };
  add_texts({"integrator", "sampling"});
  add_number("segments", marched.method.segments);
  add_number("step", marched.method.step);
  add_texts({"filter", "texel", "resolution"});
  add_number("tolerance", point.variant.tolerance.value_or(0));
  add_number("estimate", point.estimate);
  add_number("rms", point.error.rms());
  add(row, "radiance_", point.error.radiance);
  add(row, "alpha_", point.error.alpha);
  add_short(row, "step_error_", point.step_error);
  add_short(row, "arithmetic_error_", point.arithmetic);
  add_number("samples_per_ray", point.samples_per_ray);
  add_number("steps_per_ray", point.steps_per_ray);
  add_number("atlas_bytes", double(point.atlas_bytes));
  add_number("repeats", double(point.times.size()));
  for (const auto& [clock, spread] :
       {std::pair("gpu_ms_", gpu_ms(point)), std::pair("wall_ms_", wall_ms(point)),
        std::pair("cpu_ms_", cpu_ms(point))})
    for (const auto& [name, number] :
         {std::pair("median", spread.median), std::pair("lower", spread.lower),
          std::pair("upper", spread.upper), std::pair("min", spread.min),
          std::pair("max", spread.max)})
      add_number(std::string(clock) + name, number);
  return row;
}

/// What is known of another renderer.
Facts cells_of(const ForeignPoint& point) {
  Facts row = {{"renderer", point.picture.name},
               {"resolution", formatted("%dx%d", point.resolution.x, point.resolution.y)},
               {"rms", number_text(point.rms())}};
  add(row, "radiance_", point.error.radiance);
  if (!point.opaque) add(row, "alpha_", point.error.alpha);
  if (point.picture.time_ms > 0)
    row.emplace_back("wall_ms_median", number_text(point.picture.time_ms));
  return row;
}

/// Distinct names in the order of first appearance.
template <typename Name>
std::vector<std::string> names(const StudyResults& results, Name name) {
  std::vector<std::string> out;
  for (const StudyPoint& point : results.points)
    if (!std::ranges::count(out, name(point.variant))) out.push_back(name(point.variant));
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
  const Scene base = scene_from_json(results.scene, "the study's scene");
  const Facts columns = cells_of(StudyPoint(), base);
  CsvLine header;
  for (const auto& [name, text] : columns) header << name;
  std::string out = header.str();
  const auto add = [&](const Facts& row) {
    CsvLine line;
    for (const auto& [name, text] : columns) {
      const auto cell = std::ranges::find(row, name, &Facts::value_type::first);
      line << (cell == row.end() ? "" : cell->second);
    }
    out += line.str();
  };
  for (const StudyPoint& point : results.points) add(cells_of(point, base));
  for (const ForeignPoint& point : results.foreign) add(cells_of(point));
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
