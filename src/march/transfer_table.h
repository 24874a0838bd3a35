#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "scene/transfer_function.h"

namespace psivox {

/// A segment with linear attenuation and linear colour, seen from its front end.
struct SegmentView {
  double opacity = 0;
  double back = 0.5;  ///< of the mean luminance the share of the back end's colour
};

/// Optical lengths of the attenuation at both ends, 0 to 1e6 and more. The back's share is
/// (Psi - zeta)/(1 - zeta), integrated by parts: relative error below 1e-12.
SegmentView view_segment(double x_front, double x_back);

/// One interval of a lattice of values, passed at a constant rate: what it does to light. Mean
/// luminances, so that constant colour stays what it is; float32, since very many are kept.
struct TransferRun {
  float opacity = 0;
  glm::vec3 up{0};    ///< luminance seen from its lower value's end
  glm::vec3 down{0};  ///< from its upper value's end
};

/// Several intervals in a row as one, and the integrals of the function over them.
struct TransferSpan {
  glm::dvec3 up{0}, down{0};  ///< radiance seen from the lower value's end, from the upper's
  double opacity = 0;
  double attenuation = 0;  ///< integral of the attenuation over the lattice's intervals
  glm::dvec3 source{0};    ///< of attenuation times colour
};

/// A transfer function cut at a uniform lattice of values and at its own knots.
class TransferLattice {
 public:
  TransferLattice(const TransferFunction& function, double first, double last, int intervals);

  /// `length`: optical length of the interval at attenuation 1.
  TransferRun run(int interval, double length) const;

  /// emit(i, TransferSpan) for the spans of `width` intervals from i = lo to hi. `runs`: those of
  /// all intervals. About three compositions a span whatever its width: the spans that share an
  /// interval's lower end, the pivot, are a part that grows downwards from it and one that grows
  /// upwards (the sliding windows of van Herk 1992 under the associative operator `over`).
  template <typename Emit>
  void spans(const TransferRun* runs, int width, int lo, int hi, const Emit& emit) const;

 private:
  /// Between two cuts.
  struct Piece {
    double share;  ///< of its interval
    double attenuation[2];
    glm::dvec3 color[2];
  };
  struct Integral {
    double attenuation = 0;
    glm::dvec3 source{0};
  };
  TransferSpan span(const TransferRun& run, int interval) const {
    const double opacity = run.opacity;
    const Integral& integral = integrals_[std::size_t(interval)];
    return {glm::dvec3(run.up) * opacity, glm::dvec3(run.down) * opacity, opacity,
            integral.attenuation, integral.source};
  }

  std::vector<Piece> pieces_;
  std::vector<int> first_piece_;  ///< of each interval, and the end
  std::vector<Integral> integrals_;
};

/// `upper` seen through `lower` from below, and the other way round from above.
inline TransferSpan join(const TransferSpan& lower, const TransferSpan& upper) {
  const double through_lower = 1 - lower.opacity, through_upper = 1 - upper.opacity;
  return {lower.up + upper.up * through_lower, upper.down + lower.down * through_upper,
          lower.opacity + upper.opacity * through_lower, lower.attenuation + upper.attenuation,
          lower.source + upper.source};
}

template <typename Emit>
void TransferLattice::spans(const TransferRun* runs, int width, int lo, int hi,
                            const Emit& emit) const {
  std::vector<TransferSpan> above;  // above[n]: n intervals from the pivot on
  above.reserve(std::size_t(width) + 1);
  for (int pivot = hi; pivot >= lo; pivot -= width + 1) {
    above.assign(1, {});
    for (int i = pivot; i < pivot + width; ++i)
      above.push_back(join(above.back(), span(runs[i], i)));
    TransferSpan below;
    for (int i = pivot; i >= std::max(lo, pivot - width); --i) {
      if (i < pivot) below = join(span(runs[i], i), below);
      emit(i, join(below, above[std::size_t(width - (pivot - i))]));
    }
  }
}

/// A transfer function as shaders/transfer.glsl reads it: four entries a knot,
///   (value, attenuation, and the differences to the next knot's)
///   (colour, integral of the attenuation from the first knot)
///   (the difference to the colour of the next knot, 0)
///   (integral of attenuation times colour from the first knot, 0)
/// then `bins` entries: the first and the last interval that a value of that bin may lie in, and
/// the value at which the last one begins.
struct TransferTable {
  std::vector<glm::vec4> entries;
  int knots = 0;  ///< at least 2
  int bins = 0;
  int search_steps = 0;  ///< most that the bisection inside a bin takes
  double min = 0;        ///< value of the first knot
  double bin_scale = 0;  ///< bins per unit of value
};

/// The gradient part of a transfer function: an entry (gradient, next gradient, 0, 0) for each
/// interval of gradients, then for each interval k of values and j of gradients the attenuations at
/// (k, j), (k, j + 1), (k + 1, j), (k + 1, j + 1), j minor; then (value, thickness, attenuation, 0)
/// an isosurface. At least one interval of each.
struct GradientEntries {
  std::vector<glm::vec4> entries;
  int columns = 1;  ///< intervals of gradients
  int isosurfaces = 0;
  int search_steps = 0;  ///< most that the bisection of the gradients takes
};

GradientEntries make_gradient_entries(const TransferFunction& function);

TransferTable make_transfer_table(const TransferFunction& function);

/// An attenuation that never falls, as a constant and ramps: each is 0 up to its knot and linear
/// from there on. A look-up reads no table.
struct Ramps {
  double base = 0;
  glm::dvec4 knots{0}, slopes{0};  ///< those that are not needed have slope 0
};

/// Nothing if the attenuation falls, bends more than four times, depends on the gradient, or is so
/// steep that the ramps' sum would cancel.
std::optional<Ramps> make_ramps(const TransferFunction& function);

}  // namespace psivox
