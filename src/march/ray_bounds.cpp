#include "march/march_parameters.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/text.h"
#include "field/index_space.h"
#include "march/glsl_subset.h"
#include "psivox/error.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Turns under cells: of the cells that a ray crosses, each in pieces.
double cell_turns(const MarchSetup& setup, double cells) {
  const MarchParameters& p = setup.parameters;
  const MarchConstants& c = setup.constants;
  // A cell is cut where the value turns and where it crosses a knot, at most thrice each.
  double pieces = c.split_knots ? 3 + 3.0 * p.transfer_knots : 1;
  if (!c.cell_rule) return pieces * cells;
  // It is cut at other grids' faces, too.
  const auto add = [&](const glm::ivec3& extent) { cells += extent.x + extent.y + extent.z + 3; };
  if (c.luminance_source == int(LuminanceSource::scalar) ||
      c.luminance_source == int(LuminanceSource::vector))
    add(p.luminance.domain_max - p.luminance.domain_min);
#define GRID(id, name) \
  if (id >= emission_grid && c.name##_channels > 0) add(p.name.domain_max - p.name.domain_min);
#include "grids.glsl"
#undef GRID
  for (int i = 0; i < c.other_volumes; ++i) {
    const glm::vec4* entries = &setup.tables[std::size_t(p.others_first + i * other_entries)];
    add(glm::ivec3(entries[9]) - glm::ivec3(entries[8]));
  }
  // Deep cells are crossed in parts that hold at least a 240th of what they may (see shallow_part),
  // until the depth at which every ray has ended.
  return pieces * cells + 240 / p.piece_depth * std::min(p.stop_depth, 1e7);
}

/// Length of the longest ray [unit of t]: the domain's diagonal over the least speed in voxels.
double longest_ray(const MarchParameters& p) {
  const glm::dvec3 size(p.density.domain_max - p.density.domain_min);
  const glm::dmat3 m(p.density.direction_u, p.density.direction_v, p.density.direction_0);
  double slowest = std::numeric_limits<double>::max();
  for (const double u : {-1.0, 0.0, 1.0})
    for (const double v : {-1.0, 0.0, 1.0}) {
      const glm::dvec3 w = p.world_0 + p.world_u * u + p.world_v * v;
      slowest = std::min(slowest, glm::length(m * glm::dvec3(u, v, 1.0)) / glm::length(w));
    }
  // The direction varies inside the picture; a factor 2 covers what its nine points miss.
  return 2 * glm::length(size) / slowest;
}

}  // namespace

double greatest_value(const BrickAtlas& atlas) {
  double most = 0;
  for (const BrickStats& brick : atlas.bricks) most = std::max(most, double(brick.max));
  for (const float constant : atlas.constants) most = std::max(most, double(constant));
  return most;
}

double turn_bound(const MarchSetup& setup, double finest_step) {
  const MarchParameters& p = setup.parameters;
  const glm::ivec3 size = p.density.domain_max - p.density.domain_min;
  const double cells = double(size.x) + double(size.y) + double(size.z) + 3;
  if (!setup.constants.uniform_sampling) return cell_turns(setup, cells);
  if (setup.constants.template_sampling) return p.template_entries + 2.0;
  return cells + longest_ray(p) / finest_step + 2;
}

void check_sampling(const View& view) {
  const Medium& medium = view.medium;
  const Field& density = *medium.density;
  const bool others =
      !medium.emission.empty() ||
      (medium.luminance && medium.luminance->world_from_index != density.world_from_index);
  if (view.scene.resolved_sampling() == Sampling::template_ && others)
    throw Error(ExitCode::usage,
                "--sampling template reads the density's voxels; another grid must have the same "
                "transform, and none may emit; use --sampling uniform");
  if (view.scene.resolved_sampling() != Sampling::uniform || density.active_box.empty()) return;
  const Box domain = density.domain();
  // A ray's times are up to about this far from 0, which is beside the domain's middle or at the
  // eye.
  const double farthest =
      diagonal_of(density, domain.max - domain.min) / finest_voxel(density);  // [voxels]
  const double least = std::ldexp(farthest, -24);
  if (view.scene.resolved_step() >= least) return;
  throw Error(ExitCode::usage,
              "--step " + number_text(view.scene.resolved_step()) +
                  " is too short for the float32 numbers along a ray; give at least " +
                  formatted("%.3g", 1.005 * least));
}

DepthBounds depth_bounds(const Medium& medium, const MediumAtlas& atlas) {
  const double value = atlas.greatest ? *atlas.greatest : greatest_value(atlas.density);
  // a value in between may have the largest attenuation
  const double attenuation =
      medium.transfer ? medium.transfer->max_attenuation(-std::numeric_limits<double>::max(), value)
                      : value;
  double per_length = medium.extinction * attenuation;
  const double way =
      diagonal_of(*medium.density, atlas.density.domain.max - atlas.density.domain.min);
  const glm::dvec3 one(1);
  // beside other volumes a run of one value is one piece
  const bool runs = !medium.others.empty() &&
                    std::ranges::any_of(atlas.density.constants, [](float v) { return v > 0; });
  double cell = per_length * (runs ? way : diagonal_of(*medium.density, one));
  for (const PlacedOther& other : atlas.placed_in(medium)) {
    const Medium& volume = medium.others[other.volume];
    const double depth = volume.extinction * other.greatest;
    per_length += depth;
    cell += depth * (other.constants > 0 ? way : diagonal_of(*volume.density, one));
  }
  return {per_length * way, cell, attenuation, value};
}

CellNodes cell_nodes(double cell_depth) {
  constexpr CellNodes choices[] = {{4, 1.5}, {6, 6}, {8, 12}};
  for (const CellNodes& choice : choices)
    if (cell_depth <= choice.depth) return choice;
  return choices[2];
}

}  // namespace psivox
