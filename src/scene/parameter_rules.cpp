// Rules across parameters; what a method sets.

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/scene.h"
#include "scene/cuts.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

[[noreturn]] void contradict(const std::string& message) { throw Error(ExitCode::usage, message); }

bool contains(std::span<const Setting> settings, std::string_view name) {
  return std::ranges::count(settings, name, &Setting::name) > 0;
}

void clear(Scene& scene, std::string_view name) { set_default(scene, *find_parameter(name)); }

/// The file's range and curve stay unless what they belong to is replaced: `before` is the scene of
/// the file.
void apply_window(Scene& scene, const Scene& before, std::span<const Setting> settings) {
  const bool function = contains(settings, "transfer-function") && !scene.transfer_function.empty();
  const bool map_gone = before.colormap && !scene.colormap;
  const bool other_mode = before.shows(Shows::value) != scene.shows(Shows::value);
  if ((function || map_gone || other_mode) && !contains(settings, "range")) clear(scene, "range");
  if (function && !contains(settings, "opacity")) clear(scene, "opacity");
  const bool window = (contains(settings, "range") && scene.range) ||
                      (contains(settings, "opacity") && scene.opacity);
  if (window && !contains(settings, "transfer-function")) clear(scene, "transfer-function");
  if (scene.has_function()) return;
  if (!contains(settings, "classification")) scene.classification = Classification::post;
  if (!contains(settings, "split-knots")) scene.split_knots = false;
}

/// A source of luminance on the command line replaces the file's source.
void apply_luminance(Scene& scene, std::span<const Setting> settings) {
  const auto given = [&](const char* name) { return contains(settings, name); };
  const bool function = given("transfer-function") && !scene.transfer_function.empty();
  const bool map = given("colormap") && scene.colormap;
  const bool grid = given("luminance-grid") && !scene.luminance_grid.empty();
  const bool temperature = given("temperature-grid") && !scene.temperature_grid.empty();
  if (map && !given("transfer-function")) clear(scene, "transfer-function");
  if ((function || grid || temperature) && !given("colormap")) clear(scene, "colormap");
  if ((map || temperature) && !given("luminance-grid")) clear(scene, "luminance-grid");
  if ((map || grid) && !given("temperature-grid")) clear(scene, "temperature-grid");
}

void apply_sampling(Scene& scene, std::span<const Setting> settings) {
  const auto given = [&](const char* name) { return contains(settings, name); };
  const bool perspective = scene.projection == Projection::perspective;
  if (scene.sampling == Sampling::template_ && perspective && !given("sampling"))
    scene.sampling.reset();
  if (scene.shows(Shows::surface) && given("mode") && !given("sampling") && !given("step")) {
    scene.sampling.reset();
    scene.step.reset();
  }
  if (scene.sampling && scene.sampling != Sampling::uniform && !given("step")) scene.step.reset();
  if (scene.sampling != Sampling::template_ && !given("connectivity"))
    scene.connectivity = Scene{}.connectivity;
  if (perspective && !given("ortho-width")) scene.ortho_width.reset();
}

/// Whether an error is estimated with the parameter's value: float32 is what codes fall back on.
bool goes_with_tolerance(const Scene& scene, const Parameter& p) {
  return p.under_tolerance == UnderTolerance::free || has_default(scene, p) ||
         (p.name == "texel" && scene.texel == TexelType::float32);
}

/// A given tolerance replaces the method of the file, and a given method its tolerance.
void apply_tolerance(Scene& scene, std::span<const Setting> settings) {
  const bool tolerance_given = contains(settings, "tolerance");
  for (const Parameter& p : parameters()) {
    if (p.under_tolerance == UnderTolerance::free) continue;
    const bool given = contains(settings, p.name);
    if (tolerance_given && scene.tolerance && !given) set_default(scene, p);
    if (!tolerance_given && given && !goes_with_tolerance(scene, p)) scene.tolerance.reset();
  }
}

/// The other modes with an option of their own.
std::vector<const ModeInfo*> others_with_option(Mode mode) {
  std::vector<const ModeInfo*> others;
  for (const ModeInfo& other : mode_rows)
    if (other.id != mode && *other.option) others.push_back(&other);
  return others;
}

/// An option of one mode is not given with another.
void validate_mode(const Scene& scene) {
  for (const ModeInfo* other : others_with_option(scene.mode))
    if (!has_default(scene, *find_parameter(other->option)))
      contradict("--" + std::string(other->option) + " is for --mode " + other->name +
                 "; give both or neither");
}

void validate_light(const Scene& scene) {
  for (const DirectionalLight& light : scene.lights)
    if (!has_direction(light.direction)) contradict("--light has no direction: it is 0");
  if (!scene.environment.empty() && scene.sky)
    contradict("--environment and --sky exclude each other; leave one of them out");
  if (!scene.environment.empty()) return;
  if (scene.environment_rotation != 0 || scene.environment_scale != 1)
    contradict("--environment-rotation and --environment-scale are of --environment; give it too");
  if (scene.background && scene.background->environment)
    contradict("--background environment shows the map of --environment; give it too");
}

void validate_fill(const Scene& scene) {
  const std::string& text = scene.fill_value;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool number = !text.empty() && *end == '\0' && std::isfinite(value);
  if (!number && text != "auto" && text != "none")
    contradict("--fill-value " + in_quotes(text) + ": expected a number, auto or none");
}

void validate_medium(const Scene& scene) {
  validate_fill(scene);
  if (!scene.transfer_function.empty() && scene.colormap)
    contradict("--transfer-function and --colormap exclude each other; leave one of them out");
  if (!scene.transfer_function.empty() && (scene.range || scene.opacity))
    contradict("--transfer-function has values of its own; leave out --range and --opacity");
  if (scene.range && scene.range->percent.x == scene.range->percent.y &&
      !(scene.range->ends.x < scene.range->ends.y))
    contradict("--range MIN,MAX: MIN must be below MAX");
  if (!scene.has_function()) {
    if (scene.classification == Classification::pre)
      contradict(
          "--classification pre needs a function; give --transfer-function, --colormap or "
          "--opacity");
    if (scene.split_knots)
      contradict("--split-knots needs a function; give --transfer-function or --colormap");
  }
  if (!scene.luminance_grid.empty() && !scene.temperature_grid.empty())
    contradict("--luminance-grid and --temperature-grid exclude each other; leave one of them out");
  if (scene.colormap && !scene.luminance_grid.empty())
    contradict("--colormap and --luminance-grid exclude each other; leave one of them out");
  if (scene.colormap && !scene.temperature_grid.empty())
    contradict("--colormap and --temperature-grid exclude each other; leave one of them out");
  if (scene.classification == Classification::pre && !scene.attenuates())
    contradict("--classification pre is for --mode alpha, back-to-front and xray");
  validate_light(scene);
}

void validate_march(const Scene& scene) {
  if (scene.shows(Shows::surface) && scene.resolved_sampling() != Sampling::cells)
    contradict(
        "--mode isosurface finds its surface in cells; it goes with --sampling cells, without "
        "--step");
  if (scene.step && scene.sampling == Sampling::cells)
    contradict("--step is for --sampling uniform, not cells; leave one of them out");
  if (scene.step && scene.sampling == Sampling::template_)
    contradict("--step is for --sampling uniform, not template; leave one of them out");
  if (scene.tolerance) check_method_unset(scene, "--tolerance");
  if (scene.sampling == Sampling::template_ && scene.projection != Projection::orthographic)
    contradict("--sampling template needs parallel rays; give --projection orthographic with it");
  if (has_codes(scene.texel) && scene.filter == Filter::hardware)
    contradict(
        "--texel code7, code12 and code16 are decoded by the march; leave out --filter hardware");
  if (has_codes(scene.texel) && scene.sampling == Sampling::template_)
    contradict(
        "--texel code7, code12 and code16 have cells, not voxels; leave out --sampling template");
  if (has_codes(scene.texel) && scene.shows(Shows::surface))
    contradict(
        "--mode isosurface needs bricks that agree at their faces; leave out --texel code...");
  if (scene.connectivity != 6 && scene.connectivity != 18 && scene.connectivity != 26)
    contradict("--connectivity is 6, 18 or 26");
  if (scene.connectivity != 26 && scene.sampling != Sampling::template_)
    contradict("--connectivity is for --sampling template; give both or neither");
  if (scene.integrator && is_cell_rule(*scene.integrator) &&
      scene.resolved_sampling() != Sampling::cells)
    contradict(
        "--integrator cell-exact integrates cells; it goes with --sampling cells, without --step");
  if (scene.integrator && is_transfer_rule(*scene.integrator) && !scene.has_function())
    contradict("--integrator " + parameter_text(scene, "integrator") +
               " integrates a transfer function; give --transfer-function or --colormap");
}

void validate_cuts(const Scene& scene) {
  if (scene.slice && !has_direction(scene.slice->normal)) contradict("--slice: its normal is 0");
  if (scene.clip_plane && !has_direction(scene.clip_plane->normal))
    contradict("--clip-plane: its normal is 0");
  if (scene.clip)
    for (int axis = 0; axis < 3; ++axis)
      if (!(scene.clip->min[axis] < scene.clip->max[axis]))
        contradict("--clip X0,Y0,Z0,X1,Y1,Z1: the first three must be below the last three");
  if ((scene.clip || scene.clip_plane || !scene.holdout.empty()) &&
      scene.sampling == Sampling::template_)
    contradict(
        "--sampling template marches whole rays; leave out --clip, --clip-plane and --holdout");
  if (scene.holdout_depth != DepthKind::z && scene.holdout.empty())
    contradict("--holdout-depth tells what the depths of --holdout are; give both or neither");
}

/// A view of OpenColorIO has a curve of its own: the later one of it and a tone map counts.
void apply_display(Scene& scene, std::span<const Setting> settings) {
  constexpr const char* view[] = {"ocio", "ocio-display", "ocio-view", "ocio-space"};
  const bool tone_map = contains(settings, "tone-map");
  if (std::ranges::any_of(view, [&](const char* name) { return contains(settings, name); })) {
    if (!tone_map) clear(scene, "tone-map");
  } else if (tone_map) {
    for (const char* const name : view) clear(scene, name);
  }
}

/// A ray's integral has no white: its exposure is auto unless it is given.
void apply_exposure(Scene& scene, const Scene& before, std::span<const Setting> settings) {
  const bool integral = scene.shows(Shows::depth);
  if (integral == before.shows(Shows::depth) || contains(settings, "exposure")) return;
  clear(scene, "exposure");
  if (integral) scene.exposure.reset();
}

}  // namespace

std::vector<Setting> changed_settings(const Scene& from, const Scene& to) {
  std::vector<Setting> settings;
  for (const Parameter& p : parameters()) {
    const std::string text = parameter_text(to, p);
    if (p.name != "look" && text != parameter_text(from, p)) settings.push_back({p.name, text});
  }
  return settings;
}

void apply_over(Scene& scene, std::span<const Setting> settings) {
  if (contains(settings, "step") && !contains(settings, "sampling")) scene.sampling.reset();
  // a look on the command line completes the file's scene, which names every parameter
  if (contains(settings, "look")) scene.given.clear();
  const Scene before = scene;
  for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
  apply_luminance(scene, settings);
  apply_window(scene, before, settings);
  apply_sampling(scene, settings);
  apply_tolerance(scene, settings);
  apply_exposure(scene, before, settings);
  apply_display(scene, settings);
  for (const ModeInfo* other : others_with_option(scene.mode))
    if (!contains(settings, other->option)) clear(scene, other->option);
  const bool lens = contains(settings, "focal-length") || contains(settings, "aperture");
  if (lens && !contains(settings, "fov")) scene.fov.reset();
}

bool leaves_method_open(const Scene& scene) {
  if (scene.tolerance || scene.renderer == RendererKind::reference) return false;
  return std::ranges::all_of(parameters(),
                             [&](const Parameter& p) { return goes_with_tolerance(scene, p); });
}

Scene with_default_tolerance(Scene scene) {
  if (leaves_method_open(scene)) scene.tolerance = default_tolerance;
  return scene;
}

void check_method_unset(const Scene& scene, std::string_view chooser) {
  for (const Parameter& p : parameters()) {
    if (goes_with_tolerance(scene, p)) continue;
    const std::string option = "--" + p.name, who(chooser);
    if (p.under_tolerance == UnderTolerance::chosen)
      contradict(who + " chooses " + option + " itself; leave one of them out");
    contradict(who + " needs " + option + " " + p.default_text +
               ": it does not estimate the error of " + option + " " + parameter_text(scene, p));
  }
}

bool belongs_to_medium(const Parameter& parameter) {
  return !parameter.march_only && parameter.group != ParameterGroup::camera &&
         parameter.group != ParameterGroup::output;
}

void validate(const Scene& scene) {
  validate_medium(scene);
  validate_mode(scene);
  validate_march(scene);
  validate_cuts(scene);
  validate_volumes(scene);
  if (scene.tone_map != ToneMap::none && scene.uses_ocio())
    contradict("--tone-map and the --ocio options exclude each other; leave one of them out");
  if (scene.ortho_width && scene.projection == Projection::perspective)
    contradict("--ortho-width is for --projection orthographic; a perspective view has --fov");
  if (scene.camera_up && !has_direction(*scene.camera_up))
    contradict("--camera-up has no direction: it is 0");
  if (scene.camera_position && scene.camera_position == scene.camera_target)
    contradict("--camera-position and --camera-target are the same point; move one of them");
}

std::string method_text(const Method& method) {
  const std::string rule = enum_names(Integrator{})[std::size_t(method.integrator)];
  if (method.sampling == Sampling::uniform)
    return formatted("uniform %s, step %.3g", rule.c_str(), method.step);
  if (is_cell_rule(method.integrator)) return "cells " + rule;
  return formatted("cells %s, segments %d", rule.c_str(), method.segments);
}

Scene with_method(Scene scene, const Method& method) {
  scene.tolerance.reset();
  scene.sampling = method.sampling;
  scene.integrator = method.integrator;
  scene.segments = method.segments > 0 ? method.segments : Scene{}.segments;
  scene.step.reset();
  if (method.step > 0) scene.step = method.step;
  return scene;
}

}  // namespace psivox
