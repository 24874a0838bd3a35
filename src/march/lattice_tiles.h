#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vector_relational.hpp>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "march/light_lattice.h"

namespace psivox {

namespace light_tiles {
class WantedBlocks;
}

/// 4^3 cells with attenuation: their first corner, and the first slice that they reach.
struct Octant {
  glm::ivec3 corner;
  int slice;
};

/// Another volume's voxels in a lattice: the numbers, not whole, of columns along axis_u and axis_v
/// and of slices.
struct VoxelPlaces {
  glm::dvec3 first{0};  ///< of voxel 0
  glm::dmat3 steps{1};

  VoxelPlaces(const LatticeFrame& frame, const glm::dmat4& to_index);
  glm::dvec3 at(const glm::ivec3& voxel) const { return first + steps * glm::dvec3(voxel); }
};

/// The blocks of 8 slices.
struct LightSlab {
  int first_slice = 0;
  /// Another volume's voxels belong to the slab up to this slice; behind its own 8 nothing
  /// attenuates.
  double end = HUGE_VAL;
  std::vector<std::uint32_t> blocks, wanted;  ///< their places among all, wanted ones along axis_u
  std::vector<Octant> octants;                ///< with attenuation; empty: not known
};

/// Blocks by slabs, in the order in which light meets them. All lights along the same axis from the
/// same side have the same.
class LightSlabs {
 public:
  LightSlabs(const LatticeFrame& frame, const LightBlocks& blocks);

  const std::vector<LightSlab>& all() const { return slabs_; }
  /// Adds another volume's blocks to the slabs that they reach into.
  void place(const light_tiles::WantedBlocks& wanted);
  /// Adds slabs without blocks, so that there is one for each 8 slices before `end`.
  void fill(int end);
  /// Adds the octants of an atlas to the slabs whose first slice is in [begin, end).
  void add_octants(const LatticeFrame& frame, const BrickAtlas& density, int begin, int end);
  /// Forgets them.
  void drop_octants();

 private:
  std::vector<LightSlab> slabs_;
};

}  // namespace psivox

namespace psivox::light_tiles {

/// A hash of a tile's numbers.
struct ColumnHash {
  std::size_t operator()(const glm::ivec2& v) const {
    const std::uint64_t key =
        std::uint64_t(std::uint32_t(v.x)) << 32 | std::uint64_t(std::uint32_t(v.y));
    return std::size_t((key * 0x9E3779B97F4A7C15ull) >> 17);
  }
};

/// Tiles across the light by their numbers, both ends inclusive. A tile is the columns of a brick,
/// which are as many as the voxels of a block.
struct TileRange {
  glm::ivec2 min, max;
  glm::ivec2 size() const { return max - min + 1; }
  bool empty() const { return glm::any(glm::lessThan(max, min)); }
};

/// Tiles that a block's voxels are interpolated from, and the tiles around them that are reached by
/// cells with a corner in the block.
TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block, int first_slice);

using TileNumbers = std::unordered_map<glm::ivec2, int, ColumnHash>;

class SlabTiles;

/// The blocks whose depths a lattice finds.
class WantedBlocks {
 public:
  /// Frame and blocks must outlive it.
  WantedBlocks(const LatticeFrame& frame, const LightBlocks& blocks);

  std::span<const std::size_t> all() const { return blocks_.wanted; }
  bool placed() const { return places_.has_value(); }
  /// Tiles that a block is interpolated from in a slab.
  TileRange tiles(std::size_t block, const LightSlab& slab) const;
  /// First and last slice of a block of another volume, not whole.
  glm::dvec2 slices(std::size_t block) const;
  /// A block's 512 depths from a slab's tiles, z fastest; those of voxels that lie in other slabs
  /// are 0.
  void depths(std::size_t block, const SlabTiles& slab, double* to) const;

 private:
  /// Least and greatest places of the voxels of a block of another volume.
  std::array<glm::dvec3, 2> places(std::size_t block) const;

  const LatticeFrame& frame_;
  LightBlocks blocks_;
  std::optional<VoxelPlaces> places_;
};

/// A slab's tiles on their way from columns to depths at voxels, row by row of tiles.
class SlabTiles {
 public:
  /// `last` has the last slab that needs each tile; null: all tiles of the slab's blocks are
  /// needed. `from_light`: tiles are needed from the light on, not only where the slab has blocks.
  /// `placed`: blocks of another volume, which need tiles beside those.
  SlabTiles(const LatticeFrame& frame, const LightSlab& slab, std::span<const glm::ivec3> all,
            const TileNumbers* last, bool from_light, const WantedBlocks* placed = nullptr);

  int first_slice() const { return slab_.first_slice; }
  const LightSlab& slab() const { return slab_; }
  const std::vector<glm::ivec2>& tiles() const { return tiles_; }
  /// Whether something attenuates in a tile's brick.
  bool is_dark(std::size_t tile) const { return dark_.empty() || dark_[tile]; }
  LatticeBrick brick(std::size_t tile) const {
    return {lattice_columns * tiles_[tile], slab_.first_slice};
  }
  /// Depths of a tile whose row has them: of its slices, and before these of the last slice of the
  /// slab before.
  const double* depths(const glm::ivec2& tile) const {
    return depths_[std::size_t(index_.at(tile))];
  }
  void set_depths(std::size_t tile, const double* depths) { depths_[tile] = depths; }

  /// Number of the next wanted block.
  std::size_t done = 0;

 private:
  void find_tiles(const LatticeFrame& frame, std::span<const glm::ivec3> all,
                  const TileNumbers* last, bool from_light, const WantedBlocks* placed);
  /// Finds which tiles are dark, if octants are known.
  void find_dark(const LatticeFrame& frame);
  bool is_needed(const glm::ivec2& tile, const TileNumbers* last) const;

  const LightSlab& slab_;
  std::vector<glm::ivec2> tiles_;      ///< in numbers of tiles, each once, row by row
  TileNumbers index_;                  ///< of tiles_
  std::vector<bool> dark_;             ///< each tile; empty: not known
  std::vector<const double*> depths_;  ///< of each tile, while its row has them
};

}  // namespace psivox::light_tiles
