#include "view/volume.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/ext/matrix_transform.hpp>
#include <utility>

#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "psivox/parameters.h"
#include "psivox/sequence.h"

namespace psivox::view {
namespace {

/// Changes when the file does.
std::string stamp_of(const std::string& path) {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(path, missing);
  if (missing) return "-";
  return std::to_string(time.time_since_epoch().count());
}

void count(const Field& field, Histogram& histogram) {
  const auto each = [&](const auto& take) {
    for (const Leaf& leaf : field.leaves) {
      const OrderedValues values(field, leaf);
      for (std::size_t i = 0; i < 512; ++i)
        if (values[i] != 0) take(static_cast<double>(values[i]), 1.0);
    }
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

/// Whether frames of a sequence could differ in what `auto` chooses for them.
bool leaves_choices(const Scene& scene) {
  const auto percentile = [&] { return scene.range->percent != glm::bvec2(false); };
  return asks_for_look(scene) || (scene.attenuates() && !scene.extinction) ||
         (scene.windows() && (!scene.range || percentile())) ||
         (scene.shows(Shows::surface) && !scene.isovalue);
}

/// The camera of a file for a scene.
Camera camera_of(const Scene& scene, const MediumFields& fields) {
  return make_view(scene, fields).camera;
}

void choose_look(Volume& volume, const VdbFile& file) {
  volume.chosen = with_look(volume.asked, file);
  volume.fields = std::exchange(volume.chosen->fields, {});
  if (volume.chosen->scene.lights != volume.asked.lights)
    keep_lights(camera_of(volume.chosen->scene, volume.fields), volume.chosen->scene);
  volume.scene = volume.chosen->scene;
  if (volume.asked.emission_grid.empty() && !volume.scene.emission_grid.empty())
    volume.chosen_grids.push_back(volume.scene.emission_grid);
}

void choose_for_sequence(Volume& volume, const std::vector<std::string>& samples,
                         const VdbFile& file) {
  SequenceScene sequence = resolve_sequence(volume.asked, samples);
  volume.chosen_from = samples.size();
  volume.chosen_grids = sequence.chosen_grids;
  volume.scene = frame_scene(sequence, file, volume.asked.input);
  volume.fields = read_fields(volume.scene, file, true);
  sequence.scene.input = volume.asked.input;
  if (sequence.scene.lights != volume.asked.lights) {
    keep_lights(camera_of(volume.scene, volume.fields), sequence.scene);
    volume.scene.lights = sequence.scene.lights;
  }
  // a method is chosen for each picture
  std::erase_if(sequence.settings, [](const Setting& setting) {
    return find_parameter(setting.name)->group == ParameterGroup::accuracy;
  });
  sequence.scene.look = "plain";
  volume.scene.look = "plain";
  volume.chosen = {std::move(sequence.scene), sequence.look, sequence.settings, {}, {}};
}

/// As the frame before was shown, without grids of its look that this file lacks. `empty`: a frame
/// without active voxels is an empty picture.
void show_frame(Volume& volume, const std::vector<std::string>& chosen_grids, bool empty,
                const VdbFile& file) {
  SequenceScene sequence;
  sequence.scene = volume.asked;
  sequence.chosen_grids = volume.chosen_grids = chosen_grids;
  volume.scene = frame_scene(sequence, file, volume.asked.input);
  volume.fields = read_fields(volume.scene, file, empty);
}

void read_file(Volume& volume, const std::vector<std::string>& samples,
               const std::vector<std::string>& chosen_grids, const StageProgress& progress) {
  const VdbFile file(volume.asked.input, [&](double fraction) { progress("reading", fraction); });
  volume.grids = file.names();
  if (!samples.empty() && leaves_choices(volume.asked)) {
    progress("choosing for the sequence", 0);
    choose_for_sequence(volume, samples, file);
  } else if (asks_for_look(volume.asked)) {
    choose_look(volume, file);
  } else {
    show_frame(volume, chosen_grids, !samples.empty(), file);
  }
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
    if (belongs_to_medium(p)) key += "\n" + parameter_text(scene, p);
  if (!scene.transfer_function.empty()) key += "\n" + stamp_of(scene.transfer_function);
  // A rule that applies the function to values across bricks needs more of them.
  if (is_transfer_rule(scene.resolved_integrator()) && scene.resolved_sampling() != Sampling::cells)
    key += "\nevery value";
  return key;
}

bool asks_for_look(const Scene& scene) { return !scene.look.empty() && scene.look != "plain"; }

std::shared_ptr<Volume> prepare_volume(const Scene& scene, const std::vector<std::string>& samples,
                                       int generation,
                                       const std::shared_ptr<const Volume>& previous,
                                       const StageProgress& progress, const BoxKnown& box_known) {
  validate(scene);
  auto volume = std::make_shared<Volume>();
  volume->asked = volume->scene = scene;
  const std::string files = std::to_string(generation);
  progress("reading", 0);
  const bool open = asks_for_look(scene) || (!samples.empty() && leaves_choices(scene));
  if (previous && !open && previous->fields_key == files + fields_key(scene)) {
    volume->fields = previous->fields;
    volume->grids = previous->grids;
    volume->histogram = previous->histogram;
    volume->chosen_grids = previous->chosen_grids;
  } else {
    read_file(*volume, samples, previous ? previous->chosen_grids : std::vector<std::string>(),
              progress);
  }
  volume->key = volume_key(volume->chosen ? volume->chosen->scene : scene, generation);
  volume->fields_key = files + fields_key(volume->scene);
  collect_notices(*volume);
  box_known(whole_box(volume->scene, *volume));
  progress("preparing", 0);
  volume->session = std::make_unique<Session>(make_view(volume->scene, volume->fields));
  volume->resolved = volume->session->view().scene;
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
    if (belongs_to_medium(p)) continue;
    std::visit([&](auto member) { mixed.*member = scene.*member; }, p.member);
  }
  return mixed;
}

}  // namespace psivox::view
