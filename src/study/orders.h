#pragma once

#include <string>
#include <vector>

#include "psivox/integrators.h"
#include "psivox/progress.h"
#include "study/fitted_order.h"

// Orders of convergence after Etiene et al. 2014: one length shrinks, the others stay, over media
// that are formulas and have exact pictures.

namespace psivox {

/// What shrinks.
enum class Refined { step, voxel, pixel };

struct OrderRow {
  Refined refined = Refined::step;
  std::string rays;  ///< where they begin and end
  std::string way;   ///< the rule, and what else makes the picture
  Integrator rule = Integrator::psi_weighted;
  double K = 0;         ///< extinction: optical depth over a width of the medium
  double expected = 0;  ///< order
  bool about = false;   ///< an error of the rule's own that does not fall with the length
  double floor = 0;     ///< errors below it are rounding's
  std::vector<LengthError> errors;  ///< RMS of radiance, lengths coarse to fine

  std::vector<LengthError> fitted() const { return finest_four(errors, floor); }
  double observed() const { return fitted_order(fitted()); }
};

/// Uniform steps on one ray without voxels, by every rule of segments: RMS over 8 phases of the
/// lattice, lengths in widths of the medium.
std::vector<OrderRow> step_orders(const Progress& progress = {});

/// Voxels of the same medium in three dimensions, lengths in its widths: RMS over the picture
/// against the medium itself.
std::vector<OrderRow> voxel_orders(const Progress& progress = {});

/// Pixels, lengths in widths of the picture: what is between them, and their mean.
std::vector<OrderRow> pixel_orders(const Progress& progress = {});

}  // namespace psivox
