#include "psivox/medium.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <map>

#include "base/text.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/density_function.h"
#include "medium/label_function.h"
#include "medium/luminance_sources.h"
#include "medium/map_field.h"
#include "medium/visible_parts.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/cuts.h"
#include "scene/transfer_function.h"

namespace psivox {

glm::dmat4 placement(const Scene& scene, const glm::dmat4& world_from_index) {
  glm::dmat4 m = glm::translate(glm::dmat4(1), scene.translate);
  for (int axis = 2; axis >= 0; --axis) {
    glm::dvec3 along(0);
    along[axis] = 1;
    m = glm::rotate(m, glm::radians(scene.rotate[axis]), along);
  }
  m = glm::scale(m, glm::dvec3(scene.scale));
  const glm::dvec3 shift(scene.centering == Centering::node ? 0 : 0.5);
  return m * glm::translate(world_from_index, shift);
}

namespace {

void check_density(const Field& density) {
  if (density.channels != 1)
    throw Error(ExitCode::input, "grid " + in_quotes(density.name) + " has vectors (" +
                                     density.value_type +
                                     "); a density is scalar: choose another with --grid");
}

/// The fields that the scene's mode uses, with values placed by its centering, in its world.
MediumFields used_fields(const Scene& scene, const MediumFields& fields) {
  MediumFields used = fields;
  if (!scene.shines()) used.luminance = used.temperature = nullptr;
  if (!scene.composites()) used.emission.clear();
  if (placement(scene, glm::dmat4(1)) == glm::dmat4(1)) return used;
  std::map<std::shared_ptr<const Field>, std::shared_ptr<const Field>> moved{{nullptr, nullptr}};
  std::vector<std::shared_ptr<const Field>*> all{&used.density, &used.drawn, &used.luminance,
                                                 &used.temperature};
  for (EmissionField& emission : used.emission) all.push_back(&emission.field);
  for (auto& field : used.albedo) all.push_back(&field);
  for (auto* field : all) {
    auto [found, is_new] = moved.try_emplace(*field);
    if (is_new) {
      Field copy = **field;
      copy.world_from_index = placement(scene, copy.world_from_index);
      found->second = std::make_shared<const Field>(std::move(copy));
    }
    *field = found->second;
  }
  return used;
}

/// Applies a function of the gradient to voxels, or to values interpolated between them. The
/// automatic extinction always comes from voxels.
void set_gradient_function(const Scene& scene, const std::shared_ptr<const Field>& density,
                           const std::shared_ptr<const TransferFunction>& function,
                           Medium& medium) {
  auto gradient = std::make_shared<const Field>(gradient_of_voxels(*density));
  const bool voxels = scene.classification == Classification::pre;
  medium.extinction = scene.extinction.value_or(1);
  if (voxels || !scene.extinction) {
    auto attenuation =
        std::make_shared<const Field>(attenuation_of_voxels(*density, *gradient, *function));
    if (!scene.extinction) medium.extinction = auto_extinction(*attenuation);
    if (voxels) medium.density = attenuation;
  }
  if (voxels) return;
  const bool zeros = function->max_attenuation(glm::dvec2(0), glm::dvec2(0, HUGE_VAL)) > 0;
  medium.density = density;
  if (zeros || !density->tiles.empty())
    medium.density = std::make_shared<const Field>(told_by_blocks(*density, *gradient, zeros));
  medium.transfer = function;
  medium.gradient = gradient;
}

/// More than the rounding of interpolated float32, which goes with the greatest values around.
double rounding_of(const Field& density) {
  const glm::dvec2 stored = stored_range(density);
  return 4e-6 * std::max(-stored.x, stored.y);
}

/// What tells a maximum from 0, and a fall from a plateau: more than rounding, and too little of
/// the range to be seen.
double least_value(const Scene& scene, const Field& density) {
  const auto range = resolved_range(scene, density);
  const double rounding = rounding_of(density);
  return range ? std::min(rounding, (range->y - range->x) / 16384) : rounding;
}

std::vector<Surface> surfaces_of(const Scene& scene, const Field& density,
                                 const TransferFunction* function) {
  std::vector<Surface> surfaces;
  for (const ShownSurface& shown : resolved_isovalue(scene, density)) {
    glm::dvec3 color = scene.resolved_luminance();
    if (!scene.luminance_grid.empty()) color *= scene.luminance_scale;
    const double value = field_isovalue(shown.value, density);
    if (function && function->has_color()) color *= function->at(value).color;
    // a plateau of that value, such as the 0 around distances, is above it and no surface
    surfaces.push_back({value - rounding_of(density), shown.color.value_or(color), shown.opacity});
  }
  std::ranges::sort(surfaces, {}, &Surface::isovalue);  // distances descend
  return surfaces;
}

/// Sets the meaning of the density's values: a surface, attenuations, or arguments of a function.
void set_density(const Scene& scene, const std::shared_ptr<const Field>& density,
                 const std::shared_ptr<const TransferFunction>& function, Medium& medium) {
  medium.density = density;
  medium.nearest = scene.classification == Classification::nearest && !scene.shows(Shows::surface);
  if (medium.nearest && density->margin == 0) {  // the last voxels are cells, too
    auto whole = std::make_shared<Field>(*density);
    whole->active_box.max += 1;
    medium.density = std::move(whole);
  }
  if (scene.shows(Shows::surface)) {
    medium.surfaces = surfaces_of(scene, *density, function.get());
  } else if (function && function->has_gradient()) {
    return set_gradient_function(scene, density, function, medium);
  } else if (function && scene.classification == Classification::pre) {
    medium.density = std::make_shared<const Field>(attenuation_of_voxels(*density, *function));
  } else {
    medium.transfer = function;
  }
  if (scene.shows(Shows::value)) medium.least_value = least_value(scene, *density);
  medium.extinction = scene.extinction.value_or(1);
  if (!scene.extinction && scene.attenuates())
    medium.extinction = scene.colormap == Colormap::labels
                            ? label_extinction(*density)
                            : auto_extinction(*medium.density, medium.transfer.get());
}

/// Throws if what the scene asks for needs all values of the density in memory, and they are not.
void check_parts(const Scene& scene, const MediumFields& fields, const TransferFunction* function) {
  const Field& density = fields.drawn ? *fields.drawn : *fields.density;
  if (scene.lit() && !fields.drawn) check_in_memory(density, "light");
  if (function && scene.classification == Classification::pre)
    check_in_memory(density, "--classification pre");
  if (function && function->has_gradient()) check_in_memory(density, "a function of the gradient");
}

Medium make_medium(const Scene& scene, const MediumFields& fields) {
  Medium medium;
  const auto function = density_function(scene, *fields.density);
  check_parts(scene, fields, function.get());
  set_density(scene, fields.density, function, medium);
  set_luminance(scene, fields, function, medium);
  if (fields.drawn &&
      ((medium.luminance && fields.luminance == fields.density) || fields.albedo.size() > 1))
    check_in_memory(*fields.drawn);
  for (const auto& [options, field] : fields.emission) {
    if (!(scene.*options->scale > 0)) continue;
    const bool hot = scene.*options->color == EmissionColor::black_body;
    const auto radiated = hot ? std::make_shared<const Field>(black_bodies(scene, *field)) : field;
    const double scale = scene.*options->scale;
    const Box domain = radiated->domain();
    medium.emission.push_back(
        {radiated, scale,
         scale * greatest_value(*radiated) * diagonal_of(*radiated, domain.max - domain.min)});
  }
  if (scene.composites()) {
    const glm::dvec3 glow = medium.color * greatest_glow(medium);
    medium.brightest = std::max({glow.x, glow.y, glow.z});
  }
  return medium;
}

/// The scene's further volumes. One without an extinction has the first one's where the scene gives
/// that, else its own; its text becomes complete, so that it draws the same again.
std::vector<Medium> further_volumes(const Medium& first, const MediumFields& fields, Scene& scene) {
  if (!scene.volumes.empty() && first.extinction == 0)
    throw Error(ExitCode::usage, "--and needs a first volume whose --extinction is above 0");
  std::vector<Medium> all;
  for (std::string& text : scene.volumes) {
    Scene own = scene_of_volume(scene, text);
    // labels are the first volume's: a further one has no function that tells them apart
    if (own.classification == Classification::nearest) own.classification = Classification::post;
    const MediumFields used = used_fields(own, fields.others[all.size()]);
    check_density(*used.density);
    check_in_memory(*used.density);
    all.push_back(make_medium(own, used));
    if (!own.extinction) text += " extinction=" + number_text(all.back().extinction);
  }
  return all;
}

/// The scene with the names of the grids that it has, and with a colour map for values of vectors
/// if nothing else gives their luminance.
Scene with_names(Scene scene, const MediumFields& fields) {
  scene.grid = fields.density->name;
  const bool dark = !scene.luminance && !scene.has_function() && scene.luminance_grid.empty() &&
                    scene.temperature_grid.empty();
  if (scene.shows(Shows::plane) && dark) scene.colormap = Colormap::viridis;
  if (fields.density->of_vectors && dark && !scene.shows(Shows::depth) &&
      !scene.shows(Shows::surface))
    scene.colormap = active_range(*fields.density).x < 0 ? Colormap::coolwarm : Colormap::viridis;
  if (fields.luminance) scene.luminance_grid = fields.luminance->name;
  if (fields.temperature) scene.temperature_grid = fields.temperature->name;
  for (const auto& [options, field] : fields.emission) scene.*options->grid = field->name;
  return scene;
}

void resolve(const MediumFields& fields, View& view) {
  Scene& scene = view.scene;
  const Medium& medium = view.medium;
  const Camera& camera = view.camera;
  const bool z_up = z_is_up(scene, *view.subject);
  const ValueScale& scale = fields.density->scale;
  const MapRange given = scene.range.value_or(MapRange({}, {true, true}));
  scene.range = resolved_range(scene, *fields.density);
  for (int i = 0; scene.range && i < 2; ++i)
    scene.range->ends[i] = given.percent[i] ? scale.value_of(scene.range->ends[i]) : given.ends[i];
  if (scale.kind == ValueScale::Kind::symlog) scene.value_scale = scale;
  if (scene.attenuates()) scene.extinction = medium.extinction;
  if (scene.shows(Shows::surface)) scene.isovalue = resolved_isovalue(scene, *fields.density);
  scene.luminance = scene.resolved_luminance();
  if (!scene.tolerance) {  // else the tolerance chooses them
    scene.integrator = scene.resolved_integrator();
    scene.sampling = scene.resolved_sampling();
    if (scene.sampling == Sampling::uniform) scene.step = scene.resolved_step();
    scene.early_termination = scene.resolved_early_termination();
  }
  keep_camera(scene, camera);
  scene.up_axis = z_up ? UpAxis::z : UpAxis::y;
}

}  // namespace

std::optional<KnownSubject> KnownSubject::of(const View& view) {
  const Medium& medium = view.medium;
  if (!medium.emission.empty() || !medium.others.empty()) return {};
  return KnownSubject{medium.density, medium.transfer, view.scene.mode, medium.surfaces,
                      view.subject};
}

bool KnownSubject::serves(const Medium& medium, Mode seen_by) const {
  const bool same_function =
      transfer && medium.transfer ? *transfer == *medium.transfer : transfer == medium.transfer;
  return density.lock() == medium.density && same_function && mode == seen_by &&
         surfaces == medium.surfaces && medium.emission.empty() && medium.others.empty();
}

View make_view(const Scene& scene, const VolumeFile& file) {
  validate(scene);
  return make_view(scene, read_fields(scene, file));
}

View make_view(const Scene& scene, std::shared_ptr<const Field> density,
               std::shared_ptr<const Field> luminance) {
  if (density && !luminance && !scene.luminance_grid.empty() && scene.shines()) {
    if (scene.luminance_grid != density->name)
      throw Error(ExitCode::usage, "--luminance-grid " + in_quotes(scene.luminance_grid) +
                                       ": no such field at hand");
    luminance = density;
  }
  if (density) density = scaled_values(density, scene.value_scale);
  return make_view(scene, MediumFields{density, luminance, nullptr});
}

double brightest_ray(const Medium& medium) {
  double sum = medium.brightest;
  for (const Emission& emission : medium.emission) sum += emission.brightest;
  for (const Medium& other : medium.others) sum += brightest_ray(other);
  return sum;
}

double early_termination(const View& view) {
  if (view.scene.early_termination) return *view.scene.early_termination;
  return view.scene.resolved_early_termination() / std::max(1.0, brightest_ray(view.medium) / 2);
}

View make_view(const Scene& unnamed, const MediumFields& all_fields) {
  if (!all_fields.density) throw Error(ExitCode::input, "there is no field of the density");
  check_density(*all_fields.density);
  MediumFields fields = used_fields(unnamed, all_fields);
  const Scene scene = with_names(unnamed, fields);
  validate(scene);
  if (scene.color_bar && !scene.colormap && !scene.shows(Shows::value) &&
      scene.transfer_function.empty())
    throw Error(ExitCode::usage,
                "--color-bar shows the colours of a map; give --colormap or --transfer-function");
  View view{scene, make_medium(scene, fields), {}, {}};
  Scene complete = scene;
  read_volumes(scene, fields);
  view.medium.others = further_volumes(view.medium, fields, complete);
  if (fields.subject && fields.subject->serves(view.medium, scene.mode)) {
    view.subject = fields.subject->subject;
  } else {
    Subject subject = subject_of(view.medium, scene.mode);
    subject.z_up = fields.z_up;
    view.subject = std::make_shared<const Subject>(std::move(subject));
  }
  view.scene = with_planes(complete, *view.subject);
  view.camera = make_camera(view.scene, *view.subject);
  resolve(fields, view);
  if (fields.drawn) view.medium.density = fields.drawn;
  return view;
}

std::vector<ParallelLight> surface_lights(const View& view) {
  std::vector<ParallelLight> lights;
  for (const DirectionalLight& light : view.scene.lights) {
    const glm::dvec3 direction = glm::normalize(light.direction);
    lights.push_back(
        {light.of_camera ? from_camera(view.camera, direction) : direction, light.color, false});
  }
  return lights;
}

double henyey_greenstein(double g, double cosine) {
  return (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5);
}

double phase_factor(const Medium& medium, const glm::dvec3& ray_direction) {
  // scattered light travels against the ray
  return henyey_greenstein(medium.phase_g, -glm::dot(medium.phase_axis, ray_direction));
}

}  // namespace psivox
