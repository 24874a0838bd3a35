#include "march/light_lattice.h"

#include <algorithm>
#include <functional>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <map>

#include "field/index_space.h"
#include "march/lattice_tiles.h"

namespace psivox {

LatticeFrame::LatticeFrame(const View& view, const MediumAtlas& atlas, const Beam& beam)
    : density(&atlas.density), domain(atlas.density.domain), spacing(beam.method.spacing) {
  const Medium& medium = view.medium;
  const glm::dvec3 towards(glm::inverse(glm::dmat3(medium.density->world_from_index)) *
                           -beam.direction);
  const glm::dvec3 size = glm::abs(towards);
  axis = longest_axis(size);
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
  const Box voxels = voxels_of(bricks);
  part = Box{voxels.min, voxels.max + 1};
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
  if (blocks.placed) slabs.place(light_tiles::WantedBlocks(frame, blocks));
  slabs.add_octants(frame, *frame.density, least, most);
  LatticeRun(frame, slabs, blocks, take).go_on(most, in_part(frame, columns), progress);
}

namespace {

/// Octants of the density's bricks that hide nothing, a bit each; empty where they are not known.
std::vector<std::uint8_t> dark_octants(const BrickAtlas& density) {
  if (!density.own_texels || !density.pages.octants) return {};
  std::vector<std::uint8_t> dark(density.places.size());
  for (const std::uint32_t entry : density.pages.entries)
    if (entry_kind(entry) == EntryKind::brick)
      dark[density.pages.slot(entry)] = std::uint8_t(~(entry_payload(entry) >> entry_slot_bits));
  return dark;
}

}  // namespace

LightSlabs::LightSlabs(const LatticeFrame& frame, const LightBlocks& blocks) {
  std::map<int, LightSlab> slabs;
  const auto slab_of = [&](std::size_t i) -> LightSlab& {
    const int z = blocks.all[i][frame.axis];
    return slabs[std::min(frame.slice(z), frame.slice(z + 7))];
  };
  for (std::size_t i = 0; i < blocks.all.size(); ++i) slab_of(i).blocks.push_back(std::uint32_t(i));
  if (!blocks.placed)
    for (const std::size_t i : blocks.wanted) slab_of(i).wanted.push_back(std::uint32_t(i));
  for (auto& [first_slice, slab] : slabs) {
    slab.first_slice = first_slice;
    std::ranges::stable_sort(slab.wanted, std::less{},
                             [&](std::uint32_t i) { return blocks.all[i][frame.axis_u]; });
    slabs_.push_back(std::move(slab));
  }
}

void LightSlabs::place(const light_tiles::WantedBlocks& wanted) {
  for (std::size_t k = 0; k + 1 < slabs_.size(); ++k) slabs_[k].end = slabs_[k + 1].first_slice - 1;
  for (const std::size_t block : wanted.all()) {
    const glm::dvec2 slices = wanted.slices(block);
    auto slab = std::ranges::lower_bound(slabs_, slices.x, std::less{}, &LightSlab::end);
    for (; slab != slabs_.end() && slab->first_slice - 1 < slices.y; ++slab)
      if (!wanted.tiles(block, *slab).empty()) slab->wanted.push_back(std::uint32_t(block));
  }
  for (LightSlab& slab : slabs_)
    std::ranges::stable_sort(slab.wanted, std::less{},
                             [&](std::uint32_t block) { return wanted.tiles(block, slab).min.x; });
}

void LightSlabs::fill(int end) {
  std::vector<LightSlab> filled;
  std::size_t next = 0;
  for (int first = 0; first < end || next < slabs_.size(); first += 8)
    if (next < slabs_.size() && slabs_[next].first_slice == first)
      filled.push_back(std::move(slabs_[next++]));
    else
      filled.emplace_back().first_slice = first;
  slabs_ = std::move(filled);
}

void LightSlabs::add_octants(const LatticeFrame& frame, const BrickAtlas& density, int begin,
                             int end) {
  const auto slab_from = [&](int slice) {
    return std::ranges::lower_bound(slabs_, slice, std::less{}, &LightSlab::first_slice);
  };
  const std::vector<std::uint8_t> dark = dark_octants(density);
  for (std::size_t k = 0; k < dark.size(); ++k)
    for (int i = 0; i < 8; ++i) {
      if (!(dark[k] >> i & 1)) continue;
      const glm::ivec3 corner = brick_cells * density.places[k] + 4 * cube_corner(i);
      const int z = corner[frame.axis], slice = std::min(frame.slice(z), frame.slice(z + 4));
      // a cell between two slices belongs to the second
      for (int first = std::max((slice + 1) & ~7, begin); first <= slice + 4 && first < end;
           first += 8)
        if (const auto slab = slab_from(first); slab != slabs_.end() && slab->first_slice == first)
          slab->octants.push_back({corner, slice});
    }
}

void LightSlabs::drop_octants() {
  for (LightSlab& slab : slabs_) slab.octants = {};
}

VoxelPlaces::VoxelPlaces(const LatticeFrame& frame, const glm::dmat4& to_index) {
  const auto turned = [&](const glm::dvec3& way) {
    const double slices = -frame.side * way[frame.axis];
    const glm::dvec2 across(way[frame.axis_u], way[frame.axis_v]);
    return glm::dvec3((across + slices * frame.shear) / frame.spacing, slices);
  };
  glm::dvec3 corner;  // of column 0 and slice 0
  corner[frame.axis] = frame.first;
  corner[frame.axis_u] = frame.origin.x;
  corner[frame.axis_v] = frame.origin.y;
  first = turned(glm::dvec3(to_index[3]) - corner);
  for (int i = 0; i < 3; ++i) steps[i] = turned(glm::dvec3(to_index[i]));
}

}  // namespace psivox

namespace psivox::light_tiles {

TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block, int first_slice) {
  const glm::dvec2 low = glm::dvec2(frame.across(block)) - 1.0, high = low + 9.0;
  const glm::dvec2 a = frame.column(low, first_slice), b = frame.column(low, first_slice + 7);
  const glm::dvec2 c = frame.column(high, first_slice), d = frame.column(high, first_slice + 7);
  return {(glm::ivec2(glm::floor(glm::min(a, b))) - 1) >> 3,
          (glm::ivec2(glm::floor(glm::max(c, d))) + 2) >> 3};
}

namespace {

/// Tiles with columns that pass through an octant.
TileRange tiles_through(const LatticeFrame& frame, const Octant& octant) {
  constexpr double rounding = 1e-3;  // of float32
  const glm::dvec2 low(frame.across(octant.corner)), high = low + 4.0;
  const glm::dvec2 a = frame.column(low, octant.slice), b = frame.column(low, octant.slice + 4);
  const glm::dvec2 c = frame.column(high, octant.slice), d = frame.column(high, octant.slice + 4);
  return {glm::ivec2(glm::ceil(glm::min(a, b) - rounding)) >> 3,
          glm::ivec2(glm::floor(glm::max(c, d) + rounding)) >> 3};
}

}  // namespace

WantedBlocks::WantedBlocks(const LatticeFrame& frame, const LightBlocks& blocks)
    : frame_(frame), blocks_(blocks) {
  if (blocks.placed) places_.emplace(frame, blocks.placed->to_index);
}

TileRange WantedBlocks::tiles(std::size_t block, const LightSlab& slab) const {
  if (!places_) return tiles_of(frame_, blocks_.all[block], slab.first_slice);
  const auto [low, high] = places(block);
  // no column attenuates that has not met the domain, from which taps reach two columns
  const glm::dvec2 min(frame_.across(frame_.domain.min)), max(frame_.across(frame_.domain.max));
  const auto column = [&](const glm::dvec2& voxel, int coordinate) {
    return frame_.column(voxel, frame_.slice(coordinate));
  };
  const int a = frame_.domain.min[frame_.axis], b = frame_.domain.max[frame_.axis];
  const glm::dvec2 least = glm::min(column(min, a), column(min, b)) - 2.0;
  const glm::dvec2 most = glm::max(column(max, a), column(max, b)) + 2.0;
  if (glm::any(glm::greaterThan(glm::dvec2(low), most)) ||
      glm::any(glm::lessThan(glm::dvec2(high), least)))
    return {glm::ivec2(0), glm::ivec2(-1)};
  return {(glm::ivec2(glm::floor(glm::max(glm::dvec2(low), least))) - 1) >> 3,
          (glm::ivec2(glm::floor(glm::min(glm::dvec2(high), most))) + 2) >> 3};
}

std::array<glm::dvec3, 2> WantedBlocks::places(std::size_t block) const {
  const glm::dvec3 first = places_->at(blocks_.placed->all[block]);
  glm::dvec3 low = first, high = first;
  for (int i = 0; i < 3; ++i) {
    low += glm::min(7.0 * places_->steps[i], glm::dvec3(0));
    high += glm::max(7.0 * places_->steps[i], glm::dvec3(0));
  }
  return {low, high};
}

glm::dvec2 WantedBlocks::slices(std::size_t block) const {
  const auto [low, high] = places(block);
  return {low.z, high.z};
}

SlabTiles::SlabTiles(const LatticeFrame& frame, const LightSlab& slab,
                     std::span<const glm::ivec3> all, const TileNumbers* last, bool from_light,
                     const WantedBlocks* placed)
    : slab_(slab) {
  find_tiles(frame, all, last, from_light, placed);
  find_dark(frame);
  depths_.resize(tiles_.size(), nullptr);
}

void SlabTiles::find_tiles(const LatticeFrame& frame, std::span<const glm::ivec3> all,
                           const TileNumbers* last, bool from_light, const WantedBlocks* placed) {
  if (from_light) {
    for (const auto& [tile, slab] : *last)
      if (slab >= slab_.first_slice) tiles_.push_back(tile);
  } else {
    const auto add = [&](const TileRange& range) {
      for (int x = range.min.x; x <= range.max.x; ++x)
        for (int y = range.min.y; y <= range.max.y; ++y)
          if (is_needed({x, y}, last) && index_.try_emplace({x, y}, 0).second)
            tiles_.emplace_back(x, y);
    };
    for (const std::uint32_t block : slab_.blocks)
      add(tiles_of(frame, all[block], slab_.first_slice));
    if (placed)
      for (const std::uint32_t block : slab_.wanted) add(placed->tiles(block, slab_));
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
    const TileRange range = tiles_through(frame, octant);
    for (int x = range.min.x; x <= range.max.x; ++x)
      for (int y = range.min.y; y <= range.max.y; ++y)
        if (const auto tile = index_.find({x, y}); tile != index_.end())
          dark_[std::size_t(tile->second)] = true;
  }
}

bool SlabTiles::is_needed(const glm::ivec2& tile, const TileNumbers* last) const {
  if (!last) return true;
  const auto found = last->find(tile);
  return found != last->end() && found->second >= slab_.first_slice;
}

}  // namespace psivox::light_tiles
