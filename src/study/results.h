#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "psivox/image.h"
#include "psivox/medium.h"
#include "psivox/scene.h"
#include "psivox/study.h"

namespace psivox {

/// A method, and the other parameters that a study varies. A tolerance chooses the method; then
/// only the resolution is read.
struct Variant {
  Method method;
  Filter filter = Filter::exact;
  TexelType texel = TexelType::float32;
  glm::ivec2 resolution{0};           ///< [pixels]; 0: the scene's
  std::optional<double> tolerance{};  ///< 0 in a refinement()
  bool operator==(const Variant&) const = default;
};

/// The row and the column of a variant in a table. The row is "psi-exact"; the column is "cells 2",
/// "step 0.5" or "template", then every filter, texel and resolution that is not the default. Under
/// a tolerance they are "chosen" and "for 0.001". A refinement() has "cells", "uniform" and "by
/// tolerance" as its columns.
std::string rule_name(const Variant& variant);
std::string sampling_name(const Variant& variant);
/// Both names together; and both as a file name without extension.
std::string variant_name(const Variant& variant);
std::string file_name(const Variant& variant);
/// The name with `_` in place of spaces.
std::string file_name(std::string name);

Variant variant_of(Method method, const glm::ivec2& resolution);

bool differ_in_rule(Variant a, const Variant& b);

Scene scene_of(const Variant& variant, const Scene& base);

/// Whether the picture depends on the rule and the segments: a maximum or a surface does not.
bool has_rules(const Scene& scene);
/// A sentence that says why the picture does not depend on them.
std::string no_rules_note(const Scene& scene);

/// The curve that a variant is a point of: the variant with step, segments and tolerance set to 0.
Variant refinement(Variant variant);
/// Whether `a` comes before `b` on their curve, which runs from coarse to fine.
bool is_coarser(const Variant& a, const Variant& b);

struct SkippedVariant {
  Variant variant;
  std::string reason;
};

struct StudyPlan {
  std::vector<Variant> variants;  ///< grouped by texel and filter
  std::vector<SkippedVariant> skipped;
};

/// The combinations of the sweep without duplicates. It skips combinations that the scene refuses,
/// and records the reason.
StudyPlan plan_study(const Sweep& sweep, const Scene& base);

/// Difference of two pictures in some of their channels. It counts values that are NaN or Inf in
/// either picture and leaves them out.
struct Deviation {
  double rms = 0;
  double max = 0;  ///< largest absolute difference, and its pixel from the top left
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
  std::uint64_t not_finite() const { return radiance.not_finite + alpha.not_finite; }
  /// The radiance difference that has full colour in a picture of differences.
  double full_color() const { return radiance.p99 > 0 ? radiance.p99 : radiance.max; }
  bool operator==(const PictureError&) const = default;
};

/// The error a - b. Throws Error(input) if the sizes differ.
PictureError picture_error(const Image& a, const Image& b);

/// The RMS over R G B A by which rounding alone may change the picture. In float a segment rounds
/// the ray's sums by a few halves of 2^-23 of them, and the roundings of n segments add up as
/// sqrt(n): 8 * 2^-23 of the picture for 100 of them. Pictures that differ by no more cannot be
/// told apart by their method.
double rounding_rms(const Image& image);

/// Times of the march: wall time, the GPU timer's time for the draws, and the process's CPU time.
/// Under a tolerance, wall and CPU times include the choice of a method.
struct TimeSample {
  double wall_ms = 0, gpu_ms = 0, cpu_ms = 0;
  bool operator==(const TimeSample&) const = default;
};

/// The measurements of one variant.
struct StudyPoint {
  Variant variant;
  /// Under a tolerance: the method that was used. Texel auto: values were stored in codes.
  std::optional<Variant> chosen;
  double estimate = 0;  ///< under a tolerance: the estimated RMS
  PictureError error;   ///< GPU - reference
  /// Another point, by its name, that differs from this one in its rule alone, and whose picture
  /// differs by rounding alone; empty for the first of such points.
  std::string same_as{};
  std::optional<PictureError> step_error;  ///< march in double - reference
  std::optional<PictureError> arithmetic;  ///< GPU - march in double
  double samples_per_ray = 0;              ///< field look-ups
  double steps_per_ray = 0;                ///< segments
  std::uint64_t atlas_bytes = 0;
  double difference_scale = 0;  ///< radiance difference that has full colour in its picture
  std::vector<TimeSample> times;
  double rms() const { return error.rms(); }
  bool operator==(const StudyPoint&) const = default;
};

inline Spread spread(const StudyPoint& point, double TimeSample::*clock) {
  std::vector<double> values;
  for (const TimeSample& time : point.times) values.push_back(time.*clock);
  return spread_of(std::move(values));
}
inline double median_cpu_ms(const StudyPoint& point) {
  return spread(point, &TimeSample::cpu_ms).median;
}

/// The measurement of another renderer's picture.
struct ForeignPoint {
  ForeignPicture picture;
  /// Its alpha is 1 everywhere, unlike the reference's. R, G and B are compared over the scene's
  /// background, or black, and the error of alpha is not known.
  bool opaque = false;
  glm::ivec2 resolution{0};
  PictureError error{};
  double difference_scale = 0;
  double rms() const { return opaque ? error.radiance.rms : error.rms(); }
};

/// The name as that of a file, without extension.
std::string file_name(const ForeignPicture& picture);

/// The point as results.json has it.
nlohmann::ordered_json json_of(const StudyPoint& point);

/// The folders of pictures in a study's folder. Each has a `file_name(variant)`.png for each point.
inline constexpr const char* pictures_folder = "pictures";
inline constexpr const char* differences_folder = "differences";

/// The page on which the study's picture turns, if there is one.
inline constexpr const char* turning_name = "turning.html";

/// File name, without extension, of the reference for a variant. There is one reference per
/// resolution.
std::string reference_name(const Variant& variant);

/// The contents of results.json.
struct StudyResults {
  std::string version, git;       ///< of psivox; the hash is empty if the build has none
  std::string processor, system;  ///< the machine
  int threads = 0;
  std::string date{};    ///< of the study, or of its last --resume, in UTC
  std::string renderer;  ///< GL_RENDERER and GL_VERSION
  std::string input;
  std::string input_hash;      ///< SHA-256 of the file, or of the values in memory
  std::string scene;           ///< resolved, as JSON, studied_scene
  double reference_bound = 0;  ///< bound on the reference's radiance error at any pixel
  int repeats = 0;
  std::vector<SkippedVariant> skipped;
  std::vector<StudyPoint> points;
  std::vector<ForeignPoint> foreign{};
};

Scene scene_in(const StudyResults& results);
/// The command that draws the study's scene by the default method.
std::string command_of(const StudyResults& results);

/// If a software renderer's wall times scatter between repeats and its processor times do not: a
/// sentence that says so; then the page plots processor time alone. Else empty.
std::string clock_note(const StudyResults& results);

std::string results_json(const StudyResults& results);
/// A line for each point, with all digits of each number.
std::string results_csv(const StudyResults& results);
/// Throws Error(input) that names `source`.
StudyResults results_from_json(std::string_view text, std::string_view source);

inline constexpr const char* results_name = "results.json";
/// Reads that file in the folder of a study. Throws Error(input).
StudyResults read_results(const std::filesystem::path& folder);

/// Why the study `begun` cannot continue as `next`: another scene, input, version or driver, or
/// points that `plan` lacks. Empty if it can.
std::string resume_obstacle(const StudyResults& begun, const StudyResults& next,
                            const StudyPlan& plan);

}  // namespace psivox
