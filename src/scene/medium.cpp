#include "psivox/medium.h"

#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox {

View make_view(const Scene& scene, const VdbFile& file) {
  validate(scene);
  const std::string grid = scene.grid.empty() ? file.default_grid() : scene.grid;
  const auto density =
      std::make_shared<const Field>(file.read(grid, {GridRole::attenuation, scene.strict}));
  if (scene.luminance_grid.empty()) return make_view(scene, density, nullptr);
  if (scene.luminance_grid == grid) return make_view(scene, density, density);
  const auto luminance = std::make_shared<const Field>(
      file.read(scene.luminance_grid, {GridRole::luminance, scene.strict}));
  // One grid may go by two names: `density` is also `density[0]`.
  return make_view(scene, density, luminance->name == density->name ? density : luminance);
}

View make_view(const Scene& scene, std::shared_ptr<const Field> density,
               std::shared_ptr<const Field> luminance) {
  validate(scene);
  if (density->channels != 1)
    throw Error(ExitCode::input, "grid " + in_quotes(density->name) + " has vectors (" +
                                     density->value_type +
                                     "); a density is scalar: choose another with --grid");
  if (!luminance && !scene.luminance_grid.empty()) {
    if (scene.luminance_grid != density->name)
      throw Error(ExitCode::usage, "--luminance-grid " + in_quotes(scene.luminance_grid) +
                                       ": no such field at hand");
    luminance = density;
  }

  View view{scene, {}, {}};
  Medium& medium = view.medium;
  medium.density = density;
  medium.extinction = scene.extinction ? *scene.extinction : auto_extinction(*density);
  if (luminance == density)
    medium.source = LuminanceSource::density;
  else if (luminance)
    medium.source = luminance->channels == 3 ? LuminanceSource::vector : LuminanceSource::scalar;
  medium.color = scene.luminance;
  if (medium.source != LuminanceSource::constant) medium.color *= scene.luminance_scale;
  if (luminance != density) medium.luminance = luminance;

  glm::dvec3 box_min, box_max;
  world_bounds(*density, box_min, box_max);
  view.camera = make_camera(scene, box_min, box_max);

  Scene& resolved = view.scene;
  resolved.grid = density->name;
  if (luminance) resolved.luminance_grid = luminance->name;
  resolved.extinction = medium.extinction;
  resolved.integrator = scene.resolved_integrator();
  resolved.sampling = scene.resolved_sampling();
  if (resolved.sampling == Sampling::uniform) resolved.step = scene.resolved_step();
  resolved.camera_position = view.camera.position;
  resolved.camera_target = view.camera.target;
  resolved.fov = horizontal_fov(scene);
  if (view.camera.orthographic) resolved.ortho_width = 2 * view.camera.half_width;
  return view;
}

}  // namespace psivox
