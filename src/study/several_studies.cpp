#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/parameters.h"
#include "psivox/study.h"
#include "study/page.h"
#include "study/report.h"
#include "study/results.h"

// What several studies need to reach an RMS, and statistics over the frames of a sequence.

namespace psivox {
namespace {

/// Thirds of a decade, for the plots.
std::vector<double> plot_rms() {
  std::vector<double> all;
  for (int i = 0; i <= 9; ++i) all.push_back(std::pow(10, -2 - i / 3.0));
  return all;
}

/// The refinements of all studies, in the order of first appearance.
std::vector<Variant> refinements_of(const std::vector<StudyResults>& studies) {
  std::vector<Variant> all;
  for (const StudyResults& study : studies)
    for (const Need& need : needs_of(study, {1}))
      if (!std::ranges::count(all, need.variant)) all.push_back(need.variant);
  return all;
}

/// The needs of a refinement in a study, in the order of `rms`; empty if the study does not have
/// it.
std::vector<Need> needs_in(const StudyResults& study, const Variant& refinement,
                           const std::vector<double>& rms) {
  std::vector<Need> own = needs_of(study, rms);
  std::erase_if(own, [&](const Need& need) { return need.variant != refinement; });
  return own;
}

}  // namespace

Plot look_ups_plot(const std::vector<StudyResults>& studies) {
  const std::vector<double> rms = plot_rms();
  std::vector<PlotCurve> curves;
  for (const Variant& refinement : refinements_of(studies)) {
    std::vector<double> logs(rms.size(), 0);
    for (const StudyResults& study : studies) {
      const std::vector<Need> needs = needs_in(study, refinement, rms);
      for (std::size_t i = 0; i < rms.size(); ++i)
        logs[i] += i < needs.size() && needs[i].samples_per_ray
                       ? std::log(*needs[i].samples_per_ray) / double(studies.size())
                       : HUGE_VAL;
    }
    PlotCurve curve{refinement, {}};
    for (std::size_t i = 0; i < rms.size(); ++i)
      if (std::isfinite(logs[i]))
        curve.points.push_back({std::exp(logs[i]), rms[i], variant_name(refinement)});
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  Plot plot = plot_of_curves(curves);
  plot.x_label = "field look-ups per ray, geometric mean";
  plot.y_label = "RMS over R G B A against the reference";
  return plot;
}

namespace {

/// One variant over all frames.
struct FrameStatistics {
  Variant variant;
  std::vector<std::int64_t> frames{};
  std::vector<StudyPoint> points{};  ///< of each frame

  Spread spread(const auto& number) const {
    std::vector<double> values;
    for (const StudyPoint& point : points) values.push_back(std::invoke(number, point));
    return spread_of(std::move(values));
  }
  Spread rms() const { return spread(&StudyPoint::rms); }
  Spread look_ups() const { return spread(&StudyPoint::samples_per_ray); }
  Spread cpu_ms() const { return spread(median_cpu_ms); }
  std::int64_t worst_frame() const {
    const auto worst = std::ranges::max_element(points, {}, &StudyPoint::rms);
    return frames[std::size_t(worst - points.begin())];
  }
};

/// Statistics over all frames, which have one scene but for the names of their files.
struct SequenceStatistics {
  std::vector<FrameStatistics> variants;
  Scene scene;
  std::size_t frames = 0;
};

SequenceStatistics statistics_of(const std::vector<StudiedFrame>& studied) {
  SequenceStatistics all{{}, {}, studied.size()};
  for (const auto& [frame, folder] : studied) {
    const StudyResults results = read_results(folder);
    all.scene = scene_in(results);
    for (const StudyPoint& point : results.points) {
      auto found = std::ranges::find(all.variants, point.variant, &FrameStatistics::variant);
      if (found == all.variants.end()) found = all.variants.insert(found, {point.variant});
      found->frames.push_back(frame);
      found->points.push_back(point);
    }
  }
  return all;
}

std::string statistics_csv(const std::vector<FrameStatistics>& all) {
  std::vector<Json> rows;
  for (const FrameStatistics& s : all) {
    Json& row = rows.emplace_back();
    const auto add = [&](const std::string& name, const Spread& spread) {
      row[name + "_median"] = spread.median;
      row[name + "_min"] = spread.min;
      row[name + "_max"] = spread.max;
    };
    row = {{"variant", variant_name(s.variant)}, {"frames", s.frames.size()}};
    add("rms", s.rms());
    row["worst_frame"] = s.worst_frame();
    add("samples_per_ray", s.look_ups());
    add("cpu_ms", s.cpu_ms());
  }
  return csv_text(rows);
}

TextTable statistics_table(const std::vector<FrameStatistics>& all) {
  TextTable rows = {{"rule, sampling", "RMS, median", "least", "greatest", "in frame",
                     "look-ups a ray, median", "greatest", "processor time, median [ms]"}};
  for (const FrameStatistics& s : all) {
    const Spread rms = s.rms(), samples = s.look_ups();
    rows.push_back({variant_name(s.variant), two_digits(rms.median), two_digits(rms.min),
                    two_digits(rms.max), std::to_string(s.worst_frame()),
                    decimals(samples.median, 1), decimals(samples.max, 1),
                    decimals(s.cpu_ms().median, 1)});
  }
  return rows;
}

/// The method with the fewest look-ups that no 8-bit picture of any frame tells from the truth.
std::string conclusion_of(const SequenceStatistics& all) {
  const FrameStatistics* best = nullptr;
  for (const FrameStatistics& s : all.variants)
    if (s.frames.size() == all.frames && std::ranges::all_of(s.points, within_eight_bits) &&
        (!best || s.look_ups().median < best->look_ups().median))
      best = &s;
  const std::string every = "all " + std::to_string(all.frames) + " frames";
  if (!best) return "For 8 bits in " + every + " no method of this study is enough.";
  std::vector<Variant> same;
  for (const FrameStatistics& s : all.variants)
    if (std::ranges::equal(s.points, best->points, {}, same_as, same_as)) same.push_back(s.variant);
  return "For 8 bits in " + every + " use " + settings_text(all.scene, same) + ": RMS " +
         two_digits(best->rms().max) + " at most, " + decimals(best->look_ups().median, 0) +
         " look-ups a ray." + no_winner_note(all.scene, same.size() > 1);
}

}  // namespace

std::string write_frame_statistics(const std::vector<StudiedFrame>& frames,
                                   const std::filesystem::path& out) {
  const SequenceStatistics all = statistics_of(frames);
  const std::string conclusion = conclusion_of(all);
  Html links("<p>");
  for (const auto& [frame, folder] : frames)
    links += Html("<a href=\"") + folder.filename().string() + "/index.html\">" +
             std::to_string(frame) + "</a> ";
  write_text((out / "frames.csv").string(), statistics_csv(all.variants));
  write_sections(out, "frames", "psivox study of a sequence",
                 {{.text = conclusion, .table = statistics_table(all.variants)},
                  {.title = "Frames", .html = links + "</p>\n"}});
  return conclusion;
}

}  // namespace psivox
