#include "view/volume.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/ext/matrix_transform.hpp>
#include <utility>

#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox::view {
namespace {

/// Parameters of the march that neither grids nor atlases depend on.
constexpr const char* march_only[] = {
    "slice",           "clip",         "clip-plane",   "lmip-threshold",
    "integrator",      "sampling",     "segments",     "step",
    "end-corrections", "connectivity", "opacity-unit", "early-termination",
    "filter",          "renderer",     "device",       "tolerance"};

bool belongs_to_volume(const Parameter& p) {
  if (p.group == ParameterGroup::camera || p.group == ParameterGroup::output) return false;
  return std::find(std::begin(march_only), std::end(march_only), p.name) == std::end(march_only);
}

/// Changes when the file does.
std::string stamp_of(const std::string& path) {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(path, missing);
  if (missing) return "-";
  return std::to_string(time.time_since_epoch().count());
}

void count(const Field& field, Histogram& histogram) {
  const auto each = [&](const auto& take) {
    for (const Leaf& leaf : field.leaves)
      for (int i = 0; i < 512; ++i)
        if (leaf.values[i] != 0) take(static_cast<double>(leaf.values[i]), 1.0);
    for (const Tile& tile : field.tiles)
      take(static_cast<double>(tile.value.x), std::pow(static_cast<double>(tile.width), 3.0));
  };
  double low = 0, high = 0;
  each([&](double value, double) {
    low = std::min(low, value);
    high = std::max(high, value);
  });
  histogram.min = low;
  histogram.max = high > low ? high : low + 1;
  const double bins = static_cast<double>(histogram.counts.size());
  const double scale = bins / (histogram.max - histogram.min);
  each([&](double value, double weight) {
    const auto bin = static_cast<std::size_t>(std::clamp((value - low) * scale, 0.0, bins - 1));
    histogram.counts[bin] += weight;
  });
}

/// The whole domain as make_view sees it.
Subject whole_box(const Scene& scene, const Volume& volume) {
  Field domain;
  domain.active_box = volume.fields.density->active_box;
  domain.world_from_index = volume.fields.density->world_from_index;
  if (scene.centering == Centering::cell)
    domain.world_from_index = glm::translate(domain.world_from_index, glm::dvec3(0.5));
  glm::dvec3 low, high;
  world_bounds(domain, low, high);
  Subject box = box_subject(low, high);
  box.z_up = volume.fields.z_up;
  return box;
}

/// Turns the camera's lights into the world's.
void keep_lights(const Camera& camera, Scene& scene) {
  for (DirectionalLight& light : scene.lights)
    if (std::exchange(light.of_camera, false))
      light.direction = from_camera(camera, light.direction);
}

void choose_look(Volume& volume, const VdbFile& file) {
  const std::string before = parameter_text(volume.scene, *find_parameter("light"));
  volume.look = with_look(volume.scene, file);
  volume.scene = volume.look->scene;
  if (parameter_text(volume.scene, *find_parameter("light")) != before)
    keep_lights(make_view(volume.scene, volume.look->fields).camera, volume.scene);
  volume.fields = std::move(volume.look->fields);
}

void read_file(Volume& volume, const StageProgress& progress) {
  const VdbFile file(volume.scene.input, [&](double fraction) { progress("reading", fraction); });
  volume.grids = file.names();
  if (asks_for_look(volume.scene))
    choose_look(volume, file);
  else
    volume.fields = read_fields(volume.scene, file);
  count(*volume.fields.density, volume.histogram);
}

void collect_notices(Volume& volume) {
  const MediumFields& fields = volume.fields;
  for (const auto& field :
       {fields.density, fields.luminance, fields.temperature, fields.emission}) {
    if (!field) continue;
    for (const std::string& notice : field->notices)
      if (std::find(volume.notices.begin(), volume.notices.end(), notice) == volume.notices.end())
        volume.notices.push_back(notice);
  }
}

}  // namespace

std::string volume_key(const Scene& scene, int generation) {
  std::string key = std::to_string(generation);
  for (const Parameter& p : parameters())
    if (belongs_to_volume(p)) key += "\n" + parameter_text(scene, p);
  if (!scene.transfer_function.empty()) key += "\n" + stamp_of(scene.transfer_function);
  // A rule that applies the function to values across bricks needs more of them.
  if (is_transfer_rule(scene.resolved_integrator()) && scene.resolved_sampling() != Sampling::cells)
    key += "\nevery value";
  return key;
}

bool asks_for_look(const Scene& scene) { return !scene.look.empty() && scene.look != "plain"; }

std::shared_ptr<Volume> prepare_volume(const Scene& scene, int generation,
                                       const std::shared_ptr<const Volume>& previous,
                                       const StageProgress& progress, const BoxKnown& box_known) {
  validate(scene);
  auto volume = std::make_shared<Volume>();
  volume->asked = volume->scene = scene;
  const std::string files = std::to_string(generation);
  progress("reading", 0);
  if (previous && !asks_for_look(scene) && previous->fields_key == files + fields_key(scene)) {
    volume->fields = previous->fields;
    volume->grids = previous->grids;
    volume->histogram = previous->histogram;
  } else {
    read_file(*volume, progress);
  }
  volume->key = volume_key(volume->scene, generation);
  volume->fields_key = files + fields_key(volume->scene);
  collect_notices(*volume);
  box_known(whole_box(volume->scene, *volume));
  progress("preparing", 0);
  volume->session = std::make_unique<Session>(make_view(volume->scene, volume->fields));
  volume->subject = volume->session->view().subject;
  volume->extinction = volume->session->view().medium.extinction;
  volume->function = volume->session->view().medium.transfer;
  progress("converting", 0);
  volume->session->convert();
  return volume;
}

Scene with_medium_of(const Volume& volume, const Scene& scene) {
  Scene mixed = volume.scene;
  for (const Parameter& p : parameters()) {
    if (belongs_to_volume(p)) continue;
    std::visit([&](auto member) { mixed.*member = scene.*member; }, p.member);
  }
  return mixed;
}

}  // namespace psivox::view
