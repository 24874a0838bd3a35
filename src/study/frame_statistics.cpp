// Statistics over the studies of a sequence's frames.

#include <algorithm>
#include <limits>

#include "psivox/parameters.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "study/conclusion.h"
#include "study/csv_line.h"
#include "study/html.h"
#include "study/results.h"
#include "study/results_table.h"

namespace psivox {
namespace {

/// One variant over all frames.
struct FrameStatistics {
  Variant variant;
  std::vector<int> frames;
  std::vector<std::string> same_as;  ///< in each frame
  std::vector<double> rms, samples, cpu_ms;
  double worst_p99 = 0;  ///< of radiance and alpha, over all frames

  void add(int frame, const StudyPoint& point) {
    frames.push_back(frame);
    same_as.push_back(psivox::same_as(point));
    rms.push_back(point.error.rms());
    samples.push_back(point.samples_per_ray);
    cpu_ms.push_back(psivox::cpu_ms(point).median);
    worst_p99 = std::max({worst_p99, point.error.radiance.p99, point.error.alpha.p99});
    if (point.error.radiance.not_finite || point.error.alpha.not_finite)
      worst_p99 = std::numeric_limits<double>::infinity();
  }
  /// The frame with the greatest RMS.
  int worst_frame() const {
    return frames[std::size_t(std::ranges::max_element(rms) - rms.begin())];
  }
};

/// Of all frames. They are in one scene, but for the names of their files.
struct SequenceStatistics {
  std::vector<FrameStatistics> variants;
  Scene scene;
  std::size_t frames = 0;
};

SequenceStatistics statistics_of(const std::vector<StudiedFrame>& studied) {
  SequenceStatistics all{{}, {}, studied.size()};
  for (const auto& [frame, folder] : studied) {
    const std::string path = (folder / "results.json").string();
    const StudyResults results = results_from_json(read_text(path, "study"), path);
    all.scene = scene_from_json(results.scene, path);
    for (const StudyPoint& point : results.points) {
      auto found = std::ranges::find(all.variants, point.variant, &FrameStatistics::variant);
      if (found == all.variants.end())
        found = all.variants.insert(found, {point.variant, {}, {}, {}, {}, {}});
      found->add(frame, point);
    }
  }
  return all;
}

std::string statistics_csv(const std::vector<FrameStatistics>& all) {
  std::string out =
      "variant,frames,rms_median,rms_min,rms_max,worst_frame,samples_per_ray_median,"
      "samples_per_ray_min,samples_per_ray_max,cpu_ms_median,cpu_ms_min,cpu_ms_max\n";
  for (const FrameStatistics& s : all) {
    CsvLine line;
    line << variant_name(s.variant) << double(s.frames.size());
    const auto spread = [&](const std::vector<double>& values) {
      const Spread found = spread_of(values);
      line << found.median << found.min << found.max;
    };
    spread(s.rms);
    line << double(s.worst_frame());
    spread(s.samples);
    spread(s.cpu_ms);
    out += line.str();
  }
  return out;
}

TextTable statistics_table(const std::vector<FrameStatistics>& all) {
  TextTable rows = {{"rule, sampling", "RMS, median", "least", "greatest", "in frame",
                     "look-ups a ray, median", "greatest", "processor time, median [ms]"}};
  for (const FrameStatistics& s : all) {
    const Spread rms = spread_of(s.rms), samples = spread_of(s.samples);
    rows.push_back({variant_name(s.variant), two_digits(rms.median), two_digits(rms.min),
                    two_digits(rms.max), std::to_string(s.worst_frame()),
                    decimals(samples.median, 1), decimals(samples.max, 1),
                    decimals(spread_of(s.cpu_ms).median, 1)});
  }
  return rows;
}

/// The method with the fewest look-ups that no 8-bit picture of any frame tells from the truth.
std::string conclusion_of(const SequenceStatistics& all) {
  const FrameStatistics* best = nullptr;
  const auto look_ups = [](const FrameStatistics& s) { return spread_of(s.samples).median; };
  for (const FrameStatistics& s : all.variants)
    if (s.frames.size() == all.frames && s.worst_p99 <= eight_bits_error &&
        (!best || look_ups(s) < look_ups(*best)))
      best = &s;
  const std::string every = "all " + std::to_string(all.frames) + " frames";
  if (!best) return "For 8 bits in " + every + " no method of this study is enough.";
  std::vector<Variant> same;
  for (const FrameStatistics& s : all.variants)
    if (s.same_as == best->same_as) same.push_back(s.variant);
  return "For 8 bits in " + every + " use " + settings_text(all.scene, same) + ": RMS " +
         two_digits(spread_of(best->rms).max) + " at most, " + decimals(look_ups(*best), 0) +
         " look-ups a ray." + no_winner_note(all.scene, same.size() > 1);
}

}  // namespace

std::string write_frame_statistics(const std::vector<StudiedFrame>& frames,
                                   const std::filesystem::path& out) {
  const SequenceStatistics all = statistics_of(frames);
  const std::string conclusion = conclusion_of(all);
  const TextTable table = statistics_table(all.variants);
  std::string body = "<p>" + conclusion + "</p>\n" + html_table(table) + "<h2>Frames</h2>\n<p>";
  for (const auto& [frame, folder] : frames)
    body += "<a href=\"" + folder.filename().string() + "/index.html\">" + std::to_string(frame) +
            "</a> ";
  write_text((out / "frames.csv").string(), statistics_csv(all.variants));
  write_text((out / "frames.md").string(), conclusion + "\n\n" + markdown_table(table));
  write_text((out / "index.html").string(),
             html_page("psivox study of a sequence", body + "</p>\n"));
  return conclusion;
}

}  // namespace psivox
