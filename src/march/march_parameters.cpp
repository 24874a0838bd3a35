#include "march/march_parameters.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "march/end_corrections.h"
#include "march/preintegration.h"
#include "march/psi_table.h"
#include "march/ray_template.h"
#include "march/transfer_table.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// Length of the shortest column of the transform: the finest voxel [world units].
double finest_voxel(const Field& field) {
  const glm::dmat4& m = field.world_from_index;
  return std::min({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                   glm::length(glm::dvec3(m[2]))});
}

/// Whether rays begin inside the density's domain: the eye does, or a part of the orthographic
/// camera's plane may.
bool begins_inside(const View& view) {
  const Field& density = *view.medium.density;
  const Box domain = density.domain();
  const glm::dvec3 low(domain.min), high(domain.max);
  if (!view.camera.orthographic) {
    const glm::dvec3 eye(glm::inverse(density.world_from_index) *
                         glm::dvec4(view.camera.position, 1));
    return glm::all(glm::greaterThan(eye, low)) && glm::all(glm::lessThan(eye, high));
  }
  bool before = false, behind = false;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner = glm::mix(low, high, glm::dvec3(i >> 2, i >> 1 & 1, i & 1));
    const glm::dvec3 at(density.world_from_index * glm::dvec4(corner, 1));
    (glm::dot(at - view.camera.position, view.camera.forward) > 0 ? before : behind) = true;
  }
  return before && behind;
}

/// More turns than any ray can take.
double turn_bound(const MarchSetup& setup, const RayBundle& bundle, double unit,
                  double finest_step) {
  const MarchParameters& p = setup.parameters;
  const glm::dvec3 size = glm::dvec3(p.density_domain_max - p.density_domain_min);
  double cells = size.x + size.y + size.z + 3;
  if (!setup.constants.uniform_sampling) {
    // A cell is cut where the value turns and where it crosses a knot, at most thrice each.
    double pieces = setup.constants.split_knots ? 3 + 3.0 * p.transfer_knots : 1;
    if (!setup.constants.cell_rule) return pieces * cells;
    // Cut where other grids' faces are, too.
    const auto add = [&](const glm::ivec3& extent) { cells += extent.x + extent.y + extent.z + 3; };
    if (setup.constants.luminance_source == int(LuminanceSource::scalar) ||
        setup.constants.luminance_source == int(LuminanceSource::vector))
      add(p.luminance_domain_max - p.luminance_domain_min);
    if (setup.constants.emission_channels) add(p.emission_domain_max - p.emission_domain_min);
    // What smooth_part leaves of a piece is at least (2.8e-3 / (27 * 16))^(1/6) = 0.136 of it: a
    // cubic that is not negative and has the integral 0.75 has a q_3 of 27 at most, one between
    // -1/2 and 1/2 one of 16.
    pieces *= 8;
    // Opaque cells are crossed in parts of a depth of 0.75/4/60 at least (see shallow_part), until
    // the depth at which every ray has ended.
    return pieces * cells + 320 * std::min(p.stop_depth, 1e7);
  }
  if (setup.constants.template_sampling) return p.template_entries + 2.0;
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
  return cells + length / finest_step + 2;
}

/// Largest value that an atlas holds, and 0.
double largest_value(const BrickAtlas& atlas) {
  double most = 0;
  for (const BrickStats& brick : atlas.bricks) most = std::max(most, double(brick.max));
  for (const float constant : atlas.constants) most = std::max(most, double(constant));
  return most;
}

/// Bound on the optical depth of a ray through the density.
double depth_bound(const Medium& medium, const BrickAtlas& atlas) {
  const double value = largest_value(atlas);
  // the largest attenuation may be of a value between
  const double attenuation =
      medium.transfer ? medium.transfer->max_attenuation(-std::numeric_limits<double>::max(), value)
                      : value;
  const glm::dmat3 m(medium.density->world_from_index);
  const glm::dvec3 size(atlas.domain.max - atlas.domain.min);
  double diagonal = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      diagonal = std::max(diagonal, glm::length(m * (size * glm::dvec3(1, y, z))));
  return medium.extinction * attenuation * diagonal;
}

/// Where a grid's rays run, its domain and its page table, as PREFIX_... of the parameters.
#define PLACE_GRID(prefix, bundle, atlas)                       \
  p.prefix##_anchor_0 = (bundle).anchor_0;                      \
  p.prefix##_anchor_u = (bundle).anchor_u;                      \
  p.prefix##_anchor_v = (bundle).anchor_v;                      \
  p.prefix##_direction_0 = (bundle).direction_0 * unit;         \
  p.prefix##_direction_u = (bundle).direction_u * unit;         \
  p.prefix##_direction_v = (bundle).direction_v * unit;         \
  p.prefix##_domain_min = (atlas).domain.min - (bundle).origin; \
  p.prefix##_domain_max = (atlas).domain.max - (bundle).origin; \
  p.prefix##_table_min = (atlas).pages.min - (bundle).origin;   \
  p.prefix##_table_size = (atlas).pages.top_size;               \
  c.prefix##_levels = (atlas).pages.levels;

/// The transfer function's knots and bins, appended to the tables.
void place_transfer(const TransferFunction& function, MarchSetup& setup) {
  const TransferTable table = make_transfer_table(function);
  MarchParameters& p = setup.parameters;
  p.transfer_first = int(setup.tables.size());
  p.transfer_knots = table.knots;
  p.transfer_bins_first = p.transfer_first + 4 * table.knots;
  p.transfer_bins = table.bins;
  p.transfer_min = table.min;
  p.transfer_bin_scale = table.bin_scale;
  setup.tables.insert(setup.tables.end(), table.entries.begin(), table.entries.end());
  setup.constants.one_interval = table.knots == 2;
  setup.search_steps = table.search_steps;
  setup.constants.transfer_search = table.search_steps > 0;
}

/// The gradient's grid, and the function's gradient part, appended to the tables.
void place_gradient(const TransferFunction& function, const BrickAtlas& atlas,
                    const glm::ivec3& origin, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  setup.constants.with_gradient = true;
  setup.constants.gradient_levels = atlas.pages.levels;
  p.gradient_table_min = atlas.pages.min - origin;
  p.gradient_table_size = atlas.pages.top_size;
  const GradientEntries part = make_gradient_entries(function);
  p.gradient_first = int(setup.tables.size());
  p.gradient_columns = part.columns;
  p.isosurfaces = part.isosurfaces;
  p.isosurfaces_first = p.gradient_first + int(part.entries.size()) - part.isosurfaces;
  setup.tables.insert(setup.tables.end(), part.entries.begin(), part.entries.end());
  setup.search_steps += part.search_steps + part.isosurfaces;
}

/// The ray template, appended to the tables. Its voxels are the density's.
void place_template(const View& view, MarchSetup& setup) {
  const Medium& medium = view.medium;
  if (medium.emission ||
      (medium.luminance && medium.luminance->world_from_index != medium.density->world_from_index))
    throw Error(ExitCode::usage,
                "--sampling template reads the density's voxels; another grid must have the same "
                "transform, and none may emit; use --sampling uniform");
  MarchParameters& p = setup.parameters;
  const glm::ivec3 size = p.density_domain_max - p.density_domain_min;
  // a few more than there are
  const int planes = std::max({size.x, size.y, size.z}) + 8;
  const RayTemplate made = make_ray_template(p.density_direction_0 / glm::length(p.world_0), planes,
                                             view.scene.connectivity);
  p.template_first = int(setup.tables.size());
  p.template_entries = int(made.entries.size());
  p.template_axis = made.axis;
  p.template_spacing = made.spacing;
  setup.tables.insert(setup.tables.end(), made.entries.begin(), made.entries.end());
}

/// The bricks' parts of the step, appended to the tables.
void place_brick_steps(const std::vector<float>& parts, const BrickAtlas& density,
                       MarchSetup& setup) {
  if (parts.size() != density.bricks.size())
    throw Error(ExitCode::failure, "the bricks' steps are not of the view's atlas");
  setup.constants.brick_steps = true;
  setup.parameters.brick_steps_first = int(setup.tables.size());
  for (const float part : parts) setup.tables.emplace_back(part, 0, 0, 0);
}

/// Longest segment of a cell's [unit of t].
double longest_segment(const Field& field, int segments, double unit) {
  const glm::dmat3 m(field.world_from_index);
  double longest = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      longest = std::max(longest, glm::length(m * glm::dvec3(1, y, z)));
  return longest / (unit * segments);
}

/// The table of `preintegrated`, appended to the tables.
void place_preintegration(const View& view, double unit, bool may_update, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  const bool uniform = setup.constants.uniform_sampling && !setup.constants.template_sampling;
  const double length =
      uniform ? p.step : longest_segment(*view.medium.density, view.scene.segments, unit);
  setup.preintegration =
      preintegrated_table(*view.medium.transfer, p.extinction, length, uniform, may_update);
  const PreintegratedTable& table = *setup.preintegration;
  p.preintegration_first = int(setup.tables.size());
  p.preintegration_size = table.size();
  p.preintegration_layers = table.layers();
  p.preintegration_scale = table.scale();
  p.preintegration_length = table.max_length();
  setup.tables.insert(setup.tables.end(), table.entries().begin(), table.entries().end());
}

}  // namespace

bool has_end_corrections(const View& view) {
  const Scene& scene = view.scene;
  // From vacuum to vacuum there is nothing to correct.
  return scene.end_corrections && scene.resolved_sampling() == Sampling::uniform &&
         !view.medium.transfer && !view.medium.emission && scene.mode == Mode::alpha &&
         scene.resolved_integrator() == Integrator::psi_balanced && begins_inside(view);
}

MarchSetup make_march_setup(const View& view, const MediumAtlas& atlas,
                            const RenderOptions& options) {
  const Scene& scene = view.scene;
  const Medium& medium = view.medium;
  if (medium.light) throw Error(ExitCode::failure, "the view's light is still to be computed");
  const double unit = finest_voxel(*medium.density);
  MarchSetup setup;
  setup.tables.assign(1, glm::vec4(0));
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;

  const RayBundle bundle = make_ray_bundle(view.camera, *medium.density, *medium.density);
  PLACE_GRID(density, bundle, atlas.density)
  setup.origin = bundle.origin;
  if (atlas.luminance && medium.luminance) {
    const RayBundle own = make_ray_bundle(view.camera, *medium.luminance, *medium.density);
    PLACE_GRID(luminance, own, *atlas.luminance)
  }
  if (atlas.emission && medium.emission) {
    const RayBundle own = make_ray_bundle(view.camera, *medium.emission, *medium.density);
    PLACE_GRID(emission, own, *atlas.emission)
    c.emission_channels = atlas.emission->channels;
    p.emission_scale = medium.emission_scale * unit;
  }
  p.world_0 = bundle.world_0;
  p.world_u = bundle.world_u;
  p.world_v = bundle.world_v;
  p.camera_distance = bundle.distance / unit;
  p.image_size = glm::dvec2(scene.resolution);
  p.sample_offset = glm::dvec2(0.5);
  p.extinction = medium.extinction * unit;
  p.color = medium.color;
  // Beyond a depth of 100 nothing is left that a float32 holds, also where rays never end early.
  const double least_transmittance = scene.resolved_early_termination();
  p.stop_depth = least_transmittance > 0 ? std::min(-std::log(least_transmittance), 100.0) : 100.0;
  if (scene.mode == Mode::back_to_front || scene.mode == Mode::xray) p.stop_depth = 1e30;
  c.ends_early = depth_bound(medium, atlas.density) > p.stop_depth;
  c.attenuates = medium.extinction > 0;
  p.step = scene.resolved_step();
  p.opacity_unit = scene.opacity_unit;
  p.world_unit = unit;
  p.lmip_threshold = scene.lmip_threshold;
  p.isovalue = medium.isovalue;
  const glm::dmat3 normal =
      glm::transpose(glm::inverse(glm::dmat3(medium.density->world_from_index)));
  p.normal_x = normal[0] * unit;
  p.normal_y = normal[1] * unit;
  p.normal_z = normal[2] * unit;
  if (scene.light) p.light_direction = glm::normalize(scene.light->direction);
  p.phase_axis = medium.phase_axis;
  p.phase_g = medium.phase_g;
  c.anisotropic = medium.phase_g != 0;

  const IntegratorInfo& rule = info(scene.resolved_integrator());
  c.integrator = rule.id;
  if (rule.id == Integrator::psi_table) {
    static const std::vector<glm::vec4> table = make_psi_table();
    p.psi_table_first = int(setup.tables.size());
    setup.tables.insert(setup.tables.end(), table.begin(), table.end());
  }
  c.luminance_source = int(medium.source);
  c.segments = scene.segments;
  c.constant_runs = atlas.density.size.constant_bricks > 0;
  c.uniform_sampling = scene.resolved_sampling() != Sampling::cells;
  c.template_sampling = scene.resolved_sampling() == Sampling::template_;
  if (c.template_sampling) place_template(view, setup);
  c.end_corrections = has_end_corrections(view);
  c.middle_rule = rule.samples_middle;
  c.exact_depth = rule.exact_depth;
  c.cell_rule = rule.kind == IntegratorKind::cell;
  c.transfer_rule = rule.kind == IntegratorKind::transfer;
  c.mode = int(scene.mode);
  if (medium.transfer) {
    c.transfer = true;
    c.split_knots = scene.split_knots || c.cell_rule;
    place_transfer(*medium.transfer, setup);
    if (rule.id == Integrator::preintegrated)
      place_preintegration(view, unit, options.may_update_tables, setup);
    if (medium.gradient && atlas.gradient)
      place_gradient(*medium.transfer, *atlas.gradient, bundle.origin, setup);
    const Box own = medium.density->domain();
    p.density_field_min = own.min - bundle.origin;
    p.density_field_max = own.max - bundle.origin;
    constexpr double any = std::numeric_limits<double>::infinity();
    c.beyond =
        medium.emission && medium.transfer->max_attenuation(glm::dvec2(0), glm::dvec2(0, any)) > 0;
  }
  if (options.brick_steps && c.uniform_sampling && !c.template_sampling)
    place_brick_steps(*options.brick_steps, atlas.density, setup);
  c.count_steps = options.count;
  c.find_depth = options.depth;
  c.hardware_filter = scene.filter == Filter::hardware;
  c.orthographic = view.camera.orthographic;

  double finest = p.step;
  if (c.brick_steps)
    finest *= *std::min_element(options.brick_steps->begin(), options.brick_steps->end());
  p.max_turns = int(
      std::min(turn_bound(setup, bundle, unit, finest), double(std::numeric_limits<int>::max())));
  return setup;
}

}  // namespace psivox
