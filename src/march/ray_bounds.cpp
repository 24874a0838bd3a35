#include "march/ray_bounds.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

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
  if (c.emission_channels) add(p.emission.domain_max - p.emission.domain_min);
  // smooth_part leaves at least (2.8e-3 / (27 * 16))^(1/6) = 0.136 of a piece: a cubic that is not
  // negative and has the integral 0.75 has a q_3 of 27 at most, one between -1/2 and 1/2 one of 16.
  pieces *= 8;
  // Opaque cells are crossed in parts of a depth of 0.75/4/60 at least (see shallow_part), until
  // the depth at which every ray has ended.
  return pieces * cells + 320 * std::min(p.stop_depth, 1e7);
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

/// Largest value that an atlas holds, and 0.
double largest_value(const BrickAtlas& atlas) {
  double most = 0;
  for (const BrickStats& brick : atlas.bricks) most = std::max(most, double(brick.max));
  for (const float constant : atlas.constants) most = std::max(most, double(constant));
  return most;
}

}  // namespace

double turn_bound(const MarchSetup& setup, double finest_step) {
  const MarchParameters& p = setup.parameters;
  const glm::ivec3 size = p.density.domain_max - p.density.domain_min;
  const double cells = double(size.x) + double(size.y) + double(size.z) + 3;
  if (!setup.constants.uniform_sampling) return cell_turns(setup, cells);
  if (setup.constants.template_sampling) return p.template_entries + 2.0;
  return cells + longest_ray(p) / finest_step + 2;
}

double depth_bound(const Medium& medium, const BrickAtlas& density) {
  const double value = largest_value(density);
  // a value in between may have the largest attenuation
  const double attenuation =
      medium.transfer ? medium.transfer->max_attenuation(-std::numeric_limits<double>::max(), value)
                      : value;
  const glm::dmat3 m(medium.density->world_from_index);
  const glm::dvec3 size(density.domain.max - density.domain.min);
  double diagonal = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      diagonal = std::max(diagonal, glm::length(m * (size * glm::dvec3(1, y, z))));
  return medium.extinction * attenuation * diagonal;
}

}  // namespace psivox
