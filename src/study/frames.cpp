// Statistics over the studies of a sequence's frames.

#include <algorithm>
#include <functional>

#include "psivox/study.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/results.h"

namespace psivox {
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

Json json_of(const FrameStatistics& s) {
  Json row = {{"variant", variant_name(s.variant)}, {"frames", s.frames.size()}};
  const auto add = [&](const std::string& name, const Spread& spread) {
    row[name + "_median"] = spread.median;
    row[name + "_min"] = spread.min;
    row[name + "_max"] = spread.max;
  };
  add("rms", s.rms());
  row["worst_frame"] = s.worst_frame();
  add("samples_per_ray", s.look_ups());
  add("cpu_ms", s.cpu_ms());
  return row;
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
  std::vector<Json> methods;
  for (const FrameStatistics& s : all.variants) methods.push_back(json_of(s));
  Json data = {{"psivox_frames", 1}, {"conclusion", conclusion}, {"frames", Json::array()}};
  for (const auto& [frame, folder] : frames)
    data["frames"].push_back({{"frame", frame}, {"folder", folder.filename().string()}});
  data["methods"] = methods;
  write_text((out / "frames.csv").string(), csv_text(methods));
  write_text((out / "frames.json").string(), json_text(data));
  write_page(out, "psivox study of a sequence", json_text(data), {});
  return conclusion;
}

}  // namespace psivox
