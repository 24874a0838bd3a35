#include "march/march_parameters.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "field/index_space.h"
#include "march/march_tables.h"
#include "march/transfer_table.h"
#include "psivox/error.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

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
    const glm::dvec3 at(density.world_from_index * glm::dvec4(corner_of(domain, i), 1));
    (glm::dot(at - view.camera.position, view.camera.forward) > 0 ? before : behind) = true;
  }
  return before && behind;
}

/// The width of all bricks in codes; -1 where they differ.
int one_width(const MediumAtlas& atlas) {
  const BrickAtlas& density = atlas.density;
  const std::size_t channels = atlas.paired ? 1 + std::size_t(atlas.luminance->channels) : 1;
  const auto width = [&](std::size_t slot) {
    return int(width_of_head(density.codes[density.code_places[slot] * code_words * channels]));
  };
  for (std::size_t slot = 1; slot < density.code_places.size(); ++slot)
    if (width(slot) != width(0)) return -1;
  return density.code_places.empty() ? 0 : width(0);
}

/// The numbers of a grid: where its rays run, its domain and its page table.
glsl::Grid grid_numbers(const RayBundle& bundle, const BrickAtlas& atlas, double unit) {
  glsl::Grid g;
  g.anchor_0 = bundle.anchor_0;
  g.anchor_u = bundle.anchor_u;
  g.anchor_v = bundle.anchor_v;
  g.direction_0 = bundle.direction_0 * unit;
  g.direction_u = bundle.direction_u * unit;
  g.direction_v = bundle.direction_v * unit;
  g.domain_min = atlas.domain.min - bundle.origin;
  g.domain_max = atlas.domain.max - bundle.origin;
  g.table_min = atlas.pages.min - bundle.origin;
  g.table_size = atlas.pages.top_size;
  return g;
}

}  // namespace

double beside_voxels(const MarchConstants& constants, int grid) {
  const bool cells =
      grid == density_grid ? constants.nearest : grid == luminance_grid && constants.lit_voxels;
  return cells ? 0.5 : 0;
}

namespace {

void place_grids(const View& view, const MediumAtlas& atlas, MarchSetup& setup) {
  const Medium& medium = view.medium;
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  const PerGrid<const Field*> fields = fields_of(medium);
  setup.constants.nearest = medium.nearest && view.scene.resolved_sampling() != Sampling::template_;
  setup.constants.lit_voxels = setup.constants.nearest && medium.lit;
  const auto place = [&](std::size_t id, glsl::Grid& numbers, int& levels, int& channels) {
    if (!grids[id] || !fields[id]) return;
    const double unit = setup.parameters.world_unit;
    RayBundle bundle = make_ray_bundle(view.camera, *fields[id], *medium.density);
    bundle.anchor_0 += beside_voxels(setup.constants, int(id));
    numbers = grid_numbers(bundle, *grids[id], unit);
    if (id >= emission_grid) numbers.scale = medium.emission[id - emission_grid].scale * unit;
    levels = grids[id]->pages.levels;
    channels = grids[id]->channels;
  };
#define GRID(id, name) \
  place(id, setup.parameters.name, setup.constants.name##_levels, setup.constants.name##_channels);
#include "grids.glsl"
#undef GRID
  setup.constants.absent_voxels = atlas.density.absent;
  setup.constants.coded = atlas.density.codes != nullptr;
  setup.constants.one_width = one_width(atlas);
  setup.constants.paired = atlas.paired;
  setup.constants.constant_runs = atlas.density.size.constant_bricks > 0;
}

void place_camera(const View& view, const RayBundle& bundle, MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  setup.origin = bundle.origin;
  p.world_0 = bundle.world_0;
  p.world_u = bundle.world_u;
  p.world_v = bundle.world_v;
  p.camera_distance = bundle.distance / p.world_unit;
  p.image_size = glm::dvec2(view.scene.resolution);
  p.sample_offset = glm::dvec2(0.5);
  setup.constants.orthographic = view.camera.orthographic;
  place_clip(view, bundle.distance, setup);
  place_holdout(view, bundle.distance, setup);
}

/// What a ray shows of the medium: extinction, luminance, emission, phase, mode and surface.
void place_medium(const View& view, MarchSetup& setup) {
  const Medium& medium = view.medium;
  const Scene& scene = view.scene;
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;
  p.extinction = medium.extinction * p.world_unit;
  c.attenuates = medium.extinction > 0;
  p.color = medium.color;
  p.ambient = medium.ambient;
  c.luminance_source = int(medium.source);
  p.phase_axis = medium.phase_axis;
  p.phase_g = medium.phase_g;
  c.anisotropic = medium.phase_g != 0;
  c.mode = int(scene.mode);
  c.shows = int(info(scene.mode).shows);
  c.from_back = info(scene.mode).from_back;
  p.lmip_threshold = medium.density->scale.scaled(scene.lmip_threshold);
  p.least_value = medium.least_value;
  const glm::dmat3 normal =
      glm::transpose(glm::inverse(glm::dmat3(medium.density->world_from_index)));
  p.normal_x = normal[0] * p.world_unit;
  p.normal_y = normal[1] * p.world_unit;
  p.normal_z = normal[2] * p.world_unit;
  if (scene.shows(Shows::surface)) place_surfaces(view, setup);
}

/// The region that rays collect from. Where it reaches beyond the domain its faces do not matter,
/// but their numbers must be small.
void place_part(const Box& bricks, const Box& domain, MarchSetup& setup) {
  const glm::ivec3 least = (domain.min >> 3) - 1, most = (domain.max >> 3) + 1;
  MarchParameters& p = setup.parameters;
  setup.constants.in_part = true;
  p.part_min = 8 * glm::clamp(bricks.min, least, most) - setup.origin;
  p.part_max = 8 * glm::clamp(bricks.max + 1, least, most) - setup.origin;
}

/// How the ray is integrated: rule, sampling, steps.
void place_method(const View& view, const MediumAtlas& atlas, const RenderOptions& options,
                  MarchSetup& setup) {
  const Scene& scene = view.scene;
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;
  if (atlas.part) place_part(*atlas.part, atlas.density.domain, setup);
  const IntegratorInfo& rule = info(scene.resolved_integrator());
  c.integrator = rule.id;
  c.middle_rule = rule.samples_middle && !scene.shows(Shows::value);  // a maximum reads ends
  c.exact_depth = rule.exact_depth;
  c.cell_rule = rule.kind == IntegratorKind::cell;
  c.transfer_rule = rule.kind == IntegratorKind::transfer;
  if (rule.id == Integrator::psi_table) place_psi_table(setup);
  p.opacity_unit = scene.opacity_unit;
  c.segments = scene.segments;
  c.hardware_filter = scene.filter == Filter::hardware;
  c.end_corrections = has_end_corrections(view);
  p.step = scene.resolved_step();
  c.uniform_sampling = scene.resolved_sampling() != Sampling::cells;
  c.template_sampling = scene.resolved_sampling() == Sampling::template_;
  if (c.template_sampling) place_template(view, setup);
  c.octants = atlas.density.pages.octants && !c.hardware_filter;
  if (options.brick_steps && c.uniform_sampling && !c.template_sampling)
    place_brick_steps(*options.brick_steps, atlas.density, setup);
}

void place_function(const View& view, const RenderOptions& options, MarchSetup& setup) {
  const Medium& medium = view.medium;
  if (!medium.transfer) return;
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;
  c.transfer = true;
  c.split_knots = view.scene.split_knots || c.cell_rule;
  place_transfer(*medium.transfer, setup);
  const std::optional<Ramps> ramps = make_ramps(*medium.transfer);
  c.lit_colors = medium.lit_colors;
  if (ramps && medium.source != LuminanceSource::transfer && !c.lit_colors)
    place_ramps(*ramps, setup);
  if (c.integrator == Integrator::preintegrated)
    place_preintegration(view, options.may_update_tables, setup);
  if (medium.gradient) place_gradient(*medium.transfer, setup);
  const Box own = medium.density->domain();
  p.density_field_min = own.min - setup.origin;
  p.density_field_max = own.max - setup.origin;
  constexpr double any = std::numeric_limits<double>::infinity();
  c.beyond = !medium.emission.empty() &&
             medium.transfer->max_attenuation(glm::dvec2(0), glm::dvec2(0, any)) > 0;
}

/// A part of the greatest float: sums over nodes stay below that.
constexpr double great_sum = 1e37;

/// Where rays end, and the turns that they may take.
void place_bounds(const View& view, const MediumAtlas& atlas, const RenderOptions& options,
                  MarchSetup& setup) {
  MarchParameters& p = setup.parameters;
  MarchConstants& c = setup.constants;
  // Beyond a depth of 100 nothing is left that a float32 holds, also where rays never end early. Of
  // rays towards a light the last octave has that depth.
  const double last = view.scene.resolved_early_termination();  // transmittance
  const double most = 100 * std::exp2(view.scene.scatter_octaves - 1);
  p.stop_depth = last > 0 ? std::min(-std::log(last), most) : most;
  if (setup.constants.from_back || view.scene.shows(Shows::depth)) p.stop_depth = 1e30;
  const DepthBounds depths = depth_bounds(view.medium, atlas);
  c.ends_early = depths.whole > p.stop_depth;
  if (c.cell_rule) {
    const CellNodes nodes = cell_nodes(depths.cell);
    c.cell_nodes = nodes.nodes;
    c.deep_cells = depths.cell > nodes.depth;
    p.piece_depth = nodes.depth;
    // sums over a cell's nodes are of attenuations times values, luminances, or both
    const double light = brightest_ray(view.medium);
    const double both = c.lit_colors ? depths.greatest * light : 0;
    const double product = depths.of_value * std::max({depths.greatest, light, both});
    c.great_values = product > great_sum;
    // the mean divides it out again; a float has no normal number below 2^-126
    const double unit = std::exp2(std::max(std::floor(std::log2(great_sum / product)), -126.0));
    p.node_unit = c.great_values ? unit : 1;
  }
  double finest = p.step;
  if (c.brick_steps)
    finest *= *std::min_element(options.brick_steps->begin(), options.brick_steps->end());
  p.max_turns = int(std::min(turn_bound(setup, finest), double(std::numeric_limits<int>::max())));
}

}  // namespace

bool has_end_corrections(const View& view) {
  const Scene& scene = view.scene;
  // From vacuum to vacuum there is nothing to correct.
  return scene.end_corrections && scene.resolved_sampling() == Sampling::uniform &&
         !view.medium.transfer && view.medium.emission.empty() && scene.composites() &&
         !info(scene.mode).from_back && scene.resolved_integrator() == Integrator::psi_balanced &&
         (begins_inside(view) || view.medium.density->margin == 0 || scene.clip ||
          scene.clip_plane || view.holdout);
}

MarchSetup make_march_setup(const View& view, const MediumAtlas& atlas,
                            const RenderOptions& options) {
  if (view.medium.light) throw Error(ExitCode::failure, "the view's light is still to be computed");
  const Field& density = *view.medium.density;
  MarchSetup setup;
  setup.tables.assign(1, glm::vec4(0));
  setup.parameters.world_unit = finest_voxel(density);
  setup.constants.count_steps = options.count;
  setup.constants.find_depth = options.depth;
  place_camera(view, make_ray_bundle(view.camera, density, density), setup);
  place_grids(view, atlas, setup);
  place_medium(view, setup);
  place_method(view, atlas, options, setup);
  place_function(view, options, setup);
  place_others(view, atlas, setup);
  place_bounds(view, atlas, options, setup);
  place_passed(options.passed, options.pixels.value_or(PixelBox{}), setup);
  return setup;
}

}  // namespace psivox
