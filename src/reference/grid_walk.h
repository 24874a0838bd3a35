#pragma once

#include <array>
#include <optional>

#include "cell_walk.h"
#include "cubic.h"

namespace psivox {

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
