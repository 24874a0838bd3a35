#pragma once

#include "view/viewer.h"

namespace psivox::view {

/// What a hand that orbits gets to see.
struct OrbitTimes {
  double median_ms = 0, p90_ms = 0;  ///< between two new pictures on the screen
  double refine_ms = 0;              ///< from the last movement until the exact picture is shown
  double first_exact_ms = 0;         ///< from the opening of the window until the first one was
};

/// Once around, steadily, until so many new pictures were shown; then waits for the exact one.
/// Throws Error(failure) if the window was closed before.
OrbitTimes benchmark_orbit(Viewer& viewer, int pictures);

}  // namespace psivox::view
