#include "view/volume.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <regex>

#include "base/file_blocks.h"
#include "base/text.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/sequence.h"

namespace psivox::view {
namespace {

void count(const Field& field, Histogram& histogram) {
  const glm::dvec2 range = stored_range(field);
  histogram.min = range.x;
  histogram.max = range.y > range.x ? range.y : range.x + 1;
  const double bins = double(histogram.counts.size());
  const double scale = bins / (histogram.max - histogram.min);
  const auto take = [&](double value, double weight) {
    const double bin = std::clamp((value - histogram.min) * scale, 0.0, bins - 1);
    histogram.counts[std::size_t(bin)] += weight;
  };
  for (const Leaf& leaf : field.leaves) {
    const OrderedValues values(field, leaf);
    for (std::size_t i = 0; i < 512; ++i)
      if (is_active(values[i])) take(double(values[i]), 1);
  }
  for (const Tile& tile : field.tiles)
    if (is_active(tile.value.x)) take(double(tile.value.x), std::pow(double(tile.width), 3.0));
}

/// Turns lights that a look has set from the camera's into the world's.
void keep_lights(const Volume& volume, Scene& scene, OpenedScene& opened) {
  if (scene.lights == volume.asked.lights) return;
  for (DirectionalLight& light : scene.lights)
    if (std::exchange(light.of_camera, false))
      light.direction = from_camera(opened.view.camera, light.direction);
  opened.looked.scene.lights = scene.lights;
  opened = open_scene(opened.looked.scene, std::move(opened.looked.fields));
}

/// Whether frames of a sequence could differ in what `auto` chooses for them.
bool leaves_choices(const Scene& scene) {
  const auto percentile = [&] { return scene.range->percent != glm::bvec2(false); };
  return asks_for_look(scene) || (scene.attenuates() && !scene.extinction) ||
         (scene.windows() && (!scene.range || percentile())) ||
         (scene.shows(Shows::surface) && scene.isovalue.empty());
}

OpenedScene choose_look(Volume& volume, const VolumeFile& file) {
  OpenedScene opened = open_scene(volume.asked, file, {.open_look = "plain"});
  volume.chosen = opened.looked;
  volume.chosen->fields = {};
  Scene& scene = volume.chosen->scene;
  keep_lights(volume, scene, opened);
  volume.chosen_grids = chosen_grids(volume.asked, scene);
  return opened;
}

OpenedScene choose_for_sequence(Volume& volume, const std::vector<std::string>& samples,
                                const VolumeFile& file) {
  SequenceScene sequence =
      resolve_sequence(volume.asked, samples, "plain", true, samples, true, Headers::unread);
  volume.chosen_from = samples.size();
  volume.chosen_grids = sequence.chosen_grids;
  OpenedScene opened = open_frame(sequence, file, volume.asked.input);
  sequence.scene.input = volume.asked.input;
  keep_lights(volume, sequence.scene, opened);
  // a method is chosen for each picture
  std::erase_if(sequence.settings, [](const Setting& setting) {
    return find_parameter(setting.name)->group == ParameterGroup::accuracy;
  });
  volume.chosen = {std::move(sequence.scene), sequence.look, sequence.settings, {}, {}};
  return opened;
}

/// Shows a file in the scene of the frame before, without grids of its look that this file lacks.
/// `empty`: a frame without active voxels is an empty picture.
OpenedScene show_frame(Volume& volume, const std::vector<std::string>& chosen_grids, bool empty,
                       const VolumeFile& file) {
  SequenceScene sequence;
  sequence.scene = volume.asked;
  sequence.chosen_grids = volume.chosen_grids = chosen_grids;
  return open_frame(sequence, file, volume.asked.input, empty);
}

OpenedScene read_file(Volume& volume, const std::vector<std::string>& samples,
                      const std::vector<std::string>& chosen_grids, const StageProgress& progress) {
  const VolumeFile file(volume.asked.input,
                        [&](double fraction) { progress("reading", fraction); });
  volume.grids = file.names();
  if (!samples.empty() && leaves_choices(volume.asked)) {
    progress("choosing for the sequence", 0);
    return choose_for_sequence(volume, samples, file);
  }
  if (asks_for_look(volume.asked)) return choose_look(volume, file);
  return show_frame(volume, chosen_grids, !samples.empty(), file);
}

std::string function_stamp(const Scene& scene) {
  return scene.transfer_function.empty() ? "" : "\n" + file_stamp(scene.transfer_function);
}

std::string key_of(const Scene& scene, int generation, const std::string& stamp) {
  std::string key = std::to_string(generation);
  for (const Parameter& p : parameters())
    if (belongs_to_medium(p)) key += "\n" + parameter_text(scene, p);
  key += stamp;
  return key;
}

/// With three digits of each number, for a person.
std::string shortened(const std::string& options) {
  static const std::regex number(R"(\d+\.\d{3,}(e[+-]?\d+)?)");
  std::string text;
  auto at = options.cbegin();
  for (std::sregex_iterator i(options.cbegin(), options.cend(), number), end; i != end; ++i) {
    text.append(at, (*i)[0].first);
    text += formatted("%.3g", std::stod(i->str()));
    at = (*i)[0].second;
  }
  return text.append(at, options.cend());
}

}  // namespace

double Volume::value_at(const glm::dvec3& point) const {
  const Field& field = *fields.density;
  if (!index_) index_ = std::make_unique<const FieldIndex>(field);
  const glm::dvec3 at(glm::inverse(field.world_from_index) * glm::dvec4(point, 1));
  const double value = index_->at(at).x;
  return field.half_width > 0 ? field.half_width - value : field.scale.value_of(value);
}

std::string volume_key(const Scene& scene, int generation) {
  return key_of(scene, generation, function_stamp(scene));
}

bool asks_for_look(const Scene& scene) { return !scene.look.empty() && scene.look != "plain"; }

std::shared_ptr<Volume> prepare_volume(const Scene& scene, const std::vector<std::string>& samples,
                                       int generation,
                                       const std::shared_ptr<const Volume>& previous,
                                       const StageProgress& progress,
                                       const SubjectKnown& subject_known) {
  validate(scene);
  auto volume = std::make_shared<Volume>();
  volume->asked = scene;
  // Before the function is read: a hand may write it meanwhile, and a key must not be newer than
  // what it stands for.
  const std::string stamp = function_stamp(scene);
  const std::string files = std::to_string(generation);
  progress("reading", 0);
  const bool open = asks_for_look(scene) || (!samples.empty() && leaves_choices(scene));
  OpenedScene opened;
  if (previous && !open && previous->fields_key == files + fields_key(scene)) {
    opened = open_scene(scene, previous->fields);
    volume->grids = previous->grids;
    volume->histogram = previous->histogram;
    volume->chosen_grids = previous->chosen_grids;
  } else {
    opened = read_file(*volume, samples,
                       previous ? previous->chosen_grids : std::vector<std::string>(), progress);
    count(*opened.looked.fields.density, volume->histogram);
  }
  volume->scene = std::move(opened.looked.scene);
  volume->fields = std::move(opened.looked.fields);
  const Scene& shown = volume->chosen ? volume->chosen->scene : scene;
  volume->key = shown.transfer_function == scene.transfer_function
                    ? key_of(shown, generation, stamp)
                    : volume_key(shown, generation);  // its look brings its own
  volume->fields_key = files + fields_key(volume->scene);
  volume->notices = notices_of(opened.view);
  volume->resolved = opened.view.scene;
  volume->subject = opened.view.subject;
  volume->extinction = opened.view.medium.extinction;
  volume->function = opened.view.medium.transfer;
  volume->colors = color_scale(opened.view);
  subject_known(volume->subject);
  volume->session = std::make_unique<Session>(std::move(opened.view));
  progress("converting", 0);
  volume->session->convert();
  return volume;
}

Scene with_medium_of(const Volume& volume, const Scene& scene) {
  Scene mixed = volume.scene;
  for (const Parameter& p : parameters())
    if (!belongs_to_medium(p)) copy_parameter(scene, mixed, p);
  return mixed;
}

LookChoice::LookChoice(const Scene& start)
    : start_(leaves_look_open(start) ? "auto" : start.look), name_(start_) {}

void LookChoice::ask(const std::string& name, Scene& scene, bool camera_too) {
  for (const std::string& set : std::exchange(set_, {})) {
    const Parameter& p = *find_parameter(set);
    if ((camera_too || p.group != ParameterGroup::camera) && has_same(scene, set_scene_, p))
      set_default(scene, p);
  }
  name_ = name;
  chosen_.clear();
  scene.look = name;
}

std::string LookChoice::take(const Volume& volume, Scene& scene) {
  if (!volume.chosen) return {};
  const LookedScene& chosen = *volume.chosen;
  const bool asked = asks_for_look(scene);
  if (asked) scene.look = chosen.scene.look;
  set_.clear();
  set_scene_ = chosen.scene;
  std::string options;
  for (const Setting& setting : chosen.settings) {
    const Parameter& p = *find_parameter(setting.name);
    if (p.group != ParameterGroup::camera) options += " --" + setting.name + "=" + setting.text;
    if (!has_same(scene, volume.asked, p)) continue;
    copy_parameter(chosen.scene, scene, p);
    set_.push_back(setting.name);
  }
  if (asked) chosen_ = chosen.look;
  std::string how;
  if (asked && name_ == "auto") how += " by auto";
  if (volume.chosen_from > 1) how += " from " + std::to_string(volume.chosen_from) + " frames";
  std::string text = asked ? "look " + chosen.look : "chosen" + how;
  if (asked && !how.empty()) text += ", chosen" + how;
  return text + ":" + (options.empty() ? " nothing to set" : shortened(options));
}

void LookChoice::hold(const Volume& volume, Scene& scene) {
  for (const Parameter& p : parameters()) {
    const bool part = p.group == ParameterGroup::look || p.group == ParameterGroup::light;
    // grids of a look may be missing in one frame and come again
    if (!part || p.name == "look" || names_side_grid(p) || has_same(scene, volume.resolved, p))
      continue;
    copy_parameter(volume.resolved, scene, p);
    copy_parameter(volume.resolved, set_scene_, p);
    set_.push_back(p.name);
  }
}

std::string LookChoice::text() const {
  if (name_.empty()) return "plain";
  return chosen_.empty() || chosen_ == name_ ? name_ : name_ + ": " + chosen_;
}

}  // namespace psivox::view
