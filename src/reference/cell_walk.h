#pragma once

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "field/field_index.h"
#include "field/index_space.h"
#include "piece.h"
#include "psivox/camera.h"
#include "psivox/field.h"

namespace psivox {

/// A ray in the index space of one grid: p(s) = P + s D [voxels from `anchor`], with s [world
/// units] counted from t = `t_middle` of the world ray, which is near the grid; a camera may be far
/// away. Rays of several grids share s if they share t_middle.
struct IndexRay {
  glm::dvec3 P{0}, D{0};
  glm::ivec3 anchor{0};            ///< middle of the field's domain
  double s_begin = 0, s_end = -1;  ///< in the domain; no part of it unless begin < end

  bool hits() const { return s_begin < s_end; }

  /// Where the ray meets a plane of integer index coordinate. Every level of the walk uses this one
  /// expression, so that two levels give the same plane equal values to the last bit.
  double crossing(int axis, std::int64_t plane) const {
    return (double(plane - anchor[axis]) - P[axis]) / D[axis];
  }

  /// Coordinates in a cell, 0 to 1; clamped against rounding.
  glm::dvec3 in_cell(const glm::ivec3& cell, double s) const {
    return glm::clamp(P + s * D - glm::dvec3(cell - anchor), 0.0, 1.0);
  }
};

/// The t at which the ray is nearest to the middle of the field's domain; not behind its origin.
double nearest_to_middle(const Field& field, const WorldRay& ray);

/// The part t0 <= t <= t1 of the ray in the field's index space, clipped to its domain. `nearest`:
/// half a voxel beside it, where the nearest voxel is the first corner of a ray's cell.
IndexRay make_index_ray(const Field& field, const WorldRay& ray, double t_middle, double t0,
                        double t1, bool nearest = false);

/// The cubes of `width` cells, aligned to multiples of width, that a ray crosses from s0 to s1, in
/// order. [begin, end] is the segment in cube `key` (its smallest cell / width). A ray in a face
/// stays on one side of it. Segments may have no length; none is missing and none overlaps.
class CubeSteps {
 public:
  CubeSteps(const IndexRay& ray, int width, double s0, double s1);

  bool done() const { return !(begin_ < s1_); }
  void next();
  double begin() const { return begin_; }
  double end() const { return end_; }
  const glm::ivec3& key() const { return key_; }

 private:
  void find_end();

  const IndexRay* ray_;
  int width_;
  double s1_;
  double begin_, end_ = 0;
  glm::ivec3 key_{0};
  glm::dvec3 next_{0};  ///< s at which the ray leaves the cube along each axis
};

/// The 8x8x8 cells from voxel 8 * key on, with the 9x9x9 voxels at their corners. A cell has the
/// coordinates of its smallest voxel. Voxel 8 of an axis lies in the next block of the field.
struct CellBlock {
  glm::ivec3 key{0};
  /// The field's block key + (dx,dy,dz) is at 4 dx + 2 dy + dz.
  std::array<LeafValues, 8> values{};
  bool empty = true;  ///< all 9x9x9 voxels are 0 in every channel

  /// Value of one voxel, each coordinate relative to the block, 0 to 8.
  float value(const glm::ivec3& voxel, int channel) const {
    const int block = 4 * (voxel.x >> 3) + 2 * (voxel.y >> 3) + (voxel.z >> 3);
    const LeafValues& own = values[std::size_t(block)];
    return own.at(voxel & 7)[channel * own.strides.channel];
  }

  /// The eight voxels around a cell of this block (in index space), at 4 dx + 2 dy + dz.
  std::array<double, 8> corners(const glm::ivec3& cell, int channel) const {
    const glm::ivec3 local = cell - 8 * key;
    std::array<double, 8> c;
    for (int i = 0; i < 8; ++i) c[std::size_t(i)] = value(local + cube_corner(i), channel);
    return c;
  }
};

/// The blocks of a field that one thread has used recently.
class BlockCache {
 public:
  /// `index` must outlive it.
  explicit BlockCache(const FieldIndex& index);
  const FieldIndex& index() const { return *index_; }
  /// Valid until the next call.
  const CellBlock& at(const glm::ivec3& key);

 private:
  CellBlock made(const glm::ivec3& key) const;

  const FieldIndex* index_;
  std::vector<CellBlock> blocks_;
};

/// The path of a ray through one grid, as stretches without gaps from -infinity to infinity: before
/// the domain, in a cell, in a whole cube of zeros, behind the domain.
class GridWalk {
 public:
  /// `cache` must outlive it. `nearest`: the field is that of the nearest voxels, and the ray was
  /// made for that.
  GridWalk(BlockCache& cache, const IndexRay& ray, bool nearest = false);
  GridWalk(const GridWalk&) = delete;
  GridWalk& operator=(const GridWalk&) = delete;

  const IndexRay& ray() const { return ray_; }
  double begin() const { return begin_; }
  double end() const { return end_; }
  bool in_domain() const { return in_domain_; }
  bool in_cell() const { return block_ != nullptr; }  ///< in a block that is not empty
  bool absent() const { return absent_; }             ///< a corner is: there is vacuum
  void next();
  /// Moves on until the stretch ends behind s.
  void reach(double s) {
    while (end_ <= s) next();
  }

  /// Smallest and largest value of the stretch's corners.
  double low(int channel = 0) const { return low_[std::size_t(channel)]; }
  double high(int channel = 0) const { return high_[std::size_t(channel)]; }
  bool all_zero() const;  ///< in every channel
  /// The field from a to b, inside the stretch.
  Cubic along(double a, double b, int channel = 0) const;

 private:
  void find();
  void enter_zeros(double begin, double end, bool in_domain);
  void enter_cell(const CubeSteps& steps);

  BlockCache* cache_;
  IndexRay ray_;
  bool nearest_;
  std::array<std::optional<CubeSteps>, 4> steps_;  ///< cubes of FieldIndex::widths, cells
  std::size_t level_ = 0;
  double begin_, end_;
  bool in_domain_ = false, absent_ = false;
  const CellBlock* block_ = nullptr;
  glm::ivec3 cell_{0};
  std::array<std::array<double, 8>, 3> corners_{};
  std::array<double, 3> low_{}, high_{};
};

}  // namespace psivox
