#include "psivox/open.h"

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "scene/camera_file.h"

namespace psivox {

Scene with_settings(Scene scene, const std::string& camera, std::span<const Setting> settings,
                    const std::function<bool(const Scene&)>& z_is_up) {
  if (!camera.empty()) {
    Scene known = scene;
    apply_over(known, settings);
    const FileCamera read = read_camera(camera, z_is_up(known));
    scene.resolution = known.resolution;
    set_camera(scene, read);
  }
  apply_over(scene, settings);
  return scene;
}

void check_picture(const Scene& scene, const std::vector<std::string>& layers) {
  if (std::ranges::count(layers, "deep")) {
    if (layers.size() > 1)
      throw Error(ExitCode::usage, "--aov deep has no layers beside it; leave out the others");
    check_method_unset(scene, "--aov deep");
  }
  for (const std::string& layer : layers)
    if (const std::string obstacle = layer_obstacle(layer, scene); !obstacle.empty())
      throw Error(ExitCode::usage, obstacle);
}

namespace {

/// What tells that a further volume lies on its side; empty if nothing does.
std::string lying_notice(const Scene& own, const VolumeFile& file, const LookedScene& first) {
  const bool z_is_up =
      own.up_axis == UpAxis::z || (own.up_axis == UpAxis::automatic && !first.fields.z_up.empty());
  if (file.z_up().empty() || z_is_up || own.rotate != Scene{}.rotate) return {};
  return in_quotes(own.input) + ": Z is up (" + file.z_up() +
         "), but Y in this scene; rotate=-90,0,0 behind its name turns it";
}

/// Adds a further volume to a scene in its look: with what its own file's look says, of what a
/// volume has for itself.
void add_volume(const Scene& scene, std::string text, const std::string& open_look,
                LookedScene& looked) {
  const Scene own = scene_of_volume(scene, text);
  const VolumeFile file(own.input);
  LookedScene of_file = with_look(own, file, open_look);
  for (const Setting& setting : of_file.settings)
    if (may_be_of_volume(*find_parameter(setting.name)))
      text += " " + setting.name + "=" + setting.text;
  const Scene shown = scene_of_volume(looked.scene, text);
  const bool read = fields_key(shown) == fields_key(of_file.scene);
  MediumFields fields = read ? std::move(of_file.fields) : read_fields(shown, file);
  if (std::string lying = lying_notice(own, file, looked); !lying.empty()) {
    Field density = *fields.density;
    density.notices.push_back(std::move(lying));
    fields.density = std::make_shared<const Field>(std::move(density));
  }
  looked.fields.others.push_back(std::move(fields));
  looked.scene.volumes.push_back(std::move(text));
}

}  // namespace

OpenedScene open_scene(const Scene& scene, const VolumeFile& file, const OpenOptions& options) {
  Scene first = scene;
  first.volumes.clear();
  if (!scene.volumes.empty()) first.given.insert("mode");  // several are no surface
  OpenedScene opened{with_look(first, file, options.open_look, options.background, options.parts),
                     {}};
  for (const std::string& volume : scene.volumes)
    add_volume(scene, volume, options.open_look, opened.looked);
  if (!scene.volumes.empty()) opened.looked.settings = changed_settings(scene, opened.looked.scene);
  opened.view = make_view(opened.looked.scene, opened.looked.fields);
  return opened;
}

OpenedScene open_scene(const Scene& scene, MediumFields fields) {
  View view = make_view(scene, fields);
  return {{.scene = scene, .look = "plain", .settings = {}, .fields = std::move(fields)},
          std::move(view)};
}

}  // namespace psivox
