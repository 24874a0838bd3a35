#include "march/light_lattice.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <limits>

#include "march/lattice_run.h"

namespace psivox {

LatticeFrame::LatticeFrame(const View& view, const MediumAtlas& atlas, const Beam& beam)
    : density(&atlas.density), domain(atlas.density.domain), spacing(beam.method.spacing) {
  const Medium& medium = view.medium;
  const glm::dvec3 towards(glm::inverse(glm::dmat3(medium.density->world_from_index)) *
                           -beam.direction);
  const glm::dvec3 size = glm::abs(towards);
  axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  axis_u = axis == 0 ? 1 : 0;
  axis_v = axis == 2 ? 1 : 2;
  side = towards[axis] > 0 ? 1 : -1;
  first = side > 0 ? domain.max[axis] | 7 : domain.min[axis] & ~7;
  shear = glm::dvec2(towards[axis_u], towards[axis_v]) / size[axis];
  origin = glm::dvec2(across(domain.min));
  length = 1 / size[axis];
  if (atlas.part) set_part(*atlas.part);
}

void LatticeFrame::set_part(const Box& bricks) {
  constexpr glm::ivec3 most(1 << 27);  // the outermost regions reach farther than there are voxels
  part = Box{8 * glm::max(bricks.min, -most), 8 * glm::min(bricks.max, most) + 8};
}

bool LatticeFrame::meets_part(const LatticeBrick& brick) const {
  const glm::dvec2 slices(brick.z - 1, brick.z + 7);
  const glm::dvec2 along = double(first) - double(side) * slices;
  if (std::max(along.x, along.y) < part->min[axis] || std::min(along.x, along.y) > part->max[axis])
    return false;
  const glm::dvec2 low = origin + spacing * glm::dvec2(brick),
                   high = low + (lattice_columns - 1) * spacing;
  const glm::dvec2 a = slices.x * shear, b = slices.y * shear;
  const glm::dvec2 least = low - glm::max(a, b), most = high - glm::min(a, b);
  return glm::all(glm::lessThanEqual(least, glm::dvec2(across(part->max)))) &&
         glm::all(glm::greaterThanEqual(most, glm::dvec2(across(part->min))));
}

void lattice_depths(const LatticeFrame& frame, const LightBlocks& blocks,
                    const LatticeColumns& columns, const TakeDepths& take,
                    const Progress& progress) {
  constexpr int least = std::numeric_limits<int>::min(), most = std::numeric_limits<int>::max();
  LightSlabs slabs(frame, blocks);
  slabs.add_octants(frame, *frame.density, least, most);
  LatticeRun(frame, slabs, blocks, take).go_on(most, in_part(frame, columns), progress);
}

}  // namespace psivox
