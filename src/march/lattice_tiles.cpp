#include "march/lattice_tiles.h"

namespace psivox::light_tiles {
namespace {

/// The least and the greatest number, not whole, of the columns through a box between two slices.
std::array<glm::dvec2, 2> columns_between(const LatticeFrame& frame, const glm::dvec2& low,
                                          const glm::dvec2& high, int first_slice, int last_slice) {
  return {glm::min(frame.column(low, first_slice), frame.column(low, last_slice)),
          glm::max(frame.column(high, first_slice), frame.column(high, last_slice))};
}

/// Tiles from which voxels between two columns are interpolated.
TileRange tiles_around(const std::array<glm::dvec2, 2>& columns) {
  return {(glm::ivec2(glm::floor(columns[0])) - 1) >> 3,
          (glm::ivec2(glm::floor(columns[1])) + 2) >> 3};
}

}  // namespace

TileRange common(const TileRange& a, const TileRange& b) {
  return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

TileRange tiles_of(const LatticeFrame& frame) {
  return tiles_around(columns_between(frame, frame.across(frame.domain.min),
                                      frame.across(frame.domain.max), -1, 8 * frame.slabs()));
}

TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block) {
  const glm::dvec2 low(frame.across(block));
  const int first_slice = 8 * frame.slab(block);
  return tiles_around(columns_between(frame, low, low + 7.0, first_slice, first_slice + 7));
}

TileRange tiles_through(const LatticeFrame& frame, const CellCube& cube, int slab) {
  constexpr double rounding = 1e-3;  // of float32
  const glm::dvec2 low(frame.across(cube.corner));
  const int z = cube.corner[frame.axis], far = z + cube.width;
  const int first = std::max(std::min(frame.slice(z), frame.slice(far)), 8 * slab - 1);
  const int last = std::min(std::max(frame.slice(z), frame.slice(far)), 8 * slab + 7);
  const auto [least, most] = columns_between(frame, low, low + double(cube.width), first, last);
  return {glm::ivec2(glm::ceil(least - rounding)) >> 3,
          glm::ivec2(glm::floor(most + rounding)) >> 3};
}

VoxelPlaces::VoxelPlaces(const LatticeFrame& frame, const glm::dmat4& to_index) : end_(frame.end) {
  const auto turned = [&](const glm::dvec3& way) {
    const double slices = -frame.side * way[frame.axis];
    const glm::dvec2 across(way[frame.axis_u], way[frame.axis_v]);
    return glm::dvec3((across + slices * frame.shear) / frame.spacing, slices);
  };
  glm::dvec3 corner;  // of column 0 and slice 0
  corner[frame.axis] = frame.first;
  corner[frame.axis_u] = frame.origin.x;
  corner[frame.axis_v] = frame.origin.y;
  first_ = turned(glm::dvec3(to_index[3]) - corner);
  for (int i = 0; i < 3; ++i) steps_[i] = turned(glm::dvec3(to_index[i]));
}

std::array<glm::dvec3, 2> VoxelPlaces::of_block(const glm::ivec3& block) const {
  glm::dvec3 low = at(block), high = low;
  for (int i = 0; i < 3; ++i) {
    low += glm::min(7.0 * steps_[i], glm::dvec3(0));
    high += glm::max(7.0 * steps_[i], glm::dvec3(0));
  }
  constexpr double rounding = 1e-6;
  return {low - rounding, high + rounding};
}

TileRange VoxelPlaces::tiles_of(const glm::ivec3& block) const {
  const auto [low, high] = of_block(block);
  return tiles_around({glm::dvec2(low), glm::dvec2(high)});
}

}  // namespace psivox::light_tiles
