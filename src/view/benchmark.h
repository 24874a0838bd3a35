#pragma once

#include <string>
#include <vector>

#include "gl/gl_renderer.h"
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

/// Memory and OpenGL objects of the program at one moment.
struct Footprint {
  double resident_mib = 0;
  gl::ObjectCounts window, pictures;  ///< of the window's context, and of the one that draws
};

/// A session in which a user opens one file after another.
struct SessionReport {
  int switches = 0;
  double seconds = 0;
  /// With the first file open: after a quarter of the switches, or after every file was shown
  /// twice if that is later; and at the end.
  Footprint settled, end;
  double most_mib = 0;  ///< from `settled` on
};

/// Drops the files on the window in turn, at least `switches` times and in whole rounds. Orbits
/// around each and waits for its exact picture. The viewer needs ViewerOptions::count_objects.
/// Throws Error(failure) if the window is closed before.
SessionReport benchmark_session(Viewer& viewer, const std::vector<std::string>& files,
                                int switches);

}  // namespace psivox::view
