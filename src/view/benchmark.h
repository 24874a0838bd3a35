#pragma once

#include <string>
#include <vector>

#include "gl/object_counts.h"
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

/// What the program holds at one moment.
struct Footprint {
  double resident_mib = 0;
  gl::ObjectCounts window, pictures;  ///< of the window's context, and of the one that draws
};

/// A session of a hand that opens one file after another.
struct SessionReport {
  int switches = 0;
  double seconds = 0;
  /// With the first file open: after a quarter of the switches, when every file was there twice,
  /// and at the end.
  Footprint settled, end;
  double most_mib = 0;  ///< after a quarter of the switches
};

/// Drops the files on the window in turn, at least so often and until it is the first one's turn
/// again; orbits around each, and waits for its exact picture. The viewer counts objects. Throws
/// Error(failure) if the window was closed before.
SessionReport benchmark_session(Viewer& viewer, const std::vector<std::string>& files,
                                int switches);

}  // namespace psivox::view
