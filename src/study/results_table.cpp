// A study's numbers: errors of pictures, CSV and tables.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "study/page.h"
#include "study/report.h"

namespace psivox {
namespace {

/// The deviation of a - b in the channels from `first` to `last` - 1.
Deviation deviation(const Image& a, const Image& b, std::size_t first, std::size_t last) {
  ErrorSum sum;
  std::vector<double> absolute;
  std::uint64_t not_finite = 0;
  const std::size_t pixels = a.rgba().size() / 4, width = std::size_t(a.width);
  absolute.reserve(pixels * (last - first));
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = first; c < last; ++c) {
      const double value = double(a.rgba()[4 * i + c]) - double(b.rgba()[4 * i + c]);
      if (!std::isfinite(value)) {
        ++not_finite;
        continue;
      }
      sum.add(value, i);
      absolute.push_back(std::abs(value));
    }
  return {.rms = sum.rms(),
          .max = sum.max,
          .max_x = int(sum.max_at % width),
          .max_y = int(sum.max_at / width),
          .p99 = percentile(std::move(absolute), 0.99),
          .mean = sum.mean(),
          .not_finite = not_finite};
}

void add(CsvRow& row, const std::string& prefix, const Deviation& d) {
  const std::pair<const char*, double> numbers[] = {
      {"rms", d.rms}, {"max", d.max},   {"max_x", d.max_x},          {"max_y", d.max_y},
      {"p99", d.p99}, {"mean", d.mean}, {"not_finite", d.not_finite}};
  for (const auto& [name, number] : numbers) row.emplace_back(prefix + name, number);
}

void add_short(CsvRow& row, const std::string& prefix, const std::optional<PictureError>& error) {
  for (const auto& [channels, deviation] :
       {std::pair("radiance_", &PictureError::radiance), std::pair("alpha_", &PictureError::alpha)})
    for (const auto& [name, number] :
         {std::pair("rms", &Deviation::rms), std::pair("max", &Deviation::max)})
      row.emplace_back(prefix + channels + name,
                       error ? CsvCell((*error).*deviation.*number) : CsvCell(""));
}

/// A row of results.csv.
CsvRow cells_of(const StudyPoint& point, const Scene& base) {
  const Variant marched = point.chosen.value_or(point.variant);
  const Scene scene = scene_of(marched, base);
  const auto text = [&](const char* name) { return parameter_text(scene, name); };
  CsvRow row = {{"renderer", "psivox"},
                {"integrator", text("integrator")},
                {"sampling", text("sampling")},
                {"segments", marched.method.segments},
                {"step", marched.method.step},
                {"filter", text("filter")},
                {"texel", text("texel")},
                {"resolution", text("resolution")},
                {"tolerance", point.variant.tolerance.value_or(0)},
                {"estimate", point.estimate},
                {"rms", point.error.rms()}};
  add(row, "radiance_", point.error.radiance);
  add(row, "alpha_", point.error.alpha);
  add_short(row, "step_error_", point.step_error);
  add_short(row, "arithmetic_error_", point.arithmetic);
  row.insert(row.end(), {{"samples_per_ray", point.samples_per_ray},
                         {"steps_per_ray", point.steps_per_ray},
                         {"atlas_bytes", double(point.atlas_bytes)},
                         {"repeats", double(point.times.size())}});
  for (const auto& [clock, spread] :
       {std::pair("gpu_ms_", gpu_ms(point)), std::pair("wall_ms_", wall_ms(point)),
        std::pair("cpu_ms_", cpu_ms(point))})
    for (const auto& [name, number] :
         {std::pair("median", spread.median), std::pair("lower", spread.lower),
          std::pair("upper", spread.upper), std::pair("min", spread.min),
          std::pair("max", spread.max)})
      row.emplace_back(std::string(clock) + name, number);
  return row;
}

/// What is known of another renderer.
CsvRow cells_of(const ForeignPoint& point) {
  CsvRow row = {{"renderer", point.picture.name},
                {"resolution", formatted("%dx%d", point.resolution.x, point.resolution.y)},
                {"rms", point.rms()}};
  add(row, "radiance_", point.error.radiance);
  if (!point.opaque) add(row, "alpha_", point.error.alpha);
  if (point.picture.time_ms > 0) row.emplace_back("wall_ms_median", point.picture.time_ms);
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

double PictureError::rms() const {
  return std::sqrt((3 * radiance.rms * radiance.rms + alpha.rms * alpha.rms) / 4);
}

PictureError picture_error(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error(ExitCode::input, "pictures of different sizes cannot be compared");
  return {deviation(a, b, 0, 3), deviation(a, b, 3, 4)};
}

double rounding_rms(const Image& image) {
  ErrorSum sum;
  for (const float value : image.rgba())
    if (std::isfinite(value)) sum.add(value, 0);
  return 8.0 * std::numeric_limits<float>::epsilon() * sum.rms();
}

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
  std::vector<CsvRow> rows;
  for (const StudyPoint& point : results.points) rows.push_back(cells_of(point, base));
  for (const ForeignPoint& point : results.foreign) rows.push_back(cells_of(point));
  return csv_text(rows, cells_of(StudyPoint(), base));
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

TextTable skipped_table(const StudyResults& results) {
  TextTable rows = {{"skipped", "why"}};
  for (const auto& [variants, reason] : skipped_lines(results.skipped))
    rows.push_back({variants, html_text(reason)});
  return rows;
}

}  // namespace psivox
