#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "field/leaf_values.h"
#include "march/lattice_tiles.h"

namespace psivox::light_tiles {
namespace {

/// Columns whose depths a voxel's is interpolated from, along each axis: a cubic through the four
/// (Catmull and Rom 1974), the voxel between the middle two.
constexpr std::size_t taps = 4;

using Row = std::array<double, 8>;

/// A voxel's taps and their weights: the first one's number, and the cubic's values.
struct Tap {
  int first;
  std::array<double, taps> weights;
};

/// `x`: the number, not whole, of the column at the voxel.
inline Tap tap_at(double x) {
  const int below = cell_of(x);
  const double f = x - below, f2 = f * f, f3 = f2 * f;
  return {below - 1,
          {-0.5 * f + f2 - 0.5 * f3, 1 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2 * f2 - 1.5 * f3,
           -0.5 * f2 + 0.5 * f3}};
}

/// Those of the 8 voxels of a block along one axis.
struct Taps {
  std::array<Tap, 8> of_voxels;

  /// `column`: the number, not whole, of the column at the first; the next is `step` columns on.
  Taps(double column, double step) {
    for (int i = 0; i < 8; ++i) of_voxels[std::size_t(i)] = tap_at(column + i * step);
  }

  int first() const { return of_voxels.front().first; }
  /// Columns from the first tap to the last.
  int reach() const { return of_voxels.back().first - first() + int(taps); }
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
        for (int k = 0; k < next - j; ++k) *to++ = std::min(before[k] + own[k], frame_.end);
      }
  }

  void write_slice(int n, double* to) {
    const int slice = 8 * frame_.slab(block_) + n;
    const glm::dvec2 column = frame_.column(frame_.across(block_), slice);
    const Taps u(column.x, 1 / frame_.spacing), v(column.y, 1 / frame_.spacing);
    const glm::ivec2 size(u.reach(), v.reach());
    gather(n, {u.first(), v.first()}, size);
    between_.resize(std::size_t(size.y));
    along_v_.resize(std::size_t(size.y));
    for (std::size_t x = 0; x < 8; ++x) {
      const Tap& tap = u.of_voxels[x];
      const double* const from = patch_.data() + (tap.first - u.first()) * size.y;
      for (int j = 0; j < size.y; ++j)
        along_v_[std::size_t(j)] = tap.weights[0] * from[j] + tap.weights[1] * from[j + size.y] +
                                   tap.weights[2] * from[j + 2 * size.y] +
                                   tap.weights[3] * from[j + 3 * size.y];
      for (std::size_t j = 0; j < along_v_.size(); ++j) between_[j][x] = along_v_[j];
    }
    constexpr glm::ivec3 strides(64, 8, 1);
    const int to_u = strides[frame_.axis_u], to_v = strides[frame_.axis_v];
    to += strides[frame_.axis] * (frame_.side > 0 ? 7 - n : n);
    for (int y = 0; y < 8; ++y) {
      const Tap& tap = v.of_voxels[std::size_t(y)];
      const Row* const from = &between_[std::size_t(tap.first - v.first())];
      Row sum{};
      for (std::size_t k = 0; k < taps; ++k)
        for (std::size_t x = 0; x < 8; ++x) sum[x] += tap.weights[k] * from[k][x];
      for (int x = 0; x < 8; ++x) to[x * to_u + y * to_v] = sum[std::size_t(x)];
    }
  }

  const LatticeFrame& frame_;
  const BlockTiles& tiles_;
  glm::ivec3 block_;
  std::vector<double> patch_;    ///< of columns, axis_v fastest
  std::vector<double> along_v_;  ///< at columns along axis_v, for a voxel along axis_u
  std::vector<Row> between_;     ///< the same for all voxels along axis_u
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
    const Tap u = tap_at(place.x), v = tap_at(place.y);
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
    const Tap w = tap_at(along);
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
          own += v.weights[std::size_t(j + k - v.first)] *
                 std::min(before[k] + in_slab[k], places_.end());
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

}  // namespace

void write_depths(const LatticeFrame& frame, const BlockTiles& tiles, const glm::ivec3& block,
                  double* to) {
  BlockDepths(frame, tiles, block).write(to);
}

void write_depths(const VoxelPlaces& places, const BlockTiles& tiles, int slab, bool is_last,
                  const glm::ivec3& block, double* to) {
  PlacedDepths(places, tiles, slab, is_last).write(block, to);
}

}  // namespace psivox::light_tiles
