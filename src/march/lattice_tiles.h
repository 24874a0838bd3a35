#pragma once

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <vector>

#include "march/light_lattice.h"

namespace psivox::light_tiles {

/// Depths of 0, of a slice and of a brick.
inline constexpr std::array<double, lattice_depths_of_brick> nothing{};

/// A tile of columns in a slab: its depths in the slice before, and what each of the slab's slices
/// adds to them.
struct Tile {
  const double* before = nothing.data();
  const double* own = nothing.data();

  bool is_clear() const { return before == nothing.data() && own == nothing.data(); }
};

/// Tiles across the light by their numbers, both ends inclusive. A tile is the columns of a brick,
/// which are as many as the voxels of a block.
struct TileRange {
  glm::ivec2 min{0}, max{-1};

  glm::ivec2 size() const { return glm::max(max - min + 1, 0); }
  std::size_t count() const { return std::size_t(size().x) * std::size_t(size().y); }
  bool contains(const glm::ivec2& tile) const { return glm::clamp(tile, min, max) == tile; }
  std::size_t index(const glm::ivec2& tile) const {
    return std::size_t(tile.x - min.x) * std::size_t(size().y) + std::size_t(tile.y - min.y);
  }
  void each(const auto& visit) const {
    for (int x = min.x; x <= max.x; ++x)
      for (int y = min.y; y <= max.y; ++y) visit(glm::ivec2(x, y));
  }
};

TileRange common(const TileRange& a, const TileRange& b);

/// The tiles whose columns meet the domain: no others attenuate.
TileRange tiles_of(const LatticeFrame& frame);

/// Those that a block's voxels are interpolated from.
TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block);

/// Those with columns through cells in a slab.
TileRange tiles_through(const LatticeFrame& frame, const CellCube& cube, int slab);

/// Another volume's voxels in a lattice: the numbers, not whole, of columns along axis_u and axis_v
/// and of slices.
class VoxelPlaces {
 public:
  VoxelPlaces(const LatticeFrame& frame, const glm::dmat4& to_index);

  /// Depth at which columns end.
  double end() const { return end_; }
  glm::dvec3 at(const glm::ivec3& voxel) const { return first_ + steps_ * glm::dvec3(voxel); }
  /// Least and greatest places of a block's voxels.
  std::array<glm::dvec3, 2> of_block(const glm::ivec3& block) const;
  /// The tiles that a block's voxels are interpolated from.
  TileRange tiles_of(const glm::ivec3& block) const;

 private:
  glm::dvec3 first_{0};  ///< place of voxel 0
  glm::dmat3 steps_{1};
  double end_;
};

/// The tiles that a block is interpolated from; of others the depths are 0.
struct BlockTiles {
  TileRange range;
  std::vector<Tile> tiles;  ///< axis_v fastest

  /// The tile of a column.
  Tile of(int i, int j) const {
    const glm::ivec2 at(i >> 3, j >> 3);
    return range.contains(at) ? tiles[range.index(at)] : Tile{};
  }
  bool are_clear() const { return std::ranges::all_of(tiles, &Tile::is_clear); }
};

/// The depths of a block's 512 voxels, z fastest.
void write_depths(const LatticeFrame& frame, const BlockTiles& tiles, const glm::ivec3& block,
                  double* to);

/// Those of a block of another volume, interpolated across columns in the same way, along them by
/// the cubic through four slices or, at a slab's ends, the parabola through three; 0 of voxels that
/// belong to other slabs. `is_last`: of the slabs.
void write_depths(const VoxelPlaces& places, const BlockTiles& tiles, int slab, bool is_last,
                  const glm::ivec3& block, double* to);

}  // namespace psivox::light_tiles
