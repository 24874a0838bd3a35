#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "psivox/image.h"
#include "psivox/medium.h"
#include "psivox/progress.h"

// A study renders one view in many ways and measures the error and the cost of each.

namespace psivox {

/// What a study varies: all combinations of these lists.
struct Sweep {
  std::vector<Integrator> integrators;
  std::vector<Sampling> samplings{Sampling::cells, Sampling::uniform};
  std::vector<int> segments{1, 2, 4};             ///< under cells
  std::vector<double> steps{4, 2, 1, 0.5, 0.25};  ///< under uniform [voxels of the finest axis]
  std::vector<Filter> filters{Filter::exact};
  std::vector<TexelType> texels{TexelType::float32};
  std::vector<double> tolerances{};       ///< RMS over R G B A; empty: none is asked for
  std::vector<glm::ivec2> resolutions{};  ///< [pixels]; empty: the scene's own

  Sweep();  ///< with every integrator
};

/// The lists' names on the command line, without dashes.
const std::vector<std::string>& sweep_lists();

/// The scene's parameters that every sweep sets, and that a study's scene therefore does not.
const std::vector<std::string>& swept_parameters();

/// Replaces one list: items with commas, or `all` of the named ones. Throws Error(usage).
void set_sweep(Sweep& sweep, std::string_view list, std::string_view text);

/// One way to render. What its sampling does not read is 0; under a tolerance, which chooses how to
/// march, only the resolution is read.
struct Variant {
  Integrator integrator = Integrator::psi_weighted;
  Sampling sampling = Sampling::cells;
  int segments = 0;  ///< under cells
  double step = 0;   ///< under uniform
  Filter filter = Filter::exact;
  TexelType texel = TexelType::float32;
  glm::ivec2 resolution{0};           ///< [pixels]; 0: the scene's own
  std::optional<double> tolerance{};  ///< 0: of any
  bool operator==(const Variant&) const = default;
};

/// "psi-exact", and "cells 2", "step 0.5" or "template" ("cells" and "uniform" of those of any),
/// then what is not the default of filter, texel and resolution: a row and a column of a table.
/// Under a tolerance "chosen", and "for 0.001" ("by tolerance" of those of any).
std::string rule_name(const Variant& variant);
std::string sampling_name(const Variant& variant);
/// Both, and the same as a file's name without extension.
std::string variant_name(const Variant& variant);
std::string file_name(const Variant& variant);

/// The scene that renders it; and the scene without anything that every sweep sets.
Scene scene_of(const Variant& variant, const Scene& base);
Scene without_sweep(const Scene& scene);

/// What a variant is a point of: the same of any step, segments or tolerance; and whether `a` comes
/// before `b` from coarse to fine.
Variant refinement(Variant variant);
bool is_coarser(const Variant& a, const Variant& b);

struct SkippedVariant {
  Variant variant;
  std::string reason;
};

/// The same with variants of one rule and reason in one line: "cell-exact: step 4, step 2", reason.
std::vector<std::pair<std::string, std::string>> skipped_lines(
    const std::vector<SkippedVariant>& skipped);

struct StudyPlan {
  std::vector<Variant> variants;  ///< those of one texel and filter follow each other
  std::vector<SkippedVariant> skipped;
};

/// The sweep's combinations, and why some are left out: the scene refuses them, or they are another
/// one under a second name.
StudyPlan plan_study(const Sweep& sweep, const Scene& base);

/// Difference of two pictures in some of their channels. Channels with NaN or Inf in either are
/// counted and left out.
struct Deviation {
  double rms = 0;
  double max = 0;  ///< largest absolute difference, and where it is, from the top left
  int max_x = 0, max_y = 0;
  double p99 = 0;   ///< 99 % of the absolute differences are at most this
  double mean = 0;  ///< signed
  std::uint64_t not_finite = 0;
  bool operator==(const Deviation&) const = default;
};

struct PictureError {
  Deviation radiance;  ///< over R, G and B together
  Deviation alpha;
  double rms() const;  ///< over R G B A
  bool operator==(const PictureError&) const = default;
};

/// Of a - b. Throws Error(input) if the sizes differ.
PictureError picture_error(const Image& a, const Image& b);

/// Smallest of the values that `fraction` of them, rounded up to a whole value, do not exceed; 0 of
/// none.
double percentile(std::vector<double> values, double fraction);

struct Spread {
  double median = 0, min = 0, max = 0;
};
/// 0 of none; the median of an even number is the mean of the middle two.
Spread spread_of(std::vector<double> values);

/// Wall time of the march, the GPU's own for its draws and the processor's for the whole process.
/// Under a tolerance choosing the way is part of the first and the last.
struct TimeSample {
  double wall_ms = 0, gpu_ms = 0, cpu_ms = 0;
  bool operator==(const TimeSample&) const = default;
};

/// What was measured of one variant.
struct StudyPoint {
  Variant variant;
  std::optional<Variant> chosen;           ///< under a tolerance: how it was marched
  double estimate = 0;                     ///< under a tolerance: the RMS that was expected of it
  PictureError error;                      ///< GPU - reference
  std::optional<PictureError> step_error;  ///< march in double - reference
  std::optional<PictureError> arithmetic;  ///< GPU - march in double
  double samples_per_ray = 0;              ///< field look-ups
  double steps_per_ray = 0;                ///< segments
  std::uint64_t atlas_bytes = 0;
  double difference_scale = 0;  ///< radiance at full colour in the picture of differences
  std::vector<TimeSample> times;
  bool operator==(const StudyPoint&) const = default;
};

Spread wall_ms(const StudyPoint& point);
Spread gpu_ms(const StudyPoint& point);
Spread cpu_ms(const StudyPoint& point);

/// All that a study knows: results.json.
struct StudyResults {
  std::string version, git;       ///< of psivox; git's hash is empty where the build has none
  std::string processor, system;  ///< the machine
  int threads = 0;
  std::string renderer;  ///< GL_RENDERER and GL_VERSION
  std::string input;
  std::string input_hash;      ///< FNV-1a of the file, 64 bits
  std::string scene;           ///< resolved, as JSON, without_sweep
  double reference_bound = 0;  ///< on the reference's radiance error, at any pixel
  int repeats = 0;
  std::vector<SkippedVariant> skipped;
  std::vector<StudyPoint> points;
};

std::string results_json(const StudyResults& results);
/// Throws Error(input) that names `source`.
StudyResults results_from_json(std::string_view text, std::string_view source);

/// A header and a line for each point, numbers with all their digits.
std::string results_csv(const StudyResults& results);

/// Markdown: a table of rules by samplings, cells "RMS (CPU time over that of porter-duff in the
/// same column)", and the list of what was left out.
std::string results_markdown(const StudyResults& results);

/// What a rule under a sampling takes to bring the RMS down to `rms`: between the points of a
/// refinement, straight in the logarithms; unset where none gets there.
struct Need {
  Variant variant;  ///< the refinement: step, segments and tolerance are 0
  double rms = 0;
  std::optional<double> samples_per_ray, cpu_ms;
  bool at_most = false;  ///< the coarsest point is good enough: it takes that or less
};
/// For each RMS, refinements in the order of their first points.
std::vector<Need> needs_of(const StudyResults& results,
                           const std::vector<double>& rms_wanted = {1e-2, 1e-3, 1e-4, 1e-5});

/// Why a study that was begun cannot go on as `next`, empty where it can: another scene, input,
/// version or driver, or points that the new one has not.
std::string resume_obstacle(const StudyResults& begun, const StudyResults& next,
                            const StudyPlan& plan);

struct Cost {
  double time = 0, error = 0;
};
/// Indices of those that no other one beats in one number without losing in the other, by time. An
/// error must be below that of the cheaper ones by `margin` of it to count as less.
std::vector<std::size_t> pareto_front(const std::vector<Cost>& costs, double margin = 0);

struct StudyOptions {
  std::filesystem::path folder;  ///< made where it is missing
  Sweep sweep;
  int repeats = 3;
  bool split = true;    ///< step and arithmetic error apart, by the march in double
  bool resume = false;  ///< go on with the study in the folder, if there is one
  Progress progress{};
  std::function<bool()> stop{};  ///< asked between and during renders; empty: never
};

/// Throws Error(usage) where the folder holds results and they are not to be resumed; Error(output)
/// where it cannot be made.
void check_study_folder(const std::filesystem::path& folder, bool resume);

/// Runs the study of a view that make_view made and writes everything to the folder; results.json
/// and results.csv after every point, so that it can be stopped at any time. Throws Error(usage)
/// where the folder has other results, Error(interrupted) once `stop` says so, after the report of
/// what there is has been written; else as rendering does.
StudyResults run_study(View view, const StudyOptions& options);

/// What each rule and sampling needs for an RMS in several finished studies, their folders given,
/// side by side: needs.csv, needs.md, plots and index.html in `out`. Throws Error(input).
void run_summary(const std::vector<std::filesystem::path>& folders,
                 const std::filesystem::path& out);

/// The rules alone, without a volume: errors of Psi, zeta and the colour over the ends of a segment
/// of linear attenuation, in double against the exact rule and in float against double. Writes
/// psi.csv, psi.md, pictures and index.html.
void run_psi_study(const std::filesystem::path& folder, const Progress& progress = {});

/// Orders of convergence in step, voxel and pixel, without a volume: the march in double over media
/// that are formulas, one length at a time, beside the orders expected. Writes orders.csv,
/// orders.json, orders.md, plots and index.html.
void run_order_study(const std::filesystem::path& folder, const Progress& progress = {});

}  // namespace psivox
