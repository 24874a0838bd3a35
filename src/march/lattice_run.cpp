#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>

#include "march/lattice_tiles.h"

namespace psivox {
namespace light_tiles {

/// Columns whose depths a voxel's is interpolated from, along each axis: a cubic through the four
/// (Catmull and Rom 1974), the voxel between the middle two.
constexpr std::size_t taps = 4;
/// Bricks that are asked for at once.
constexpr std::size_t bricks_at_once = 256;

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

/// Depths of a tile in a row: those of a brick, behind the slice before.
constexpr int row_depths = lattice_depths_of_brick + lattice_columns * lattice_columns;

/// Rows of a slab's tiles whose columns are asked for together.
struct Piece {
  SlabTiles* slab;
  std::size_t first, end;  ///< tiles
};

/// Columns from the light to a slab and through it.
class Columns {
 public:
  /// Turns `own`, depths from the start of each dark brick, into `depths`, from the light on, for
  /// all tiles of the piece. Returns the rest of `own`, which belongs to other pieces.
  std::span<const double> join(const Piece& piece, std::span<const double> own, double* depths) {
    for (std::size_t tile = piece.first; tile < piece.end; ++tile) {
      const bool dark = piece.slab->is_dark(tile);
      add(carries_[piece.slab->tiles()[tile]], dark ? own.data() : nullptr, depths);
      if (dark) own = own.subspan(lattice_depths_of_brick);
      depths += row_depths;
    }
    return own;
  }

  /// Forgets columns that have left the volume: tiles move along the shear from slab to slab.
  void forget(const LatticeFrame& frame, const SlabTiles& slab) {
    if (carries_.size() < 2 * slab.tiles().size() + 1024) return;
    const glm::dvec2 low = glm::dvec2(frame.across(frame.domain.min)) - 9.0;
    const glm::dvec2 high = glm::dvec2(frame.across(frame.domain.max)) + 9.0;
    const glm::ivec2 least = glm::ivec2(glm::floor(frame.column(low, slab.first_slice()))) >> 3;
    const glm::ivec2 most = glm::ivec2(glm::floor(frame.column(high, slab.first_slice()))) >> 3;
    std::erase_if(carries_, [&](const auto& entry) {
      for (int axis = 0; axis < 2; ++axis) {
        const int at = entry.first[axis];
        if (frame.shear[axis] >= 0 ? at < least[axis] - 2 : at > most[axis] + 2) return true;
      }
      return false;
    });
  }

 private:
  using Carry = std::array<double, lattice_columns * lattice_columns>;

  /// `own` is null where nothing attenuates.
  static void add(Carry& carry, const double* own, double* to) {
    to = std::ranges::copy(carry, to).out;
    for (int slice = 0; slice < lattice_slices; ++slice, to += carry.size()) {
      if (own)
        std::ranges::transform(carry, std::span(own, carry.size()), to, std::plus());
      else
        std::ranges::copy(carry, to);
      if (own) own += carry.size();
    }
    std::copy_n(to - carry.size(), carry.size(), carry.begin());
  }

  std::unordered_map<glm::ivec2, Carry, ColumnHash> carries_;
};

/// Interpolates the voxels of one block.
class BlockDepths {
 public:
  /// `slab` has the depths of the block's tiles.
  BlockDepths(const LatticeFrame& frame, const SlabTiles& slab, const glm::ivec3& block)
      : frame_(frame),
        range_(tiles_of(frame, block, slab.first_slice())),
        block_(block),
        first_slice_(slab.first_slice()) {
    for (int x = range_.min.x; x <= range_.max.x; ++x)
      for (int y = range_.min.y; y <= range_.max.y; ++y) tiles_.push_back(slab.depths({x, y}));
  }

  /// 512 depths, z fastest.
  void write(double* to) {
    for (int n = 0; n < 8; ++n) write_slice(n, to);
  }

 private:
  /// Depths of the columns from `first` on, axis_v fastest.
  void gather(int n, const glm::ivec2& first, const glm::ivec2& size) {
    patch_.resize(std::size_t(size.x) * std::size_t(size.y));
    const glm::ivec2 tiles = range_.size(), end = first + size;
    double* to = patch_.data();
    for (int i = first.x; i < end.x; ++i) {
      const int row = ((i >> 3) - range_.min.x) * tiles.y - range_.min.y;
      for (int j = first.y, next = j; j < end.y; j = next) {
        next = std::min((j | 7) + 1, end.y);
        const double* tile = tiles_[std::size_t(row + (j >> 3))];
        to = std::copy_n(tile + (n * 8 + (i & 7)) * 8 + (j & 7), next - j, to);
      }
    }
  }

  void write_slice(int n, double* to) {
    const int slice = first_slice_ + n;
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
  TileRange range_;
  glm::ivec3 block_;
  int first_slice_;
  std::vector<const double*> tiles_;  ///< of range_, axis_v fastest
  std::vector<double> patch_;         ///< of columns, axis_v fastest
  std::vector<Row> rows_;             ///< at voxels along axis_v
};

/// Interpolates voxels of another volume: across columns as those of a block, along them by the
/// cubic through four slices or, at a slab's ends, the parabola through three.
class PlacedDepths {
 public:
  PlacedDepths(const SlabTiles& slab, const TileRange& range, const VoxelPlaces& places)
      : slab_(slab.slab()), range_(range), places_(places) {
    for (int x = range.min.x; x <= range.max.x; ++x)
      for (int y = range.min.y; y <= range.max.y; ++y) {
        const double* depths = slab.depths({x, y});
        const bool clear = std::all_of(depths - columns, depths + lattice_depths_of_brick,
                                       [](double depth) { return depth == 0; });
        tiles_.push_back(clear ? nullptr : depths);
      }
  }

  /// The depths of a block's 512 voxels, z fastest; 0 of those that belong to other slabs.
  void write(const glm::ivec3& block, double* to) const {
    for (int i = 0; i < 512; ++i) to[i] = at(places_.at(block + leaf_voxel(i)));
  }

 private:
  static constexpr int columns = lattice_columns * lattice_columns;

  double at(const glm::dvec3& place) const {
    const double from_slab = place.z - (slab_.first_slice - 1);
    if (!(from_slab > 0) || place.z > slab_.end) return 0;
    const glm::dvec2 low(8 * range_.min), high(8 * range_.max + 8);
    if (!(place.x > low.x - 2 && place.y > low.y - 2 && place.x < high.x + 1 &&
          place.y < high.y + 1))
      return 0;
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
    const int last = v.first + int(taps) - 1, row = range_.size().y;
    double sum = 0;
    for (int a = 0; a < int(taps); ++a) {
      const int i = u.first + a, x = (i >> 3) - range_.min.x;
      if (x < 0 || (i >> 3) > range_.max.x) continue;
      double own = 0;
      for (int j = v.first; j <= last;) {
        const int y = (j >> 3) - range_.min.y, end = std::min((j | 7), last);
        const bool inside = y >= 0 && y < row;
        const double* const tile = inside ? tiles_[std::size_t(x * row + y)] : nullptr;
        if (tile) {
          const double* from = tile + (slice - 1) * columns + (i & 7) * lattice_columns;
          for (int k = j; k <= end; ++k) own += v.weights[std::size_t(k - v.first)] * from[k & 7];
        }
        j = end + 1;
      }
      sum += u.weights[std::size_t(a)] * own;
    }
    return sum;
  }

  const LightSlab& slab_;
  TileRange range_;
  const VoxelPlaces& places_;
  std::vector<const double*> tiles_;  ///< of range_, axis_v fastest; null: depths of 0
};

/// For each tile that wanted blocks are interpolated from, the first slice of the last such slab.
TileNumbers last_slabs(const WantedBlocks& wanted, const LightSlabs& slabs) {
  TileNumbers last;
  for (const LightSlab& slab : slabs.all())
    for (const std::uint32_t block : slab.wanted) {
      const TileRange range = wanted.tiles(block, slab);
      for (int x = range.min.x; x <= range.max.x; ++x)
        for (int y = range.min.y; y <= range.max.y; ++y) last[{x, y}] = slab.first_slice;
    }
  return last;
}

void WantedBlocks::depths(std::size_t block, const SlabTiles& slab, double* to) const {
  if (places_)
    PlacedDepths(slab, tiles(block, slab.slab()), *places_).write(blocks_.placed->all[block], to);
  else
    BlockDepths(frame_, slab, blocks_.all[block]).write(to);
}

}  // namespace light_tiles

using namespace light_tiles;

struct LatticeRun::Impl {
  LatticeFrame frame;
  const LightSlabs& slabs;
  LightBlocks blocks;
  TakeDepths take;
  bool from_light;
  WantedBlocks wanted{frame, blocks};
  std::optional<TileNumbers> last{};
  std::size_t next = 0;  ///< slab
  Columns columns{};
  std::vector<double> found{};
  std::map<int, std::vector<double>> rows{};  ///< depths of the slab's, by their number
  std::vector<std::vector<double>> unused{};

  /// Adds the slab's pieces of about bricks_at_once bricks.
  std::vector<Piece> pieces_of(SlabTiles& slab) const {
    std::vector<Piece> pieces;
    const std::vector<glm::ivec2>& tiles = slab.tiles();
    std::size_t bricks = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const bool begins_row = i == 0 || tiles[i].x != tiles[i - 1].x;
      if (i == 0 || (begins_row && bricks >= bricks_at_once)) {
        pieces.push_back({&slab, i, i});
        bricks = 0;
      }
      bricks += slab.is_dark(i);
      pieces.back().end = i + 1;
    }
    return pieces;
  }

  /// Joins a piece's columns and gives the depths of the blocks that have all theirs. Returns the
  /// rest of `own`.
  std::span<const double> finish(const Piece& piece, std::span<const double> own) {
    SlabTiles& slab = *piece.slab;
    const std::vector<glm::ivec2>& tiles = slab.tiles();
    for (std::size_t i = piece.first, end = i; i < piece.end; i = end) {
      while (end < piece.end && tiles[end].x == tiles[i].x) ++end;
      std::vector<double>& row = rows[tiles[i].x];
      if (!unused.empty()) {
        row = std::move(unused.back());
        unused.pop_back();
      }
      row.resize(std::max(row.size(), (end - i) * row_depths));
      own = columns.join({&slab, i, end}, own, row.data());
      for (std::size_t tile = i; tile < end; ++tile)
        slab.set_depths(tile, row.data() + (tile - i + 1) * row_depths - lattice_depths_of_brick);
    }
    const std::vector<std::uint32_t>& own_blocks = slab.slab().wanted;
    const auto range = [&](std::size_t i) { return wanted.tiles(own_blocks[i], slab.slab()); };
    const bool complete = piece.end == tiles.size();
    std::size_t ready = slab.done;
    while (ready < own_blocks.size() && (complete || range(ready).max.x <= tiles[piece.end - 1].x))
      ++ready;
    tbb::parallel_for(slab.done, ready, [&](std::size_t i) {
      std::array<double, 512> of_block;
      wanted.depths(own_blocks[i], slab, of_block.data());
      take(own_blocks[i], of_block);
    });
    slab.done = ready;
    while (!rows.empty() &&
           (ready == own_blocks.size() || rows.begin()->first < range(ready).min.x)) {
      unused.push_back(std::move(rows.begin()->second));
      rows.erase(rows.begin());
    }
    if (complete && !wanted.placed()) columns.forget(frame, slab);  // shadows go on
    return own;
  }
};

LatticeRun::LatticeRun(const LatticeFrame& frame, const LightSlabs& slabs,
                       const LightBlocks& blocks, TakeDepths take, bool from_light)
    : impl_(std::make_unique<Impl>(frame, slabs, blocks, std::move(take), from_light)) {
  if (from_light || blocks.placed || blocks.wanted.size() < blocks.all.size())
    impl_->last = last_slabs(impl_->wanted, slabs);
}
LatticeRun::~LatticeRun() = default;
LatticeRun::LatticeRun(LatticeRun&&) noexcept = default;

double LatticeRun::bytes(const LatticeFrame& frame) {
  const glm::dvec2 size(frame.across(frame.domain.max - frame.domain.min + 17));
  const glm::dvec2 tiles = size / (8 * frame.spacing) + 3.0;
  constexpr double entry =
      lattice_columns * lattice_columns * sizeof(double) + 48;  // with a map's own
  return 2 * tiles.x * tiles.y * entry;                         // forget() lets them double
}

void LatticeRun::go_on(int end, const LatticeColumns& columns, const Progress& progress) {
  Impl& impl = *impl_;
  const std::vector<LightSlab>& slabs = impl.slabs.all();
  std::deque<SlabTiles> open;
  std::vector<Piece> batch;
  std::vector<LatticeBrick> bricks;
  const auto flush = [&] {
    const std::size_t count = bricks.size() * lattice_depths_of_brick;
    impl.found.resize(std::max(impl.found.size(), count));
    const std::span<double> own = std::span(impl.found).first(count);
    columns(bricks, own);
    std::span<const double> left = own;
    for (const Piece& piece : batch) left = impl.finish(piece, left);
    batch.clear();
    bricks.clear();
    while (open.size() > 1) open.pop_front();
  };
  for (; impl.next < slabs.size() && slabs[impl.next].first_slice < end; ++impl.next) {
    const LightSlab& slab = slabs[impl.next];
    open.emplace_back(impl.frame, slab, impl.blocks.all, impl.last ? &*impl.last : nullptr,
                      impl.from_light, impl.blocks.placed ? &impl.wanted : nullptr);
    // several thin slabs at once: a device works on many bricks alike
    for (const Piece& piece : impl.pieces_of(open.back())) {
      batch.push_back(piece);
      for (std::size_t i = piece.first; i < piece.end; ++i)
        if (piece.slab->is_dark(i)) bricks.push_back(piece.slab->brick(i));
      if (bricks.size() >= bricks_at_once) flush();
    }
    if (progress && batch.empty()) progress(double(impl.next + 1) / double(slabs.size()));
  }
  if (!batch.empty()) flush();
  if (progress) progress(double(impl.next) / double(slabs.size()));
}

LatticeColumns in_part(const LatticeFrame& frame, const LatticeColumns& columns) {
  if (!frame.part) return columns;
  return [&frame, &columns](std::span<const LatticeBrick> bricks, std::span<double> depths) {
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
  };
}

}  // namespace psivox
