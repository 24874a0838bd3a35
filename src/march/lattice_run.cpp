#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <map>
#include <unordered_map>

#include "field/leaf_values.h"
#include "march/light_lattice.h"

namespace psivox {
namespace light_tiles {

/// Columns whose depths a voxel's is interpolated from, along each axis: a cubic through the four
/// (Catmull and Rom 1974), the voxel between the middle two.
constexpr std::size_t taps = 4;

using Row = std::array<double, 8>;

/// A voxel's taps and their weights: the first one's number, and the cubic's values.
struct Tap {
  int first;
  std::array<double, taps> weights;

  /// `x`: the number, not whole, of the column at the voxel.
  explicit Tap(double x) {
    const double below = std::floor(x), f = x - below, f2 = f * f, f3 = f2 * f;
    first = int(below) - 1;
    weights = {-0.5 * f + f2 - 0.5 * f3, 1 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2 * f2 - 1.5 * f3,
               -0.5 * f2 + 0.5 * f3};
  }
};

/// Of the 8 voxels of a block along one axis, the first taps and all weights.
struct Taps {
  std::array<int, 8> first;
  std::array<Row, taps> weights;
  bool consecutive = true;  ///< whether each voxel's taps begin one column after the previous one's

  /// `at`: the number, not whole, of the column at a voxel.
  explicit Taps(const auto& at) {
    for (std::size_t i = 0; i < 8; ++i) {
      const Tap own(at(int(i)));
      first[i] = own.first;
      for (std::size_t k = 0; k < taps; ++k) weights[k][i] = own.weights[k];
      consecutive &= first[i] == first[0] + int(i);
    }
  }

  /// Columns from the first tap to the last.
  int reach() const { return first.back() - first.front() + int(taps); }

  /// Interpolates the 8 voxels from columns; `from` begins at the first tap.
  void filter(const double* from, Row& to) const {
    to = {};
    for (std::size_t k = 0; k < taps; ++k)
      if (consecutive)
        for (std::size_t i = 0; i < 8; ++i) to[i] += weights[k][i] * from[i + k];
      else
        for (std::size_t i = 0; i < 8; ++i)
          to[i] += weights[k][i] * from[std::size_t(first[i] - first[0]) + k];
  }
};

/// Depths of 0, of a slice and of a brick.
constexpr std::array<double, lattice_depths_of_brick> nothing{};

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

TileRange common(const TileRange& a, const TileRange& b) {
  return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

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

/// The tiles whose columns meet the domain: no others attenuate.
TileRange tiles_of(const LatticeFrame& frame) {
  return tiles_around(columns_between(frame, frame.across(frame.domain.min),
                                      frame.across(frame.domain.max), -1, 8 * frame.slabs()));
}

/// Those that a block's voxels are interpolated from.
TileRange tiles_of(const LatticeFrame& frame, const glm::ivec3& block) {
  const glm::dvec2 low(frame.across(block));
  const int first_slice = 8 * frame.slab(block);
  return tiles_around(columns_between(frame, low, low + 7.0, first_slice, first_slice + 7));
}

/// Those with columns through cells in a slab.
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

/// Another volume's voxels in a lattice: the numbers, not whole, of columns along axis_u and axis_v
/// and of slices.
class VoxelPlaces {
 public:
  VoxelPlaces(const LatticeFrame& frame, const glm::dmat4& to_index) {
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

  glm::dvec3 at(const glm::ivec3& voxel) const { return first_ + steps_ * glm::dvec3(voxel); }
  /// Least and greatest places of a block's voxels.
  std::array<glm::dvec3, 2> of_block(const glm::ivec3& block) const {
    glm::dvec3 low = at(block), high = low;
    for (int i = 0; i < 3; ++i) {
      low += glm::min(7.0 * steps_[i], glm::dvec3(0));
      high += glm::max(7.0 * steps_[i], glm::dvec3(0));
    }
    constexpr double rounding = 1e-6;
    return {low - rounding, high + rounding};
  }

 private:
  glm::dvec3 first_{0};  ///< place of voxel 0
  glm::dmat3 steps_{1};
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

/// Interpolates the voxels of a block of the density.
class BlockDepths {
 public:
  BlockDepths(const LatticeFrame& frame, const BlockTiles& tiles, const glm::ivec3& block)
      : frame_(frame), tiles_(tiles), block_(block) {}

  /// 512 depths, z fastest.
  void write(double* to) {
    for (int n = 0; n < 8; ++n) write_slice(n, to);
  }

 private:
  /// Depths of the columns from `first` on, axis_v fastest.
  void gather(int n, const glm::ivec2& first, const glm::ivec2& size) {
    patch_.resize(std::size_t(size.x) * std::size_t(size.y));
    const glm::ivec2 end = first + size;
    double* to = patch_.data();
    for (int i = first.x; i < end.x; ++i)
      for (int j = first.y, next = j; j < end.y; j = next) {
        next = std::min((j | 7) + 1, end.y);
        const Tile tile = tiles_.of(i, j);
        const int column = (i & 7) * lattice_columns + (j & 7);
        const double* const before = tile.before + column;
        const double* const own = tile.own + n * lattice_depths_of_slice + column;
        for (int k = 0; k < next - j; ++k) *to++ = before[k] + own[k];
      }
  }

  void write_slice(int n, double* to) {
    const int slice = 8 * frame_.slab(block_) + n;
    const glm::dvec2 corner(frame_.across(block_));
    const auto column = [&](int k) { return frame_.column(corner + double(k), slice); };
    const Taps u([&](int k) { return column(k).x; }), v([&](int k) { return column(k).y; });
    const glm::ivec2 size(u.reach(), v.reach());
    gather(n, {u.first[0], v.first[0]}, size);
    rows_.resize(std::size_t(size.x));
    for (int i = 0; i < size.x; ++i) v.filter(patch_.data() + i * size.y, rows_[std::size_t(i)]);
    glm::ivec3 voxel;
    voxel[frame_.axis] = frame_.side > 0 ? 7 - n : n;
    for (int x = 0; x < 8; ++x) {
      const Row* from = &rows_[std::size_t(u.first[std::size_t(x)] - u.first[0])];
      Row sum{};
      for (std::size_t k = 0; k < taps; ++k)
        for (std::size_t y = 0; y < 8; ++y) sum[y] += u.weights[k][std::size_t(x)] * from[k][y];
      for (int y = 0; y < 8; ++y) {
        voxel[frame_.axis_u] = x;
        voxel[frame_.axis_v] = y;
        to[(voxel.x * 8 + voxel.y) * 8 + voxel.z] = sum[std::size_t(y)];
      }
    }
  }

  const LatticeFrame& frame_;
  const BlockTiles& tiles_;
  glm::ivec3 block_;
  std::vector<double> patch_;  ///< of columns, axis_v fastest
  std::vector<Row> rows_;      ///< at voxels along axis_v
};

/// Interpolates voxels of another volume: across columns as those of a block, along them by the
/// cubic through four slices or, at a slab's ends, the parabola through three.
class PlacedDepths {
 public:
  PlacedDepths(const VoxelPlaces& places, const BlockTiles& tiles, int slab, bool is_last)
      : places_(places), tiles_(tiles), slab_(slab), is_last_(is_last) {}

  /// The depths of a block's 512 voxels, z fastest; 0 of those that belong to other slabs.
  void write(const glm::ivec3& block, double* to) const {
    for (int i = 0; i < 512; ++i) to[i] = at(places_.at(block + leaf_voxel(i)));
  }

 private:
  double at(const glm::dvec3& place) const {
    const double from_slab = place.z - (8 * slab_ - 1);
    // behind the last slab nothing attenuates
    if (!(from_slab > 0) || (from_slab > lattice_slices && !is_last_)) return 0;
    const Tap u(place.x), v(place.y);
    const double along = std::min(from_slab, double(lattice_slices));
    const int slice = std::min(int(along), lattice_slices - 1);
    const double f = along - slice;
    if (f == 1) return across(u, v, slice + 1);
    if (slice == 0)
      return 0.5 * (1 - f) * (2 - f) * across(u, v, 0) + f * (2 - f) * across(u, v, 1) -
             0.5 * f * (1 - f) * across(u, v, 2);
    if (slice == lattice_slices - 1)
      return 0.5 * f * (1 + f) * across(u, v, slice + 1) + (1 - f) * (1 + f) * across(u, v, slice) -
             0.5 * f * (1 - f) * across(u, v, slice - 1);
    const Tap w(along);
    double sum = 0;
    for (int k = 0; k < int(taps); ++k)
      sum += w.weights[std::size_t(k)] * across(u, v, w.first + k);
    return sum;
  }

  /// The depth in a slice, counted from the one before the slab.
  double across(const Tap& u, const Tap& v, int slice) const {
    double sum = 0;
    const int end = v.first + int(taps);
    for (int a = 0; a < int(taps); ++a) {
      const int i = u.first + a;
      double own = 0;
      for (int j = v.first, next = j; j < end; j = next) {
        next = std::min((j | 7) + 1, end);
        const Tile tile = tiles_.of(i, j);
        if (tile.is_clear()) continue;
        const int column = (i & 7) * lattice_columns + (j & 7);
        const double* const before = tile.before + column;
        const double* const in_slab =
            slice > 0 ? tile.own + (slice - 1) * lattice_depths_of_slice + column : nothing.data();
        for (int k = 0; k < next - j; ++k)
          own += v.weights[std::size_t(j + k - v.first)] * (before[k] + in_slab[k]);
      }
      sum += u.weights[std::size_t(a)] * own;
    }
    return sum;
  }

  const VoxelPlaces& places_;
  const BlockTiles& tiles_;
  int slab_;
  bool is_last_;
};

constexpr std::size_t nowhere = ~std::size_t{0};
using Slice = std::array<double, lattice_depths_of_slice>;

/// A tile on its way through the slabs.
struct TileRun {
  glm::ivec2 number{0};
  int last = -1;                    ///< the last slab that needs it
  int mark = -1;                    ///< the turn in which it was found to be dark
  std::size_t place = nowhere;      ///< of its depths among those found in the slab
  std::unique_ptr<Slice> before{};  ///< depths before the slab; null: 0
};

struct NumberHash {
  std::size_t operator()(const glm::ivec2& v) const {
    const std::uint64_t key =
        std::uint64_t(std::uint32_t(v.x)) << 32 | std::uint64_t(std::uint32_t(v.y));
    return std::size_t((key * 0x9E3779B97F4A7C15ull) >> 17);
  }
};

/// What a run keeps.
struct Columns {
  Columns(const LatticeFrame& of, LightBlocks all, TakeDepths taken, const glm::dmat4* to_index)
      : frame(of), blocks(all), take(std::move(taken)), range(tiles_of(frame)) {
    if (to_index) placed.emplace(frame, *to_index);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const auto [from, to] = slabs_of(blocks[i]);
      for (int slab = from; slab <= to; ++slab) slabs[slab].wanted.push_back(i);
      tiles(blocks[i]).each([&, last = to](const glm::ivec2& number) {
        TileRun& run = runs[number];
        run.number = number;
        run.last = std::max(run.last, last);
      });
    }
    for (auto& [number, run] : runs)
      if (run.last >= 0) slabs[run.last].ending.push_back(&run);
  }

  /// The first and the last slab that a block reaches into.
  std::array<int, 2> slabs_of(const glm::ivec3& block) const {
    if (!placed) return {frame.slab(block), frame.slab(block)};
    const auto [low, high] = placed->of_block(block);
    const auto slab = [&](double slice) {
      return int(std::clamp(std::ceil((slice + 1) / 8) - 1, -1.0, double(frame.slabs() - 1)));
    };
    return {std::max(slab(low.z), 0), slab(high.z)};
  }

  TileRange tiles(const glm::ivec3& block) const {
    if (!placed) return common(tiles_of(frame, block), range);
    const auto [low, high] = placed->of_block(block);
    return common(tiles_around({glm::dvec2(low), glm::dvec2(high)}), range);
  }

  Tile tile_at(const glm::ivec2& number) const {
    Tile tile;
    const TileRun& run = runs.at(number);
    if (run.before) tile.before = run.before->data();
    if (run.place != nowhere) tile.own = found.data() + run.place;
    return tile;
  }

  /// The needed tiles with columns through dark cells.
  std::vector<TileRun*> tiles_through_dark(int slab, const DarkCells& cells) {
    std::vector<TileRun*> some;
    for (const CellCube& cube : cells.in(slab))
      common(tiles_through(frame, cube, slab), range).each([&](const glm::ivec2& number) {
        const auto tile = runs.find(number);
        if (tile == runs.end() || tile->second.last < slab || tile->second.mark == turn) return;
        tile->second.mark = turn;
        some.push_back(&tile->second);
      });
    ++turn;
    std::ranges::sort(some, [](const TileRun* a, const TileRun* b) {
      return a->number.x != b->number.x ? a->number.x < b->number.x : a->number.y < b->number.y;
    });
    return some;
  }

  void give(int slab) const {
    const std::vector<std::size_t>& some = slabs.at(slab).wanted;
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
      const glm::ivec3& block = blocks[some[k]];
      BlockTiles of_block{tiles(block), {}};
      of_block.range.each([&](const glm::ivec2& at) { of_block.tiles.push_back(tile_at(at)); });
      std::array<double, 512> depths{};
      if (of_block.are_clear())
        ;  // as they are
      else if (placed)
        PlacedDepths(*placed, of_block, slab, slab + 1 == frame.slabs())
            .write(block, depths.data());
      else
        BlockDepths(frame, of_block, block).write(depths.data());
      take(some[k], depths);
    });
  }

  /// What wants a slab.
  struct Slab {
    std::vector<std::size_t> wanted;  ///< blocks
    std::vector<TileRun*> ending;     ///< tiles that no later one needs
  };

  LatticeFrame frame;
  LightBlocks blocks;
  TakeDepths take;
  std::optional<VoxelPlaces> placed{};
  TileRange range;                                             ///< tiles that may attenuate
  std::unordered_map<glm::ivec2, TileRun, NumberHash> runs{};  ///< those that blocks need
  std::map<int, Slab> slabs{};
  std::vector<double> found{};          ///< depths of the slab's dark tiles
  std::vector<TileRun*> found_tiles{};  ///< these tiles
  int turn = 0;
};

}  // namespace light_tiles

struct LatticeRun::Impl : light_tiles::Columns {
  using Columns::Columns;
};

LatticeRun::LatticeRun(const LatticeFrame& frame, LightBlocks blocks, TakeDepths take,
                       const glm::dmat4* to_index)
    : impl_(std::make_unique<Impl>(frame, blocks, std::move(take), to_index)) {}
LatticeRun::~LatticeRun() = default;
LatticeRun::LatticeRun(LatticeRun&&) noexcept = default;

int LatticeRun::next_slab(int slab, const DarkCells& dark) const {
  const auto& slabs = impl_->slabs;
  if (slabs.empty() || slab > slabs.rbegin()->first) return -1;
  return std::min(slabs.lower_bound(slab)->first, dark.next_slab(slab));
}

double LatticeRun::bytes(const LatticeFrame& frame) {
  constexpr double of_tile = 64 + lattice_depths_of_slice * sizeof(double);
  return of_tile * double(light_tiles::tiles_of(frame).count());
}

void LatticeRun::add(int slab, const DarkCells& dark, const LatticeColumns& columns) {
  light_tiles::Columns& impl = *impl_;
  const std::vector<light_tiles::TileRun*> some = impl.tiles_through_dark(slab, dark);
  if (some.empty()) return;
  std::vector<LatticeBrick> bricks;
  for (const auto* tile : some)
    bricks.emplace_back(lattice_columns * tile->number, lattice_slices * slab);
  std::vector<double> own(some.size() * lattice_depths_of_brick);
  columns(bricks, own);
  const bool first = impl.found_tiles.empty();
  const double* from = own.data();
  for (auto* tile : some) {
    if (tile->place == light_tiles::nowhere) {
      tile->place = impl.found_tiles.size() * lattice_depths_of_brick;
      impl.found_tiles.push_back(tile);
      if (!first) impl.found.resize(impl.found_tiles.size() * lattice_depths_of_brick);
    }
    if (first) continue;
    double* to = impl.found.data() + tile->place;
    for (int k = 0; k < lattice_depths_of_brick; ++k) to[k] += from[k];
    from += lattice_depths_of_brick;
  }
  if (first) impl.found = std::move(own);
}

void LatticeRun::finish(int slab) {
  light_tiles::Columns& impl = *impl_;
  const auto ended = impl.slabs.find(slab);
  if (ended != impl.slabs.end()) impl.give(slab);
  for (auto* tile : impl.found_tiles) {
    const double* end = impl.found.data() + tile->place + lattice_depths_of_brick;
    if (!tile->before) tile->before = std::make_unique<light_tiles::Slice>();
    std::ranges::transform(*tile->before, std::span(end - lattice_depths_of_slice, end),
                           tile->before->begin(), std::plus());
    tile->place = light_tiles::nowhere;
  }
  if (ended != impl.slabs.end())
    for (auto* tile : ended->second.ending) tile->before.reset();
  impl.found_tiles.clear();
  impl.found.clear();
}

}  // namespace psivox
