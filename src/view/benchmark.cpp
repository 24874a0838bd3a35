#include "view/benchmark.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "psivox/error.h"

namespace psivox::view {
namespace {

void next_frame(Viewer& viewer, double wait_s) {
  if (!viewer.frame(wait_s))
    throw Error(ExitCode::failure, "the window was closed before the benchmark's end");
}

/// Waits for the exact picture; returns how long [ms]. Sets how long its first part took.
double until_exact(Viewer& viewer, double* first_part_ms = nullptr) {
  const Stopwatch start;
  bool begun = false;
  do {
    next_frame(viewer, 0.1);
    const PictureState& pictures = viewer.pictures();
    if (!begun && first_part_ms && pictures.begun && pictures.begun == pictures.wished)
      *first_part_ms = start.ms(), begun = true;
  } while (!viewer.pictures().complete());
  return start.ms();
}

/// Presses the left button on the picture, right of its middle, and returns the pointer's place. In
/// a small window a panel lies there: it is closed.
glm::dvec2 press_on_picture(Viewer& viewer) {
  const glm::dvec2 pointer = glm::dvec2(viewer.window().size()) * glm::dvec2(0.7, 0.5);
  const auto point = [&] {
    viewer.window().post({Event::Kind::move, pointer});
    for (int i = 0; i < 2; ++i) next_frame(viewer, 0);  // panels know the pointer a frame later
    return viewer.gui().takes_pointer();
  };
  Panels& panels = viewer.panels();
  if (point()) panels.scene = panels.transfer = panels.help = false;
  if (point())
    throw Error(ExitCode::failure, "the window is too small to orbit in; give --resolution");
  viewer.window().post({Event::Kind::button, pointer, 0, true});
  return pointer;
}

}  // namespace

OrbitTimes benchmark_orbit(Viewer& viewer, int pictures) {
  OrbitTimes times;
  times.first_exact_ms = until_exact(viewer, &times.first_part_ms);

  // The pace adapts during the first pictures.
  const int settling = std::min(pictures, 10);
  const double turn_pixels = 2.0 * viewer.window().size().y;
  const double pixels_per_ms = turn_pixels / (pictures * 40.0);
  std::vector<double> intervals;
  using Kind = Event::Kind;
  glm::dvec2 pointer = press_on_picture(viewer);
  Stopwatch moved, shown;
  while (int(intervals.size()) < pictures + settling) {
    if (moved.ms() >= 8) {  // as often as a mouse reports
      pointer.x += pixels_per_ms * moved.ms();
      viewer.window().post({Kind::move, pointer});
      moved = {};
    }
    const std::uint64_t before = viewer.pictures().shown;
    next_frame(viewer, 0.005);
    if (viewer.pictures().shown == before) continue;
    intervals.push_back(shown.ms());
    shown = {};
  }
  viewer.window().post({Kind::button, pointer, 0, false});
  times.refine_ms = until_exact(viewer);

  times.intervals_ms.assign(intervals.begin() + settling, intervals.end());
  return times;
}

}  // namespace psivox::view
