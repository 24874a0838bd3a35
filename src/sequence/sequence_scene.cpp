#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "look/voxel_lines.h"
#include "psivox/error.h"
#include "psivox/sequence.h"
#include "scene/cuts.h"
#include "sequence/film_places.h"
#include "vdb/grid_names.h"

namespace psivox {
namespace {

/// What `auto` chooses for one file.
struct Sample {
  LookedScene looked;  ///< without its fields
  Scene scene;         ///< resolved
  std::shared_ptr<const Subject> subject;
  bool dark = false;  ///< the density is 0 everywhere: its extinction means nothing
};

/// Whether a file has the side grid that an option of the scene names.
bool has_grid(const VolumeFile& file, const Scene& scene, const std::string& option) {
  return !albedo_grids(file, parameter_text(scene, option)).empty();
}

/// The options of side grids that the scene names and one of the files has.
std::vector<std::string> named_grids(const Scene& scene, std::span<const std::string> paths) {
  std::vector<std::string> options;
  for (const Parameter& p : parameters())
    if (names_side_grid(p) && !has_default(scene, p) &&
        std::ranges::any_of(paths, [&](const std::string& path) {
          return has_grid(VolumeFile(path), scene, p.name);
        }))
      options.push_back(p.name);
  return options;
}

/// The scene for a file of the sequence: placed in the domain of all, with the files of that frame
/// as further volumes, and without those of the side grids that the file lacks.
Scene scene_for(Scene scene, const VolumeFile& file, const std::string& path,
                std::span<const std::string> side_grids,
                const std::optional<AdaptiveDomain>& adaptive) {
  if (adaptive) scene = adaptive->placed(std::move(scene), density_place(scene, file));
  for (const std::string& option : side_grids)
    if (!has_grid(file, scene, option)) {
      file.check_whole();
      set_default(scene, *find_parameter(option));
    }
  if (const std::optional<FrameNumber> number = frame_number(scene.input, path))
    for (std::string& volume : scene.volumes) {
      const std::string name = scene_of_volume(scene, volume).input;
      if (const auto pattern = FramePattern::of_placeholder(name))
        volume = pattern->path(*number) + volume.substr(name.size());
    }
  scene.input = path;
  return scene;
}

struct SampleOptions {
  std::string open_look;
  bool background = true;
  std::vector<std::string> side_grids;  ///< see named_grids()
  std::optional<AdaptiveDomain> adaptive;
};

Sample sample_of(const Scene& scene, const std::string& path, const SampleOptions& options) {
  const VolumeFile file(path);
  const Scene own = scene_for(scene, file, path, options.side_grids, options.adaptive);
  auto [looked, view] = open_scene(own, file, {options.open_look, options.background});
  // with what their looks have added, but as the sequence names them
  for (Scene* const resolved : {&looked.scene, &view.scene})
    for (std::size_t i = 0; i < own.volumes.size(); ++i)
      resolved->volumes[i].replace(0, own.volumes[i].size(), scene.volumes[i]);
  for (Scene* const resolved : {&looked.scene, &view.scene}) {
    resolved->scale = scene.scale;
    resolved->translate = scene.translate;
  }
  const bool dark = looked.fields.density->stored_range == glm::vec2(0);
  looked.fields = {};
  return {std::move(looked), std::move(view.scene), std::move(view.subject), dark};
}

/// The most frequent name, of equals the later; `first` if it is among them.
std::string common_name(const std::vector<std::string>& names, const std::string& first) {
  std::string best;
  for (const std::string& name : names) {
    if (name == first) return first;
    if (best.empty() || std::ranges::count(names, name) >= std::ranges::count(names, best))
      best = name;
  }
  return best;
}

/// `fire` if any frame burns, else the most frequent look.
std::string common_look(const std::vector<Sample>& samples) {
  std::vector<std::string> looks;
  for (const Sample& sample : samples) looks.push_back(sample.looked.look);
  return common_name(looks, "fire");
}

/// The grid of all frames. A frame in which it is empty shows nothing of it.
std::string common_grid(std::span<const std::string> paths) {
  std::vector<std::string> grids;
  for (const std::string& path : paths)
    if (const VolumeFile file(path); !file.names().empty())
      grids.push_back(file.default_grid(/*empty=*/true));
  if (std::ranges::any_of(grids, says_density))
    std::erase_if(grids, [](const std::string& grid) { return !says_density(grid); });
  return common_name(grids, "density");
}

double extinction_of(const Sample& sample) { return sample.scene.extinction.value_or(1); }

/// Ascending from dense to thin.
double thinness(const Sample& sample) {
  return sample.dark ? std::numeric_limits<double>::infinity() : extinction_of(sample);
}

const Sample& densest(const std::vector<Sample>& samples) {
  return *std::ranges::min_element(samples, {}, thinness);
}

/// Radiance that light and luminance give to the medium, over all channels.
double brightness(const Scene& scene) {
  const auto sum = [](const glm::dvec3& v) { return v.x + v.y + v.z; };
  double all =
      sum(scene.luminance.value_or(glm::dvec3(0))) + sum(scene.sky.value_or(glm::dvec3(0)));
  for (const DirectionalLight& light : scene.lights) all += sum(light.color);
  return all;
}

void take_range(const std::vector<Sample>& samples, Scene& scene) {
  for (const Sample& sample : samples) {
    if (!sample.scene.range) continue;
    const glm::dvec2 ends = sample.scene.range->ends;
    if (!scene.range || scene.range->percent != glm::bvec2(false)) scene.range = ends;
    scene.range->ends = {std::min(scene.range->ends.x, ends.x),
                         std::max(scene.range->ends.y, ends.y)};
  }
}

/// The sample that has the grid and the least number; null if none has the grid.
template <typename Number>
const Sample* least_emission(const std::vector<Sample>& samples, const EmissionOptions& emission,
                             const Number& number) {
  const Sample* least = nullptr;
  for (const Sample& sample : samples) {
    if ((sample.looked.scene.*emission.grid).empty()) continue;
    if (!least || number(sample) < number(*least)) least = &sample;
  }
  return least;
}

void take_temperatures(const std::vector<Sample>& samples, Scene& scene) {
  for (const EmissionOptions& emission : emission_options) {
    const Sample* hottest = least_emission(
        samples, emission, [](const Sample& s) { return s.looked.scene.temperature_scale; });
    if (!hottest) continue;
    scene.temperature_scale = hottest->looked.scene.temperature_scale;
    scene.temperature_offset = hottest->looked.scene.temperature_offset;
    return;
  }
}

void take_brightness(const std::vector<Sample>& samples, Scene& scene) {
  const Scene& least = std::ranges::min_element(samples, {}, [](const Sample& sample) {
                         return brightness(sample.scene);
                       })->scene;
  scene.lights = least.lights;
  scene.luminance = least.luminance;
  scene.sky = least.sky;
  for (const EmissionOptions& emission : emission_options) {
    const Sample* dimmest =
        least_emission(samples, emission, [&](const Sample& s) { return s.scene.*emission.scale; });
    if (!dimmest) continue;
    scene.*emission.grid = dimmest->scene.*emission.grid;
    scene.*emission.color = dimmest->scene.*emission.color;
    scene.*emission.scale = dimmest->scene.*emission.scale;
  }
}

Subject all_subjects(const std::vector<Sample>& samples) {
  Subject all;
  for (const Sample& sample : samples) add_subject(*sample.subject, all);
  return all;
}

/// Active voxels of a file's density; unset if the file cannot be read whole.
std::optional<std::uint64_t> active_voxels(Scene scene, const std::string& path) {
  try {
    scene.input = path;
    const VolumeFile file(path);
    file.check_whole();
    return read_fields(scene, file, true).density->active_voxels;
  } catch (const Error& error) {
    if (error.code() != ExitCode::input) throw;
    return {};
  }
}

/// Of all files the nearest to one that serves, perhaps that one; empty if none does.
template <typename Serves>
std::string nearest(std::span<const std::string> all, const std::string& path,
                    const Serves& serves) {
  std::vector<std::string> near(all.begin(), all.end());
  const auto place = [&](const std::string& file) { return std::ranges::find(all, file); };
  std::ranges::stable_sort(
      near, {}, [&](const std::string& other) { return std::abs(place(other) - place(path)); });
  const auto first = std::ranges::find_if(near, serves);
  return first == near.end() ? std::string() : *first;
}

/// The files, or in place of one that cannot be read the nearest that can, if there is one.
std::vector<std::string> readable(const Scene& scene, std::span<const std::string> paths,
                                  std::span<const std::string> all) {
  std::vector<std::string> found;
  for (const std::string& path : paths) {
    std::string chosen = nearest(all, path, [&](const std::string& other) {
      return active_voxels(scene, other).has_value();
    });
    if (chosen.empty()) chosen = path;
    if (!std::ranges::count(found, chosen)) found.push_back(chosen);
  }
  return found;
}

/// A sample of each file, or in place of one that is empty of the nearest that is not; of one file,
/// if the scene leaves nothing open.
std::vector<Sample> samples_of(const Scene& scene, std::vector<std::string>& paths,
                               std::span<const std::string> all, const SampleOptions& options) {
  std::vector<Sample> samples;
  const auto is_full = [&](const std::string& path) {
    return active_voxels(scene, path).value_or(0) > 0;
  };
  for (std::string& path : paths) {
    try {
      samples.push_back(sample_of(scene, path, options));
    } catch (const Error& error) {
      if (error.code() != ExitCode::input || active_voxels(scene, path) != 0) throw;
      const std::string full = nearest(all, path, is_full);
      if (!full.empty() && !std::ranges::count(paths, full)) {
        samples.push_back(sample_of(scene, path = full, options));
      } else {
        if (samples.empty() && &path == &paths.back()) throw;
        continue;
      }
    }
    Scene resolved = samples.back().scene;
    resolved.input = scene.input;
    if (to_json(resolved) == to_json(scene)) break;
  }
  return samples;
}

/// The least exposure that suits a file with light; 0 if none has any.
double least_exposure(const SequenceScene& sequence, std::span<const std::string> paths) {
  std::optional<double> least;
  for (const std::string& path : paths) {
    const VolumeFile file(path);
    const Scene one = frame_scene(sequence, file, path);
    const Image draft = draft_picture(one, read_fields(one, file, /*empty=*/true));
    if (std::ranges::all_of(draft.rgba(), [](float value) { return value == 0; })) continue;
    const double exposure = auto_exposure(draft, one.tone_map);
    least = std::min(least.value_or(exposure), exposure);
  }
  return least.value_or(0);
}

}  // namespace

SequenceScene resolve_sequence(const Scene& scene, std::span<const std::string> wanted,
                               const std::string& open_look, bool background,
                               std::span<const std::string> files, bool others_serve,
                               Headers headers) {
  std::vector<std::string> paths(wanted.begin(), wanted.end());
  if (others_serve) paths = readable(scene, wanted, files);
  Scene common = scene;
  if (common.grid.empty()) {
    common.grid = common_grid(paths);
    if (others_serve) paths = readable(common, wanted, files);  // those that have the grid
  }
  std::vector<FilePlace> places;
  if (headers != Headers::unread) places = places_of(common, files.size() > 1 ? files : paths);
  const SampleOptions options{open_look, background, named_grids(scene, paths),
                              adaptive_domain(places)};
  std::vector<Sample> samples = samples_of(common, paths, files, options);
  const std::string look = common_look(samples);
  if (look != "plain") {
    common.look = look;
    if (std::ranges::any_of(samples, [&](const Sample& s) { return s.looked.look != look; }))
      samples = samples_of(common, paths, files, options);
  }
  const std::size_t base = std::size_t(&densest(samples) - samples.data());
  if (scene.attenuates()) common.extinction = extinction_of(samples[base]);
  take_range(samples, common);
  take_temperatures(samples, common);
  // brightness depends on what was settled so far
  if (look != "plain" && samples.size() > 1) samples = samples_of(common, paths, files, options);

  SequenceScene result{samples[base].scene, look, {}, {}, {}};
  result.scene.range = common.range;
  result.scene.temperature_scale = common.temperature_scale;
  result.scene.temperature_offset = common.temperature_offset;
  take_brightness(samples, result.scene);
  for (const std::string& option : options.side_grids)  // the base may lack it
    copy_parameter(scene, result.scene, *find_parameter(option));
  result.chosen_grids = chosen_grids(scene, result.scene);
  for (const std::string& option : options.side_grids) result.chosen_grids.push_back(option);
  result.adaptive = options.adaptive;
  if (result.adaptive)
    result.notices.push_back(
        "Blender's domain adapts: all frames get voxels of one size, above the middle of its "
        "floor; the files do not tell where in the whole domain a frame's begins");
  Subject all = all_subjects(samples);
  if (headers == Headers::seen)
    for (const std::string& path : far_files(common, places, paths, options.adaptive)) try {
        add_subject(*open_frame(result, VolumeFile(path), path).view.subject, all);
      } catch (const Error& error) {  // drawing it will say why
        if (error.code() != ExitCode::input) throw;
      }
  const auto subject = std::make_shared<const Subject>(std::move(all));
  keep_camera(result.scene,
              make_camera(with_planes(samples[base].looked.scene, *subject), *subject));
  result.subject = subject;
  if (!scene.exposure) result.scene.exposure = least_exposure(result, paths);
  for (const Sample& sample : samples)
    if (result.dark_because.empty()) result.dark_because = sample.looked.dark_because;
  result.scene.input = scene.input;
  result.settings = changed_settings(scene, result.scene);
  return result;
}

std::vector<std::string> chosen_grids(const Scene& asked, const Scene& shown) {
  std::vector<std::string> names;
  for (const Parameter& p : parameters())
    if (names_side_grid(p) && has_default(asked, p) && !has_default(shown, p))
      names.push_back(p.name);
  return names;
}

Scene frame_scene(const SequenceScene& sequence, const VolumeFile& file, const std::string& path) {
  return scene_for(sequence.scene, file, path, sequence.chosen_grids, sequence.adaptive);
}

OpenedScene open_frame(const SequenceScene& sequence, const VolumeFile& file,
                       const std::string& path, bool empty) {
  const Scene scene = frame_scene(sequence, file, path);
  return open_scene(scene, read_fields(scene, file, empty));
}

}  // namespace psivox
