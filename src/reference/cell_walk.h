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

/// A cell and the part of a ray in it.
struct CellPiece {
  const CellBlock& block;
  glm::ivec3 cell;
  double begin, end;  ///< s, begin < end
};

/// Calls visit(const CellPiece&) for each cell of the non-empty blocks that the ray crosses, front
/// to back, until it returns false. Parameters from `level` on serve the recursion.
template <class Visit>
bool walk_cells(const FieldLookup& lookup, BlockCache& cache, const IndexRay& ray, Visit&& visit,
                double s0, double s1, int level) {
  const int width = FieldLookup::widths[static_cast<std::size_t>(level)];
  for (CubeSteps cube(ray, width, s0, s1); !cube.done(); cube.next()) {
    if (!lookup.may_hold_values(level, cube.key())) continue;
    if (width > 8) {
      if (!walk_cells(lookup, cache, ray, visit, cube.begin(), cube.end(), level + 1)) return false;
      continue;
    }
    const CellBlock& block = cache.at(cube.key());
    if (block.empty) continue;
    for (CubeSteps cell(ray, 1, cube.begin(), cube.end()); !cell.done(); cell.next()) {
      if (!(cell.begin() < cell.end())) continue;
      if (!visit(CellPiece{block, cell.key(), cell.begin(), cell.end()})) return false;
    }
  }
  return true;
}

template <class Visit>
void walk_cells(const FieldLookup& lookup, BlockCache& cache, const IndexRay& ray, Visit&& visit) {
  if (ray.hits()) walk_cells(lookup, cache, ray, visit, ray.s_begin, ray.s_end, 0);
}

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

}  // namespace psivox
