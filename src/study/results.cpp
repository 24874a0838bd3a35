#include "study/results.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/command_text.h"
#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/marcher.h"
#include "psivox/parameters.h"
#include "scene/json_problem.h"
#include "study/conclusion.h"
#include "study/page.h"

namespace psivox {
namespace {

constexpr int format_version = 1;

Json json_of(const Variant& v) {
  const Scene scene = scene_of(v, {});
  const auto text = [&](const char* name) { return parameter_text(scene, name); };
  Json j;
  if (v.tolerance)
    j["tolerance"] = *v.tolerance;
  else
    j = {{"integrator", text("integrator")}, {"sampling", text("sampling")},
         {"segments", v.method.segments},    {"step", v.method.step},
         {"filter", text("filter")},         {"texel", text("texel")}};
  if (v.resolution.x > 0) j["resolution"] = text("resolution");
  j.update({{"name", variant_name(v)},  // for the page
            {"rule", rule_name(v)},
            {"setting", sampling_name(v)},
            {"curve", variant_name(refinement(v))}});
  return j;
}

Variant variant_from(const Json& j) {
  Scene scene;
  Variant v;
  if (j.contains("tolerance")) {
    v.tolerance = j.at("tolerance").get<double>();
  } else {
    for (const char* name : {"integrator", "sampling", "filter", "texel"})
      set_parameter(scene, name, j.at(name).get<std::string>());
    v.method = {*scene.integrator, *scene.sampling, j.at("segments").get<int>(),
                j.at("step").get<double>()};
    v.filter = scene.filter;
    v.texel = scene.texel;
  }
  if (j.contains("resolution")) {
    set_parameter(scene, "resolution", j.at("resolution").get<std::string>());
    v.resolution = scene.resolution;
  }
  return v;
}

Json json_of(const Deviation& d) {
  return {{"rms", d.rms}, {"max", d.max},   {"max_x", d.max_x},          {"max_y", d.max_y},
          {"p99", d.p99}, {"mean", d.mean}, {"not_finite", d.not_finite}};
}

Deviation deviation_from(const Json& j) {
  return {j.at("rms"), j.at("max"),  j.at("max_x"),     j.at("max_y"),
          j.at("p99"), j.at("mean"), j.at("not_finite")};
}

Json json_of(const PictureError& e) {
  return {{"rms", e.rms()}, {"radiance", json_of(e.radiance)}, {"alpha", json_of(e.alpha)}};
}
Json json_of(const std::optional<PictureError>& e) { return e ? json_of(*e) : Json(nullptr); }

PictureError error_from(const Json& j) {
  return {deviation_from(j.at("radiance")), deviation_from(j.at("alpha"))};
}

std::optional<PictureError> optional_error_from(const Json& j) {
  return j.is_null() ? std::nullopt : std::optional(error_from(j));
}

StudyPoint point_from(const Json& j) {
  StudyPoint p;
  p.variant = variant_from(j);
  if (j.contains("chosen")) {
    p.chosen = variant_from(j.at("chosen"));
    p.estimate = j.at("chosen").at("rms").get<double>();
  }
  p.same_as = j.value("same_as", "");
  p.error = error_from(j.at("error"));
  p.step_error = optional_error_from(j.at("step_error"));
  p.arithmetic = optional_error_from(j.at("arithmetic_error"));
  p.samples_per_ray = j.at("samples_per_ray");
  p.steps_per_ray = j.at("steps_per_ray");
  p.atlas_bytes = j.at("atlas_bytes");
  p.difference_scale = j.at("difference_scale");
  for (const Json& t : j.at("times_ms"))
    p.times.push_back({t.at("wall"), t.at("gpu"), t.at("cpu")});
  return p;
}

Json json_of(const ForeignPoint& p) {
  return {{"name", p.picture.name},
          {"picture", p.picture.file},
          {"time_ms", p.picture.time_ms > 0 ? Json(p.picture.time_ms) : Json(nullptr)},
          {"opaque", p.opaque},
          {"resolution", {p.resolution.x, p.resolution.y}},
          {"rms", p.rms()},
          {"error", json_of(p.error)},
          {"difference_scale", p.difference_scale}};
}

ForeignPoint foreign_from(const Json& j) {
  const Json &time = j.at("time_ms"), &resolution = j.at("resolution");
  return {{j.at("name"), j.at("picture"), time.is_null() ? 0 : time.get<double>()},
          j.at("opaque"),
          {int(resolution.at(0)), int(resolution.at(1))},
          error_from(j.at("error")),
          j.at("difference_scale")};
}

/// The scene without the name of its file, because the same file may have another name.
Json scene_without_input(const std::string& text) {
  Json scene = Json::parse(text);
  scene.erase("input");
  return scene;
}

/// The columns of results.csv: numbers of a point's JSON by their paths, without `error_` in front,
/// and the median, quartiles and ends of its times.
constexpr const char* csv_head =
    "renderer,integrator,sampling,segments,step,filter,texel,resolution,tolerance,estimate,rms,"
    "radiance_rms,radiance_max,radiance_max_x,radiance_max_y,radiance_p99,radiance_mean,"
    "radiance_not_finite,alpha_rms,alpha_max,alpha_max_x,alpha_max_y,alpha_p99,alpha_mean,"
    "alpha_not_finite,step_error_radiance_rms,step_error_radiance_max,step_error_alpha_rms,"
    "step_error_alpha_max,arithmetic_error_radiance_rms,arithmetic_error_radiance_max,"
    "arithmetic_error_alpha_rms,arithmetic_error_alpha_max,samples_per_ray,steps_per_ray,"
    "atlas_bytes,repeats,gpu_ms_median,gpu_ms_lower,gpu_ms_upper,gpu_ms_min,gpu_ms_max,"
    "wall_ms_median,wall_ms_lower,wall_ms_upper,wall_ms_min,wall_ms_max,cpu_ms_median,"
    "cpu_ms_lower,cpu_ms_upper,cpu_ms_min,cpu_ms_max";

/// {"error": {"radiance": {"rms": 1}}} becomes {"radiance_rms": 1}.
Json flat(const Json& nested) {
  const Json leaves = nested.flatten();
  Json row = Json::object();
  for (const auto& [path, value] : leaves.items()) {
    std::string name = path.substr(path.starts_with("/error/") ? 7 : 1);
    std::ranges::replace(name, '/', '_');
    row[name] = value;
  }
  return row;
}

Json csv_row(const StudyPoint& p, const Scene& base) {
  const Variant marched = p.chosen.value_or(p.variant);
  const Scene scene = scene_of(marched, base);
  Json row = flat(json_of(p));
  row["renderer"] = "psivox";
  for (const char* name : {"integrator", "sampling", "filter", "texel", "resolution"})
    row[name] = parameter_text(scene, name);
  row["segments"] = marched.method.segments;
  row["step"] = marched.method.step;
  row["tolerance"] = p.variant.tolerance.value_or(0);
  row["estimate"] = p.estimate;
  row["repeats"] = p.times.size();
  for (const auto& [clock, member] : {std::pair("gpu_ms", &TimeSample::gpu_ms),
                                      {"wall_ms", &TimeSample::wall_ms},
                                      {"cpu_ms", &TimeSample::cpu_ms}}) {
    const Spread s = spread(p, member);
    const std::string name = clock;
    row.update({{name + "_median", s.median},
                {name + "_lower", s.lower},
                {name + "_upper", s.upper},
                {name + "_min", s.min},
                {name + "_max", s.max}});
  }
  return row;
}

/// What is known of another renderer.
Json csv_row(const ForeignPoint& p) {
  Json error = json_of(p.error);
  error["rms"] = p.rms();
  if (p.opaque) error.erase("alpha");
  Json row = flat(error);
  row["renderer"] = p.picture.name;
  row["resolution"] = formatted("%dx%d", p.resolution.x, p.resolution.y);
  if (p.picture.time_ms > 0) row["wall_ms_median"] = p.picture.time_ms;
  return row;
}

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

/// Median over the points of the distance between a clock's quartiles, relative to its median.
double scatter(const StudyResults& results, double TimeSample::*clock) {
  std::vector<double> all;
  for (const StudyPoint& point : results.points)
    if (const Spread s = spread(point, clock); s.median > 0)
      all.push_back((s.upper - s.lower) / s.median);
  return spread_of(all).median;
}

}  // namespace

Json json_of(const StudyPoint& p) {
  Json j = json_of(p.variant);
  if (p.chosen) {
    j["chosen"] = json_of(*p.chosen);
    j["chosen"]["rms"] = p.estimate;
  }
  if (!p.same_as.empty()) j["same_as"] = p.same_as;
  j["error"] = json_of(p.error);
  j["step_error"] = json_of(p.step_error);
  j["arithmetic_error"] = json_of(p.arithmetic);
  j["samples_per_ray"] = p.samples_per_ray;
  j["steps_per_ray"] = p.steps_per_ray;
  j["atlas_bytes"] = p.atlas_bytes;
  j["difference_scale"] = p.difference_scale;
  j["times_ms"] = Json::array();
  for (const TimeSample& t : p.times)
    j["times_ms"].push_back({{"wall", t.wall_ms}, {"gpu", t.gpu_ms}, {"cpu", t.cpu_ms}});
  return j;
}

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

Scene scene_in(const StudyResults& results) {
  return scene_from_json(results.scene, "the study's scene");
}

std::string command_of(const StudyResults& results) {
  return render_command_line(scene_in(results), "picture.png");
}

std::string clock_note(const StudyResults& results) {
  // 5 % is less than a mark is wide
  constexpr double visible = 0.05, more = 2;
  const double wall = scatter(results, &TimeSample::wall_ms);
  const double processor = scatter(results, &TimeSample::cpu_ms);
  if (!is_software(results.renderer) || wall < visible || wall < more * processor) return "";
  return "The machine did other work: between repeats, wall times scatter by " +
         percent_text(wall) + " and processor times by " + percent_text(processor) +
         " (the distance of the quartiles over the median; half of the points have more). The "
         "draws are the processor's, so only its time is plotted.";
}

std::string reference_name(const Variant& variant) {
  if (variant.resolution.x == 0) return "reference";
  return "reference_" + parameter_text(scene_of(variant, {}), "resolution");
}

std::string results_json(const StudyResults& r) {
  Json out = {
      {"psivox_study", format_version},
      {"version", r.version},
      {"git", r.git},
      {"machine", {{"processor", r.processor}, {"threads", r.threads}, {"system", r.system}}},
      {"renderer", r.renderer},
      {"date", r.date},
      {"input", {{"file", r.input}, {"sha256", r.input_hash}}},
      {"scene", Json::parse(r.scene)},
      {"command", command_of(r)},
      {"reference", {{"error_bound", r.reference_bound}}},
      {"repeats", r.repeats}};
  out["conclusion"] = conclusion_json(r);
  out["clock_note"] = clock_note(r);
  out["rules"] = rules_json();
  out["skipped"] = Json::array();
  for (const SkippedVariant& s : r.skipped) {
    out["skipped"].push_back(json_of(s.variant));
    out["skipped"].back()["reason"] = s.reason;
  }
  out["points"] = Json::array();
  for (const StudyPoint& point : r.points) out["points"].push_back(json_of(point));
  out["foreign"] = Json::array();
  for (const ForeignPoint& point : r.foreign) out["foreign"].push_back(json_of(point));
  return json_text(out);
}

std::string results_csv(const StudyResults& results) {
  const Scene base = scene_in(results);
  std::vector<Json> rows;
  for (const StudyPoint& point : results.points) rows.push_back(csv_row(point, base));
  for (const ForeignPoint& point : results.foreign) rows.push_back(csv_row(point));
  return csv_text(rows, csv_head);
}

StudyResults results_from_json(std::string_view text, std::string_view source) {
  try {
    const Json j = shallow_json<Json>(text, std::string(source), ExitCode::input);
    if (j.at("psivox_study").get<int>() != format_version)
      throw Error(ExitCode::input, std::string(source) + ": results of another version of psivox");
    StudyResults r;
    r.version = j.at("version");
    r.git = j.at("git");
    r.processor = j.at("machine").at("processor");
    r.threads = j.at("machine").at("threads");
    r.system = j.at("machine").at("system");
    r.renderer = j.at("renderer");
    r.input = j.at("input").at("file");
    r.date = j.value("date", "");
    r.input_hash = j.at("input").value("sha256", "");
    if (!j.at("scene").is_object())
      throw Error(ExitCode::input,
                  std::string(source) + ": not the results of a study: it has no scene");
    r.scene = j.at("scene").dump();
    r.reference_bound = j.at("reference").at("error_bound");
    r.repeats = j.at("repeats");
    for (const Json& s : j.at("skipped"))
      r.skipped.push_back({variant_from(s), s.at("reason").get<std::string>()});
    for (const Json& p : j.at("points")) r.points.push_back(point_from(p));
    for (const Json& p : j.value("foreign", Json::array())) r.foreign.push_back(foreign_from(p));
    return r;
  } catch (const Json::exception& error) {
    throw Error(ExitCode::input,
                std::string(source) + ": not the results of a study: " + error.what());
  }
}

StudyResults read_results(const std::filesystem::path& folder) {
  const std::string path = (folder / results_name).string();
  return results_from_json(read_text(path, "study"), path);
}

std::string resume_obstacle(const StudyResults& begun, const StudyResults& next,
                            const StudyPlan& plan) {
  if (begun.version != next.version || begun.git != next.git)
    return "was made by psivox " + begun.version + " " + begun.git;
  if (begun.renderer != next.renderer) return "was made with " + begun.renderer;
  if (begun.input_hash != next.input_hash) return "is of another file, " + in_quotes(begun.input);
  const Json a = scene_without_input(begun.scene), b = scene_without_input(next.scene);
  for (const auto& [name, value] : b.items())
    if (!a.contains(name) || a.at(name) != value) return "has another --" + name;
  for (const StudyPoint& point : begun.points)
    if (!std::ranges::count(plan.variants, point.variant))
      return "has " + variant_name(point.variant) + ", which these options have not";
  return "";
}

}  // namespace psivox
