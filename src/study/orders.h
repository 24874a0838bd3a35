#pragma once

#include <string>
#include <vector>

#include "psivox/integrators.h"
#include "psivox/progress.h"
#include "study/fitted_order.h"

// Orders of convergence after Etiene et al. 2014: one length shrinks at a time, in media that are
// formulas with exact pictures.

namespace psivox {

/// The length that shrinks.
enum class Refined { step, voxel, pixel };

struct OrderRow {
  Refined refined = Refined::step;
  std::string rays;  ///< where they begin and end
  std::string way;   ///< the rule, and how else the picture is made
  Integrator rule = Integrator::psi_weighted;
  double K = 0;                     ///< extinction: optical depth over a width of the medium
  double expected = 0;              ///< expected order
  bool about = false;               ///< the rule has an error that does not fall with the length
  double floor = 0;                 ///< errors below it are rounding
  std::vector<LengthError> errors;  ///< RMS of the radiance, from coarse to fine

  std::vector<LengthError> fitted() const { return finest_four(errors, floor); }
  double observed() const { return fitted_order(fitted()); }
};

/// Orders of every segment rule in the uniform step, in widths of the medium: one ray without
/// voxels, RMS over 8 phases of the lattice.
std::vector<OrderRow> step_orders(const Progress& progress = {});

/// Orders in the size of voxels, in widths of the same medium in three dimensions. Errors are RMS
/// over the picture, against the medium itself.
std::vector<OrderRow> voxel_orders(const Progress& progress = {});

/// Orders in the size of pixels, in widths of the picture: one for the picture interpolated between
/// pixels, one for the mean of the pixels.
std::vector<OrderRow> pixel_orders(const Progress& progress = {});

}  // namespace psivox
