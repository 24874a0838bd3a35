#include "march/light_lattice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <unordered_map>

#include "march/march_parameters.h"

namespace psivox {
namespace {

/// Columns whose depths a voxel's is interpolated from, along each axis: a cubic through the four
/// (Catmull and Rom 1974), the voxel between the middle two.
constexpr int taps = 4;
/// Bricks that are asked for at once.
constexpr std::size_t bricks_at_once = 4096;
/// A tile is four bricks, 8 x 8 columns: as wide as blocks of voxels.
constexpr int tile_columns = 64, tile_depths = 512;
static_assert(tile_columns == 4 * lattice_columns * lattice_columns);

struct ColumnHash {
  std::size_t operator()(const glm::ivec2& v) const {
    const std::uint64_t key =
        std::uint64_t(std::uint32_t(v.x)) << 32 | std::uint64_t(std::uint32_t(v.y));
    return std::size_t((key * 0x9E3779B97F4A7C15ull) >> 17);
  }
};

/// First of the taps along one axis, and their weights.
struct Tap {
  int first = 0;
  std::array<double, taps> weights{};

  Tap() = default;
  explicit Tap(double at) {
    const double below = std::floor(at);
    const double f = at - below, f2 = f * f, f3 = f2 * f;
    first = int(below) - 1;
    weights = {-0.5 * f + f2 - 0.5 * f3, 1 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2 * f2 - 1.5 * f3,
               -0.5 * f2 + 0.5 * f3};
  }
};

/// Of tiles or bricks across the light, both ends inclusive, in their numbers.
struct TileRange {
  glm::ivec2 min, max;
  glm::ivec2 size() const { return max - min + 1; }
};

/// Tiles that the voxels of a block are interpolated from, and those around them that the cells
/// reach into which the block's voxels are corners of.
TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block, int first_slice) {
  const glm::dvec2 low = glm::dvec2(frame.across(block)) - 1.0, high = low + 9.0;
  const glm::dvec2 a = frame.column(low, first_slice), b = frame.column(low, first_slice + 7);
  const glm::dvec2 c = frame.column(high, first_slice), d = frame.column(high, first_slice + 7);
  return {(glm::ivec2(glm::floor(glm::min(a, b))) - 1) >> 3,
          (glm::ivec2(glm::floor(glm::max(c, d))) + 2) >> 3};
}

/// 4^3 cells with attenuation: their first corner, and the first slice that they reach.
struct Octant {
  glm::ivec3 corner;
  int slice;
};

/// Bricks with columns that pass through an octant.
TileRange bricks_through(const LatticeFrame& frame, const Octant& octant) {
  constexpr double rounding = 1e-3;  // of float32
  const glm::dvec2 low(frame.across(octant.corner)), high = low + 4.0;
  const glm::dvec2 a = frame.column(low, octant.slice), b = frame.column(low, octant.slice + 4);
  const glm::dvec2 c = frame.column(high, octant.slice), d = frame.column(high, octant.slice + 4);
  return {glm::ivec2(glm::ceil(glm::min(a, b) - rounding)) >> 2,
          glm::ivec2(glm::floor(glm::max(c, d) + rounding)) >> 2};
}

using TileNumbers = std::unordered_map<glm::ivec2, int, ColumnHash>;

/// The blocks of one slab across the light, and its tiles.
struct Slab {
  int first_slice = 0;
  std::vector<std::size_t> blocks, wanted;  ///< their places among all
  std::vector<glm::ivec2> tiles;            ///< in numbers of tiles, each once
  TileNumbers index;                        ///< of `tiles`
  std::vector<Octant> octants;              ///< with attenuation
  /// Of each tile a bit for each brick in which something attenuates; empty: not known.
  std::vector<std::uint8_t> dark;

  /// `last`: of each tile that is needed, the last slab that is; null: all are.
  void find_tiles(const LatticeFrame& frame, std::span<const glm::ivec3> all,
                  const TileNumbers* last) {
    for (const std::size_t block : blocks) {
      const TileRange range = tiles_of(frame, all[block], first_slice);
      for (int x = range.min.x; x <= range.max.x; ++x)
        for (int y = range.min.y; y <= range.max.y; ++y)
          if (is_needed({x, y}, last) && index.try_emplace({x, y}, int(tiles.size())).second)
            tiles.emplace_back(x, y);
    }
  }

  /// Finds which bricks are dark, if octants are known.
  void find_dark(const LatticeFrame& frame) {
    if (octants.empty()) return;
    dark.resize(tiles.size());
    for (const Octant& octant : octants) {
      const TileRange range = bricks_through(frame, octant);
      for (int x = range.min.x; x <= range.max.x; ++x)
        for (int y = range.min.y; y <= range.max.y; ++y)
          if (const auto tile = index.find({x >> 1, y >> 1}); tile != index.end())
            dark[std::size_t(tile->second)] |= std::uint8_t(1 << (2 * (x & 1) + (y & 1)));
    }
  }
  bool is_dark(std::size_t tile, int brick) const {
    return dark.empty() || (dark[tile] >> brick & 1) != 0;
  }

 private:
  bool is_needed(const glm::ivec2& tile, const TileNumbers* last) const {
    if (!last) return true;
    const auto found = last->find(tile);
    return found != last->end() && found->second >= first_slice;
  }
};

/// Octants of the density's bricks that hide nothing, a bit each; empty where they are not known.
std::vector<std::uint8_t> dark_octants(const BrickAtlas& density) {
  if (!density.own_texels || !density.pages.octants) return {};
  std::vector<std::uint8_t> dark(density.places.size());
  for (const std::uint32_t entry : density.pages.entries)
    if (entry_kind(entry) == EntryKind::brick)
      dark[density.pages.slot(entry)] = std::uint8_t(~(entry_payload(entry) >> entry_slot_bits));
  return dark;
}

/// Adds the octants with attenuation to the slabs of their cells. A cell between two slices belongs
/// to the second.
void add_octants(const LatticeFrame& frame, std::map<int, Slab>& slabs) {
  const std::vector<std::uint8_t> dark = dark_octants(*frame.density);
  for (std::size_t k = 0; k < dark.size(); ++k)
    for (int i = 0; i < 8; ++i) {
      if (!(dark[k] >> i & 1)) continue;
      const glm::ivec3 corner =
          brick_cells * frame.density->places[k] + 4 * glm::ivec3(i >> 2, i >> 1 & 1, i & 1);
      const int z = corner[frame.axis], slice = std::min(frame.slice(z), frame.slice(z + 4));
      for (int first = (slice + 1) & ~7; first <= slice + 4; first += 8)
        if (const auto slab = slabs.find(first); slab != slabs.end())
          slab->second.octants.push_back({corner, slice});
    }
}

/// Slabs in the order in which light meets them.
std::vector<Slab> slabs_of(const LatticeFrame& frame, const LightBlocks& blocks) {
  std::map<int, Slab> slabs;
  const auto slab_of = [&](std::size_t i) -> Slab& {
    const int z = blocks.all[i][frame.axis];
    return slabs[std::min(frame.slice(z), frame.slice(z + 7))];
  };
  for (std::size_t i = 0; i < blocks.all.size(); ++i) slab_of(i).blocks.push_back(i);
  for (const std::size_t i : blocks.wanted) slab_of(i).wanted.push_back(i);
  add_octants(frame, slabs);
  std::vector<Slab> in_order;
  for (auto& [first_slice, slab] : slabs) {
    slab.first_slice = first_slice;
    in_order.push_back(std::move(slab));
  }
  return in_order;
}

/// Of each tile that wanted blocks are interpolated from, the first slice of the last such slab.
TileNumbers last_slabs(const LatticeFrame& frame, std::span<const glm::ivec3> all,
                       std::span<const Slab> slabs) {
  TileNumbers last;
  for (const Slab& slab : slabs)
    for (const std::size_t block : slab.wanted) {
      const TileRange range = tiles_of(frame, all[block], slab.first_slice);
      for (int x = range.min.x; x <= range.max.x; ++x)
        for (int y = range.min.y; y <= range.max.y; ++y) last[{x, y}] = slab.first_slice;
    }
  return last;
}

/// Columns from the light to a slab and through it.
class Columns {
 public:
  /// Makes `own`, depths from the start of each dark brick, depths of all tiles from the light on,
  /// ordered by slice, axis_v fastest. Returns the rest of `own`, which is not of this slab.
  std::span<const double> join(const Slab& slab, std::span<const double> own,
                               std::span<double> depths) {
    std::vector<Carry*> carries;
    std::vector<Starts> starts(slab.tiles.size());
    for (std::size_t i = 0; i < slab.tiles.size(); ++i) {
      carries.push_back(&carries_[slab.tiles[i]]);
      for (int brick = 0; brick < 4; ++brick) {
        if (!slab.is_dark(i, brick)) continue;
        starts[i][std::size_t(brick)] = own.data();
        own = own.subspan(lattice_depths_of_brick);
      }
    }
    tbb::parallel_for(std::size_t{0}, slab.tiles.size(), [&](std::size_t i) {
      add(*carries[i], starts[i], depths.data() + i * tile_depths);
    });
    return own;
  }

 private:
  using Carry = std::array<double, tile_columns>;
  using Starts = std::array<const double*, 4>;  ///< of a tile's bricks; null: not dark

  static void add(Carry& carry, const Starts& starts, double* to) {
    for (int column = 0; column < tile_columns; ++column) {
      const int u = column >> 3, v = column & 7, inside = (u & 3) * lattice_columns + (v & 3);
      const double* own = starts[std::size_t(2 * (u >> 2) + (v >> 2))];
      double& carried = carry[std::size_t(column)];
      for (int slice = 0; slice < lattice_slices; ++slice)
        to[slice * tile_columns + column] =
            own ? carried + own[inside * lattice_slices + slice] : carried;
      carried = to[(lattice_slices - 1) * tile_columns + column];
    }
  }

  std::unordered_map<glm::ivec2, Carry, ColumnHash> carries_;
};

/// Interpolates the voxels of one block.
class BlockDepths {
 public:
  BlockDepths(const LatticeFrame& frame, const Slab& slab, std::span<const double> depths,
              const glm::ivec3& block)
      : frame_(frame),
        range_(tiles_of(frame, block, slab.first_slice)),
        block_(block),
        first_slice_(slab.first_slice) {
    for (int x = range_.min.x; x <= range_.max.x; ++x)
      for (int y = range_.min.y; y <= range_.max.y; ++y)
        tiles_.push_back(depths.data() + std::size_t(slab.index.at({x, y})) * tile_depths);
  }

  /// 512 depths, z fastest.
  void write(double* to) {
    for (int n = 0; n < 8; ++n) write_slice(n, to);
  }

 private:
  /// Depths of columns [first, last] of slice n, axis_v fastest.
  void gather(int n, const glm::ivec2& first, const glm::ivec2& size) {
    patch_.resize(std::size_t(size.x) * std::size_t(size.y));
    double* to = patch_.data();
    const glm::ivec2 tiles = range_.size();
    for (int i = first.x; i < first.x + size.x; ++i) {
      const int row = ((i >> 3) - range_.min.x) * tiles.y - range_.min.y;
      for (int j = first.y; j < first.y + size.y; ++j)
        *to++ = tiles_[std::size_t(row + (j >> 3))][(n * 8 + (i & 7)) * 8 + (j & 7)];
    }
  }

  void write_slice(int n, double* to) {
    const int slice = first_slice_ + n;
    std::array<Tap, 8> u, v;
    const glm::dvec2 corner(frame_.across(block_));
    for (std::size_t i = 0; i < 8; ++i) {
      const glm::dvec2 column = frame_.column(corner + double(i), slice);
      u[i] = Tap(column.x);
      v[i] = Tap(column.y);
    }
    const glm::ivec2 first(u.front().first, v.front().first);
    const glm::ivec2 size = glm::ivec2(u.back().first, v.back().first) + taps - first;
    gather(n, first, size);
    rows_.resize(std::size_t(size.x) * 8);
    for (int i = 0; i < size.x; ++i)
      for (int y = 0; y < 8; ++y)
        rows_[std::size_t(8 * i + y)] =
            filtered(patch_.data() + i * size.y, 1, first.y, v[std::size_t(y)]);
    glm::ivec3 voxel;
    voxel[frame_.axis] = frame_.side > 0 ? 7 - n : n;
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y) {
        voxel[frame_.axis_u] = x;
        voxel[frame_.axis_v] = y;
        to[(voxel.x * 8 + voxel.y) * 8 + voxel.z] =
            filtered(rows_.data() + y, 8, first.x, u[std::size_t(x)]);
      }
  }

  static double filtered(const double* values, int stride, int first, const Tap& tap) {
    const double* from = values + (tap.first - first) * stride;
    double sum = 0;
    for (int k = 0; k < taps; ++k) sum += tap.weights[std::size_t(k)] * from[k * stride];
    return sum;
  }

  const LatticeFrame& frame_;
  TileRange range_;
  glm::ivec3 block_;
  int first_slice_;
  std::vector<const double*> tiles_;  ///< of range_, axis_v fastest
  std::vector<double> patch_, rows_;
};

/// Asks for those bricks alone that meet the atlas's part.
void columns_of_part(const LatticeFrame& frame, std::span<const LatticeBrick> bricks,
                     const LatticeColumns& columns, std::span<double> depths) {
  std::vector<LatticeBrick> near;
  for (const LatticeBrick& brick : bricks)
    if (frame.meets_part(brick)) near.push_back(brick);
  std::vector<double> found(near.size() * lattice_depths_of_brick);
  if (!near.empty()) columns(near, found);
  const double* next = found.data();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    double* to = depths.data() + i * lattice_depths_of_brick;
    if (!frame.meets_part(bricks[i])) {
      std::fill_n(to, lattice_depths_of_brick, 0.0);
      continue;
    }
    std::copy_n(next, lattice_depths_of_brick, to);
    next += lattice_depths_of_brick;
  }
}

}  // namespace

LatticeFrame::LatticeFrame(const View& view, const MediumAtlas& atlas, const Beam& beam)
    : density(&atlas.density), spacing(beam.method.spacing) {
  const Medium& medium = view.medium;
  const Box& domain = atlas.density.domain;
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
  if (!atlas.part) return;
  constexpr glm::ivec3 most(1 << 27);  // the outermost regions reach farther than there are voxels
  part = Box{8 * glm::max(atlas.part->min, -most), 8 * glm::min(atlas.part->max, most) + 8};
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

void LatticeFrame::place(MarchSetup& setup) const {
  MarchParameters& p = setup.parameters;
  p.lattice_anchor = p.lattice_u = p.lattice_v = p.lattice_step = glm::dvec3(0);
  p.lattice_anchor[axis] = double(first - setup.origin[axis]);
  p.lattice_anchor[axis_u] = origin.x - double(setup.origin[axis_u]);
  p.lattice_anchor[axis_v] = origin.y - double(setup.origin[axis_v]);
  p.lattice_u[axis_u] = spacing;
  p.lattice_v[axis_v] = spacing;
  p.lattice_step[axis] = double(-side);
  p.lattice_step[axis_u] = -shear.x;
  p.lattice_step[axis_v] = -shear.y;
  p.lattice_length = length / p.world_unit;
  // Look-ups along a column are as near as columns are: between faces of cells an error of either
  // kind falls with the fourth power, across them with the second.
  p.lattice_parts = std::max(1, int(std::lround(0.5 / spacing)));
}

void lattice_depths(const LatticeFrame& frame, const LightBlocks& blocks,
                    const LatticeColumns& columns, const TakeDepths& take,
                    const Progress& progress) {
  std::vector<Slab> slabs = slabs_of(frame, blocks);
  Columns joined;
  std::vector<double> found, depths;
  std::optional<TileNumbers> last;
  if (take && blocks.wanted.size() < blocks.all.size()) last = last_slabs(frame, blocks.all, slabs);
  for (std::size_t next = 0; next < slabs.size();) {
    // several thin slabs at once: a device works on many bricks alike
    std::vector<LatticeBrick> bricks;
    const std::size_t begin = next;
    while (next < slabs.size() && bricks.size() < bricks_at_once) {
      Slab& slab = slabs[next++];
      slab.find_tiles(frame, blocks.all, last ? &*last : nullptr);
      slab.find_dark(frame);
      for (std::size_t i = 0; i < slab.tiles.size(); ++i)
        for (int brick = 0; brick < 4; ++brick)
          if (slab.is_dark(i, brick))
            bricks.emplace_back(8 * slab.tiles[i].x + 4 * (brick >> 1),
                                8 * slab.tiles[i].y + 4 * (brick & 1), slab.first_slice);
    }
    found.resize(std::max(found.size(), bricks.size() * lattice_depths_of_brick));
    std::span<double> own = std::span(found).first(bricks.size() * lattice_depths_of_brick);
    if (frame.part)
      columns_of_part(frame, bricks, columns, own);
    else
      columns(bricks, own);
    if (!take) continue;
    std::span<const double> left = own;
    for (std::size_t l = begin; l < next; ++l) {
      Slab& slab = slabs[l];
      depths.resize(std::max(depths.size(), slab.tiles.size() * tile_depths));
      left = joined.join(slab, left, depths);
      tbb::parallel_for(std::size_t{0}, slab.wanted.size(), [&](std::size_t i) {
        std::array<double, 512> of_block;
        BlockDepths(frame, slab, depths, blocks.all[slab.wanted[i]]).write(of_block.data());
        take(slab.wanted[i], of_block);
      });
      slab = {};
    }
    if (progress) progress(double(next) / double(slabs.size()));
  }
}

MarchSetup lattice_setup(const View& view, const MediumAtlas& atlas, const Beam& beam,
                         const LatticeFrame& frame) {
  MarchSetup setup = make_march_setup(light_march(view, beam), atlas);
  frame.place(setup);
  return setup;
}

}  // namespace psivox
