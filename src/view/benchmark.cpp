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
  if (!viewer.volume() && !viewer.loading() && !viewer.last_error().empty())
    throw Error(ExitCode::input, viewer.last_error());
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
  while (static_cast<int>(intervals.size()) < pictures + settling) {
    viewer.navigation().orbit({pixels_per_ms * elapsed_ms(moved), 0});
    moved = BenchmarkClock::now();
    const std::uint64_t before = viewer.shown();
    next_frame(viewer, 0.005);
    if (viewer.shown() == before) continue;
    intervals.push_back(elapsed_ms(shown));
    shown = BenchmarkClock::now();
  }
  times.refine_ms = until_exact(viewer);

  intervals.erase(intervals.begin(), intervals.begin() + settling);
  std::sort(intervals.begin(), intervals.end());
  times.median_ms = intervals[intervals.size() / 2];
  times.p90_ms = intervals[intervals.size() * 9 / 10];
  return times;
}

}  // namespace psivox::view
