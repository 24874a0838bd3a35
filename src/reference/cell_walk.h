#pragma once

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "field_lookup.h"
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
    return (static_cast<double>(plane - anchor[axis]) - P[axis]) / D[axis];
  }

  /// Coordinates in a cell, 0 to 1; clamped against rounding.
  glm::dvec3 in_cell(const glm::ivec3& cell, double s) const {
    return glm::clamp(P + s * D - glm::dvec3(cell - anchor), 0.0, 1.0);
  }
};

/// The t at which the ray is nearest to the middle of the field's domain; not behind its origin.
double nearest_to_middle(const Field& field, const WorldRay& ray);

/// The part t0 <= t <= t1 of the ray in the field's index space, clipped to its domain.
IndexRay make_index_ray(const Field& field, const WorldRay& ray, double t_middle, double t0,
                        double t1);

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

/// The path of a ray through one grid, as stretches without gaps from -infinity to infinity: before
/// the domain, in a cell, in a whole cube of zeros, behind the domain.
class GridWalk {
 public:
  /// `lookup` and `cache` must outlive it.
  GridWalk(const FieldLookup& lookup, BlockCache& cache, const IndexRay& ray);
  GridWalk(const GridWalk&) = delete;
  GridWalk& operator=(const GridWalk&) = delete;

  const IndexRay& ray() const { return ray_; }
  double begin() const { return begin_; }
  double end() const { return end_; }
  bool in_domain() const { return in_domain_; }
  bool in_cell() const { return block_ != nullptr; }  ///< in a block that is not empty
  const glm::ivec3& cell() const { return cell_; }
  const std::array<double, 8>& corners(int channel = 0) const {
    return corners_[static_cast<std::size_t>(channel)];
  }

  void next();
  /// Moves on until the stretch ends behind s.
  void reach(double s) {
    while (end_ <= s) next();
  }

  /// Smallest and largest value of the stretch's corners.
  double low(int channel = 0) const { return low_[static_cast<std::size_t>(channel)]; }
  double high(int channel = 0) const { return high_[static_cast<std::size_t>(channel)]; }
  bool all_zero() const;  ///< in every channel

  /// The field from a to b, inside the stretch.
  Cubic along(double a, double b, int channel = 0) const;
  /// The field in the cell from a to b, as rounding leaves it.
  Cubic cubic(double a, double b, int channel = 0) const {
    return cubic_along(corners(channel), ray_.in_cell(cell_, a), ray_.in_cell(cell_, b));
  }

 private:
  void find();
  void enter_zeros(double begin, double end, bool in_domain);
  void enter_cell(const CubeSteps& steps);

  const FieldLookup* lookup_;
  BlockCache* cache_;
  IndexRay ray_;
  std::array<std::optional<CubeSteps>, 4> steps_;  ///< cubes of FieldLookup::widths, cells
  std::size_t level_ = 0;
  double begin_, end_;
  bool in_domain_ = false;
  const CellBlock* block_ = nullptr;
  glm::ivec3 cell_{0};
  std::array<std::array<double, 8>, 3> corners_{};
  std::array<double, 3> low_{}, high_{};
};

/// Calls visit(const GridWalk&) for each cell of the blocks that are not empty, front to back,
/// until it returns false.
template <class Visit>
void walk_cells(const FieldLookup& lookup, BlockCache& cache, const IndexRay& ray, Visit&& visit) {
  if (!ray.hits()) return;
  GridWalk walk(lookup, cache, ray);
  for (walk.next(); walk.in_domain(); walk.next())
    if (walk.in_cell() && !visit(walk)) return;
}

}  // namespace psivox
