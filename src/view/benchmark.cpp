#include "view/benchmark.h"

#include <algorithm>
#include <chrono>

#include "psivox/error.h"

namespace psivox::view {
namespace {

using BenchmarkClock = std::chrono::steady_clock;

double elapsed_ms(BenchmarkClock::time_point start) {
  return std::chrono::duration<double, std::milli>(BenchmarkClock::now() - start).count();
}

void next_frame(Viewer& viewer, double wait_s) {
  if (!viewer.frame(wait_s))
    throw Error(ExitCode::failure, "the window was closed before the benchmark's end");
}

double until_exact(Viewer& viewer) {
  const auto start = BenchmarkClock::now();
  do next_frame(viewer, 0.1);
  while (!viewer.exact_picture());
  return elapsed_ms(start);
}

}  // namespace

OrbitTimes benchmark_orbit(Viewer& viewer, int pictures) {
  OrbitTimes times;
  times.first_exact_ms = until_exact(viewer);

  // The first pictures find the pace.
  const int settling = std::min(pictures, 10);
  const double turn_pixels = 2.0 * viewer.window().size().y;
  const double pixels_per_ms = turn_pixels / (pictures * 40.0);
  std::vector<double> intervals;
  auto moved = BenchmarkClock::now(), shown = BenchmarkClock::now();
  // The left button, beside the panel.
  glm::dvec2 pointer = glm::dvec2(viewer.window().size()) * glm::dvec2(0.7, 0.5);
  using Kind = Event::Kind;
  viewer.window().post({Kind::move, pointer});
  next_frame(viewer, 0);
  viewer.window().post({Kind::button, pointer, 0, true});
  while (static_cast<int>(intervals.size()) < pictures + settling) {
    if (elapsed_ms(moved) >= 8) {  // as a mouse
      pointer.x += pixels_per_ms * elapsed_ms(moved);
      viewer.window().post({Kind::move, pointer});
      moved = BenchmarkClock::now();
    }
    const std::uint64_t before = viewer.shown();
    next_frame(viewer, 0.005);
    if (viewer.shown() == before) continue;
    intervals.push_back(elapsed_ms(shown));
    shown = BenchmarkClock::now();
  }
  viewer.window().post({Kind::button, pointer, 0, false});
  times.refine_ms = until_exact(viewer);

  intervals.erase(intervals.begin(), intervals.begin() + settling);
  std::sort(intervals.begin(), intervals.end());
  times.median_ms = intervals[intervals.size() / 2];
  times.p90_ms = intervals[intervals.size() * 9 / 10];
  return times;
}

}  // namespace psivox::view
