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
