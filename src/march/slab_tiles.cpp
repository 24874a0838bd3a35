#include "march/slab_tiles.h"

#include <algorithm>

namespace psivox::lattice {

TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block, int first_slice) {
  const glm::dvec2 low = glm::dvec2(frame.across(block)) - 1.0, high = low + 9.0;
  const glm::dvec2 a = frame.column(low, first_slice), b = frame.column(low, first_slice + 7);
  const glm::dvec2 c = frame.column(high, first_slice), d = frame.column(high, first_slice + 7);
  return {(glm::ivec2(glm::floor(glm::min(a, b))) - 1) >> 3,
          (glm::ivec2(glm::floor(glm::max(c, d))) + 2) >> 3};
}

namespace {

/// Bricks with columns that pass through an octant.
TileRange bricks_through(const LatticeFrame& frame, const Octant& octant) {
  constexpr double rounding = 1e-3;  // of float32
  const glm::dvec2 low(frame.across(octant.corner)), high = low + 4.0;
  const glm::dvec2 a = frame.column(low, octant.slice), b = frame.column(low, octant.slice + 4);
  const glm::dvec2 c = frame.column(high, octant.slice), d = frame.column(high, octant.slice + 4);
  return {glm::ivec2(glm::ceil(glm::min(a, b) - rounding)) >> 2,
          glm::ivec2(glm::floor(glm::max(c, d) + rounding)) >> 2};
}

}  // namespace

SlabTiles::SlabTiles(const LatticeFrame& frame, const LightSlab& slab,
                     std::span<const glm::ivec3> all, const TileNumbers* last)
    : slab_(slab) {
  find_tiles(frame, all, last);
  find_dark(frame);
  depths_.resize(tiles_.size(), nullptr);
}

void SlabTiles::find_tiles(const LatticeFrame& frame, std::span<const glm::ivec3> all,
                           const TileNumbers* last) {
  for (const std::uint32_t block : slab_.blocks) {
    const TileRange range = tiles_of(frame, all[block], slab_.first_slice);
    for (int x = range.min.x; x <= range.max.x; ++x)
      for (int y = range.min.y; y <= range.max.y; ++y)
        if (is_needed({x, y}, last) && index_.try_emplace({x, y}, 0).second)
          tiles_.emplace_back(x, y);
  }
  std::ranges::sort(tiles_, [](const glm::ivec2& a, const glm::ivec2& b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
  });
  for (std::size_t i = 0; i < tiles_.size(); ++i) index_[tiles_[i]] = int(i);
}

void SlabTiles::find_dark(const LatticeFrame& frame) {
  if (slab_.octants.empty()) return;
  dark_.resize(tiles_.size());
  for (const Octant& octant : slab_.octants) {
    const TileRange range = bricks_through(frame, octant);
    for (int x = range.min.x; x <= range.max.x; ++x)
      for (int y = range.min.y; y <= range.max.y; ++y)
        if (const auto tile = index_.find({x >> 1, y >> 1}); tile != index_.end())
          dark_[std::size_t(tile->second)] |= std::uint8_t(1 << (2 * (x & 1) + (y & 1)));
  }
}

bool SlabTiles::is_needed(const glm::ivec2& tile, const TileNumbers* last) const {
  if (!last) return true;
  const auto found = last->find(tile);
  return found != last->end() && found->second >= slab_.first_slice;
}

}  // namespace psivox::lattice
