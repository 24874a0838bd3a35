#include "march/march_parameters.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace psivox {
namespace {

/// Length of the shortest column of the transform: the finest voxel [world units].
double finest_voxel(const Field& field) {
  const glm::dmat4& m = field.world_from_index;
  return std::min({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                   glm::length(glm::dvec3(m[2]))});
}

/// More turns than any ray can take.
double turn_bound(const MarchSetup& setup, const RayBundle& bundle, double unit) {
  const MarchParameters& p = setup.parameters;
  const glm::dvec3 size = glm::dvec3(p.density_domain_max - p.density_domain_min);
  const double cells = size.x + size.y + size.z + 3;
  if (!setup.constants.uniform_sampling) {
    // Opaque cells are crossed in parts of a depth of 0.75/4/60 at least (see shallow_part), until
    // the depth at which every ray has ended.
    return cells + (setup.constants.cell_rule ? 320 * p.stop_depth : 0);
  }
  // Longest ray: the domain's diagonal over the slowest that a unit of t advances.
  const glm::dmat3 m(bundle.direction_u, bundle.direction_v, bundle.direction_0);
  double slowest = std::numeric_limits<double>::max();
  for (const double u : {-1.0, 0.0, 1.0})
    for (const double v : {-1.0, 0.0, 1.0}) {
      const glm::dvec3 w = bundle.world_0 + bundle.world_u * u + bundle.world_v * v;
      slowest = std::min(slowest, glm::length(m * glm::dvec3(u, v, 1.0)) / glm::length(w));
    }
  // The direction varies inside the picture; a factor 2 covers what its nine points miss.
  const double length = 2 * glm::length(size) / (slowest * unit);
  return cells + length / p.step + 2;
}

}  // namespace

MarchSetup make_march_setup(const View& view, const BrickAtlas& density,
                            const BrickAtlas* luminance) {
  const Scene& scene = view.scene;
  const Medium& medium = view.medium;
  const double unit = finest_voxel(*medium.density);
  MarchSetup setup;
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;

  const RayBundle bundle = make_ray_bundle(view.camera, *medium.density, *medium.density);
  p.density_anchor_0 = bundle.anchor_0;
  p.density_anchor_u = bundle.anchor_u;
  p.density_anchor_v = bundle.anchor_v;
  p.density_direction_0 = bundle.direction_0 * unit;
  p.density_direction_u = bundle.direction_u * unit;
  p.density_direction_v = bundle.direction_v * unit;
  p.density_domain_min = density.domain.min - bundle.origin;
  p.density_domain_max = density.domain.max - bundle.origin;
  p.density_table_min = density.pages.min - bundle.origin;
  p.density_table_size = density.pages.top_size;
  p.world_0 = bundle.world_0;
  p.world_u = bundle.world_u;
  p.world_v = bundle.world_v;
  p.camera_distance = bundle.distance / unit;
  p.image_size = glm::dvec2(scene.resolution);
  p.sample_offset = glm::dvec2(0.5);
  p.extinction = medium.extinction * unit;
  p.color = medium.color;
  // Beyond a depth of 100 nothing is left that a float32 holds, also where rays never end early.
  p.stop_depth =
      scene.early_termination > 0 ? std::min(-std::log(scene.early_termination), 100.0) : 100.0;
  p.step = scene.resolved_step();
  p.world_unit = unit;

  if (luminance) {
    const RayBundle own = make_ray_bundle(view.camera, *medium.luminance, *medium.density);
    p.luminance_anchor_0 = own.anchor_0;
    p.luminance_anchor_u = own.anchor_u;
    p.luminance_anchor_v = own.anchor_v;
    p.luminance_direction_0 = own.direction_0 * unit;
    p.luminance_direction_u = own.direction_u * unit;
    p.luminance_direction_v = own.direction_v * unit;
    p.luminance_domain_min = luminance->domain.min - own.origin;
    p.luminance_domain_max = luminance->domain.max - own.origin;
    p.luminance_table_min = luminance->pages.min - own.origin;
    p.luminance_table_size = luminance->pages.top_size;
    c.luminance_levels = luminance->pages.levels;
  }

  const IntegratorInfo& rule = info(scene.resolved_integrator());
  c.integrator = rule.id;
  c.luminance_source = int(medium.source);
  c.segments = scene.segments;
  c.density_levels = density.pages.levels;
  c.constant_runs = density.size.constant_bricks > 0;
  c.uniform_sampling = scene.resolved_sampling() == Sampling::uniform;
  c.middle_rule = rule.samples_middle;
  c.exact_depth = rule.exact_depth;
  c.cell_rule = is_cell_rule(rule.id);
  c.hardware_filter = scene.filter == Filter::hardware;
  c.orthographic = view.camera.orthographic;

  p.max_turns =
      int(std::min(turn_bound(setup, bundle, unit), double(std::numeric_limits<int>::max())));
  return setup;
}

}  // namespace psivox
