#include <nettle/sha2.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>
#include <thread>

#include "base/input_file.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/text_file.h"
#include "field/leaf_values.h"
#include "plan/plan.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/study.h"
#include "psivox/vdb.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/results.h"
#include "study/study_pictures.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// The processor's name; "unknown" if the machine does not say.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string system_name() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

/// SHA-256 in hexadecimal.
class Hash {
 public:
  Hash() { sha256_init(&state_); }
  void add(const char* bytes, std::size_t count) {
    sha256_update(&state_, count, reinterpret_cast<const std::uint8_t*>(bytes));
  }
  std::string text() {
    std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest{};
    sha256_digest(&state_, digest.size(), digest.data());
    std::string text;
    for (const std::uint8_t byte : digest) text += formatted("%02x", unsigned(byte));
    return text;
  }

 private:
  sha256_ctx state_{};
};

/// The day in UTC, as 2026-11-29.
std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm day{};
  gmtime_r(&now, &day);
  return formatted("%04d-%02d-%02d", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

std::string file_hash(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  Hash hash;
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), std::streamsize(block.size())) || file.gcount() > 0)
    hash.add(block.data(), std::size_t(file.gcount()));
  if (!file.eof()) throw Error(ExitCode::input, "cannot read " + in_quotes(path.string()));
  return hash.text();
}

std::string values_hash(const Field& field) {
  Hash hash;
  for (const Leaf& leaf : field.leaves) {
    const OrderedValues values(field, leaf);
    hash.add(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
  return hash.text();
}

/// The results of a study that begins here: psivox, the machine and the input, without points.
StudyResults new_results(const View& view, const std::string& renderer, int repeats) {
  const std::string& input = view.scene.input;
  const fs::path file = input.empty() ? fs::path() : frame_of_file(input).file;
  StudyResults results;
  results.version = PSIVOX_VERSION;
  results.git = git_hash();
  results.processor = processor_name();
  results.system = system_name();
  results.threads = int(std::thread::hardware_concurrency());
  results.renderer = renderer;
  results.date = today();
  results.input = input.empty() ? "grids in memory" : input;
  results.input_hash =
      fs::is_regular_file(file) ? file_hash(file) : values_hash(*view.medium.density);
  results.scene = to_json(view.scene);
  results.repeats = repeats;
  return results;
}

class StudyRun {
 public:
  StudyRun(View view, const StudyOptions& options)
      : options_(options),
        pictures_(std::move(view), options),
        plan_(plan_study(options.sweep, pictures_.scene)),
        base_(new_results(pictures_.session.view(), description(*pictures_.gpu), options.repeats)),
        cost_(options_, plan_, pictures_.scene) {}

  void run() {
    refuse_nothing();
    pictures_.session.prepare(*pictures_.by_reference, pictures_.wish_of(plan_.variants.front()));
    check_volume();
    resume();
    for (const char* folder : {pictures_folder, differences_folder})
      make_folder(options_.folder / folder);
    forecast();
    all_ = cost_.left(points_);
    if (!fs::exists(options_.folder / results_name)) save();
    for (const Variant& variant : plan_.variants) pictures_.reference(variant);
    base_.reference_bound = pictures_.reference_bound;
    say_blank();
    for (const ForeignPicture& foreign : options_.foreign)
      base_.foreign.push_back(pictures_.compare(foreign));
    save();
    did(cost_.references());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (measured(i)) continue;
      measure(i);
      save();
      did(cost_.measuring(i));
    }
    if (finished() < points_.size()) settle();
    // Times are measured in rounds, to and fro, so that a machine that slows down affects all
    // variants alike.
    for (int round = 0; round < options_.repeats; ++round)
      for (std::size_t n = 0; n < points_.size(); ++n) {
        const std::size_t i = round % 2 == 0 ? n : points_.size() - 1 - n;
        if (int(points_[i]->times.size()) > round) continue;
        time(i);
        save();
        did(cost_.picture(plan_.variants[i]));
      }
    save();
    pictures_.write_turning_page();
  }

  void report() const {
    const StudyResults now = results();
    std::vector<PagePicture> pictures;
    const auto add = [&](const std::string& name) {
      for (const char* folder : {pictures_folder, differences_folder})
        pictures.push_back({std::string(folder) + "/" + name + ".png"});
    };
    for (const StudyPoint& point : now.points) {
      add(file_name(point.variant));
      pictures.push_back({reference_name(point.variant) + ".png", 512});
    }
    for (const ForeignPoint& point : now.foreign) add(file_name(point.picture));
    write_page(options_.folder, "psivox study of " + fs::path(now.input).filename().string(),
               results_json(now), pictures, {turning_name});
  }

  StudyResults results() const {
    StudyResults results = base_;
    for (const auto& point : points_)
      if (point) results.points.push_back(*point);
    return results;
  }

  std::string state() const {
    return std::to_string(finished()) + " of " + std::to_string(points_.size()) +
           " points are finished";
  }

 private:
  /// Points that have all their times.
  std::size_t finished() const {
    return std::size_t(std::ranges::count_if(points_, [&](const auto& point) {
      return point && int(point->times.size()) >= options_.repeats;
    }));
  }

  void refuse_nothing() const {
    if (!plan_.variants.empty()) return;
    throw Error(ExitCode::usage,
                "the sweep has nothing to render: " +
                    (plan_.skipped.empty() ? "it is empty" : plan_.skipped.front().reason));
  }

  /// Removes from the plan the variants that the volume refuses: of a texel type that cannot hold
  /// its values, of templates beside its other grids, or of a step too short to cross it.
  void check_volume() {
    // to refuse it; empty: none
    std::map<std::tuple<TexelType, Sampling, double>, std::string> reasons;
    std::erase_if(plan_.variants, [&](const Variant& variant) {
      const auto [reason, is_new] =
          reasons.try_emplace({variant.texel, variant.method.sampling, variant.method.step});
      try {
        if (is_new) pictures_.session.prepare(*pictures_.gpu, pictures_.wish_of(variant));
      } catch (const Error& error) {
        if (error.code() != ExitCode::input && error.code() != ExitCode::usage) throw;
        reason->second = error.what();
      }
      if (!reason->second.empty()) plan_.skipped.push_back({variant, reason->second});
      return !reason->second.empty();
    });
    refuse_nothing();
    base_.skipped = plan_.skipped;
    points_.resize(plan_.variants.size());
  }

  void resume() {
    if (!options_.resume || !fs::exists(options_.folder / results_name)) return;
    const EarlierOutput earlier;
    const StudyResults begun = read_results(options_.folder);
    const std::string obstacle = resume_obstacle(begun, base_, plan_);
    if (!obstacle.empty())
      throw Error(ExitCode::usage, "cannot resume: the study in " +
                                       in_quotes(options_.folder.string()) + " " + obstacle +
                                       "; give another folder with -o");
    for (const ForeignPoint& point : begun.foreign) {
      const auto given = [&](const ForeignPicture& f) { return f.name == point.picture.name; };
      if (std::ranges::none_of(options_.foreign, given)) base_.foreign.push_back(point);
    }
    for (const StudyPoint& point : begun.points) {
      const auto at = std::find(plan_.variants.begin(), plan_.variants.end(), point.variant);
      points_[std::size_t(at - plan_.variants.begin())] = point;
    }
  }

  /// Says why there is nothing in the picture, if that is so.
  void say_blank() {
    const std::string reason =
        blank_reason(pictures_.session.view(), pictures_.reference(plan_.variants.front()));
    if (options_.say && !reason.empty()) options_.say(reason);
  }

  /// Says how long a new study takes.
  void forecast() {
    constexpr int short_pixels = 64 * 64;
    const Variant& tried = plan_.variants[plan_.variants.size() / 2];
    const glm::ivec2 size = scene_of(tried, pictures_.scene).resolution;
    if (!options_.say || tried.tolerance || size.x * size.y < short_pixels ||
        fs::exists(options_.folder / results_name))
      return;
    const std::string text = cost_.forecast(tried, pictures_.trial(tried));
    if (!text.empty()) options_.say(text);
  }

  /// Measures all but the times; these results do not depend on when they are measured.
  void measure(std::size_t i) {
    const Variant& variant = plan_.variants[i];
    StudyPoint point;
    point.variant = variant;
    if (points_[i]) point.times = points_[i]->times;

    Wish wish = pictures_.wish_of(variant);
    Drawn drawn = pictures_.session.draw(*pictures_.gpu, wish);
    wish.plan = drawn.plan;
    wish.count = true;
    wish.confirm = false;
    const RenderStats counts = pictures_.session.draw(*pictures_.gpu, wish).stats;
    const Image& reference = pictures_.reference(variant);
    if (drawn.plan) {
      point.chosen = variant_of(drawn.plan->chosen.method, variant.resolution);
      if (drawn.plan->march->code_widths) point.chosen->texel = TexelType::automatic;
      point.estimate = drawn.plan->chosen.rms;
    }
    point.error = picture_error(drawn.image, reference);
    point.same_as = same_picture(i, point, drawn.image);
    const double rays = double(counts.rays);
    point.samples_per_ray = double(counts.samples) / rays;
    point.steps_per_ray = double(counts.steps) / rays;
    point.atlas_bytes = drawn.atlas.bytes();
    point.difference_scale = point.error.full_color();
    if (options_.split) {
      wish.count = false;
      const Image exact = pictures_.session.draw(*pictures_.by_double, wish).image;
      point.step_error = picture_error(exact, reference);
      point.arithmetic = picture_error(drawn.image, exact);
    }
    const std::string file = file_name(variant) + ".png";
    write_image(difference_picture(drawn.image, reference, point.difference_scale),
                options_.folder / differences_folder / file);
    pictures_.write_png(std::move(drawn.image), wish.scene.value(),
                        options_.folder / pictures_folder / file);
    points_[i] = std::move(point);
  }

  /// Draws without timing, because drivers go on with new programs in the background after a first
  /// draw: what is timed first would pay for it.
  void settle() {
    constexpr double background_ms = 200;
    const Stopwatch watch;
    do pictures_.session.draw(*pictures_.gpu, pictures_.wish_of(plan_.variants.front()));
    while (watch.ms() < background_ms);
  }

  void time(std::size_t i) {
    const Variant& variant = plan_.variants[i];
    Wish wish = pictures_.wish_of(variant);
    wish.confirm = false;
    const Drawn drawn = pictures_.session.draw(*pictures_.gpu, wish);
    const RenderStats& stats = drawn.stats;
    const PreparationTimes& before = drawn.times;
    points_[i]->times.push_back(
        {before.plan_ms + stats.march_ms, stats.gpu_ms, before.plan_cpu_ms + stats.cpu_ms});
  }

  /// The name of a point that differs from this one in its rule alone and has the same picture but
  /// for rounding; empty if there is none.
  std::string same_picture(std::size_t i, const StudyPoint& point, const Image& image) {
    const double rounding = rounding_rms(image);
    for (std::size_t j = 0; j < points_.size(); ++j) {
      if (j == i || !points_[j] || !points_[j]->same_as.empty() ||
          !differ_in_rule(plan_.variants[j], point.variant) ||
          std::abs(points_[j]->rms() - point.rms()) > rounding)  // triangle inequality
        continue;
      const Image other =
          pictures_.session.draw(*pictures_.gpu, pictures_.wish_of(plan_.variants[j])).image;
      if (picture_error(other, image).rms() <= rounding) return variant_name(plan_.variants[j]);
    }
    return {};
  }

  bool measured(std::size_t i) const {
    return points_[i] && (!options_.split || points_[i]->arithmetic);
  }
  void did(double work) {
    done_ += work;
    if (options_.progress) options_.progress(done_ / all_);
  }

  void save() const {
    const StudyResults now = results();
    write_text((options_.folder / "results.csv").string(), results_csv(now));
    write_text((options_.folder / results_name).string(), results_json(now));
  }

  const StudyOptions& options_;
  StudyPictures pictures_;
  StudyPlan plan_;
  StudyResults base_;                              ///< without points
  std::vector<std::optional<StudyPoint>> points_;  ///< one for each variant of the plan
  StudyCost cost_;
  double done_ = 0, all_ = 1;
};

}  // namespace

WrittenFolder study_folder(const fs::path& folder, bool resume) {
  const auto refuse = [&](const std::string& holds, const std::string& advice) {
    throw Error(ExitCode::usage,
                in_quotes(folder.string()) + " holds " + holds + "; " + advice + " with -o");
  };
  std::error_code unknown;  // making the folder says it
  if (!resume && fs::exists(folder / results_name, unknown))
    refuse("the results of a study", "--resume goes on with it, or give another folder");
  if (!resume &&
      fs::exists(folder / page_name, unknown))  // of another kind of study, or not of psivox
    refuse("an " + std::string(page_name), "give another folder");
  return WrittenFolder(folder);
}

void check_study_folder(const fs::path& folder, bool resume) {
  const WrittenFolder made = study_folder(folder, resume);
}

std::string run_study(View view, const StudyOptions& options) {
  if (view.scene.shows(Shows::plane))
    throw Error(ExitCode::usage, "--mode slice does not march; a study has nothing to compare");
  const WrittenFolder folder = study_folder(options.folder, options.resume);
  check_foreign(options, view.scene);
  StudyRun run(std::move(view), options);
  try {
    run.run();
  } catch (const Error& error) {
    if (error.code() != ExitCode::interrupted) throw;
    run.report();
    throw Error(ExitCode::interrupted, "interrupted: " + run.state() + " in " +
                                           in_quotes(options.folder.string()) +
                                           "; --resume goes on with it");
  }
  run.report();
  if (options.progress) options.progress(1);
  return conclusion_text(run.results());
}

}  // namespace psivox
