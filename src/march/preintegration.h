#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "march/transfer_table.h"
#include "scene/transfer_function.h"

namespace psivox {

/// The change that self-attenuation makes to the mean luminance L of a segment along which the
/// value is linear from front to back: C = L (1 - e^{-depth}), L = `preintegrated-fast`'s +
/// shading(front, back, length). Engel, Kraus and Ertl 2001 tabulate C; depth and the first part of
/// L have closed forms, so only what is left is in the table. It vanishes for thin segments, for
/// values that do not change and for constant colour.
/// shaders/integrators/transfer/preintegrated.glsl reads it.
///
/// Values are those from the first to the last knot, uniformly spread; lengths are the layers
/// max_length (y / layers)^2, y = 1 ... layers, and 0, where nothing is to be added. Entry (layer
/// l = y - 1, i, j) is at (l size + (j - i mod size)) size + i: a diagonal is contiguous.
class PreintegratedTable {
 public:
  struct Shape {
    int size = 0;    ///< values, at least 2; 0: as the function's detail asks
    int layers = 1;  ///< 1: for segments of one length
  };

  /// Extinction [1/unit], lengths from 0 to max_length [unit].
  PreintegratedTable(const TransferFunction& function, double extinction, double max_length,
                     const Shape& shape);

  /// Makes it the table of another function. Computes only entries whose values pass a change. They
  /// are within 1e-6 of the largest colour of a new table's, since spans are joined in another
  /// order. Builds a new table, and returns false, if the function's range or detail differs.
  bool update(const TransferFunction& changed);

  const std::vector<glm::vec4>& entries() const { return entries_; }
  int size() const { return size_; }
  int layers() const { return layers_; }
  double first() const { return first_; }
  double scale() const { return scale_; }            ///< entries per unit of value
  double extinction() const { return extinction_; }  ///< [1/unit]
  double max_length() const { return max_length_; }  ///< [unit]
  const TransferFunction& function() const { return function_; }

  /// The shading as the shader interpolates it: linear in the values, which are clamped to the
  /// knots' range, and in the optical depth's share between two layers.
  glm::dvec3 shading(double front, double back, double length, double mean_attenuation) const;

  /// A bound on the error of the radiance of a segment between the first and the last knot [of the
  /// colours' unit]: twice the largest difference from direct integration, over a lattice four
  /// times finer in the values and in the root of the length. Takes about as long as building the
  /// table.
  double error_bound() const;

 private:
  double length_at(double y) const { return max_length_ * (y / layers_) * (y / layers_); }
  int size_of(const TransferFunction& function) const;
  void build();
  void compute(int lo, int hi);

  TransferFunction function_;
  double extinction_, max_length_;
  Shape shape_;
  int size_ = 2, layers_ = 1;
  double first_ = 0, last_ = 0, scale_ = 0;
  std::optional<TransferLattice> lattice_;
  std::vector<TransferRun> runs_;  ///< of each layer and each width, for updates
  std::vector<glm::vec4> entries_;
};

/// The table of a medium: the process's last one is kept. `constant_length`: most segments have
/// max_length. `may_update`: where only the function differs, the last one is updated instead of
/// building one anew, which is the same in every process.
std::shared_ptr<const PreintegratedTable> preintegrated_table(const TransferFunction& function,
                                                              double extinction, double max_length,
                                                              bool constant_length,
                                                              bool may_update);

}  // namespace psivox
