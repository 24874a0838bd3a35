#pragma once

#include <vector>

#include "view/viewer.h"

namespace psivox::view {

/// How fast the window follows a user who orbits.
struct OrbitTimes {
  std::vector<double> intervals_ms;  ///< between two new pictures on the screen
  double refine_ms = 0;              ///< from the last movement until the exact picture is shown
  /// From the start until the first part of an exact picture was shown, and until all of it was.
  double first_part_ms = 0, first_exact_ms = 0;
};

/// Orbits once around until the window has shown `pictures` new pictures, and waits for the exact
/// one. Throws Error(failure) if the window is closed before.
OrbitTimes benchmark_orbit(Viewer& viewer, int pictures);

}  // namespace psivox::view
