#pragma once

#include <chrono>
#include <ctime>

namespace psivox {

/// Time since it was made [ms].
class Stopwatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }
  /// Processor time of all threads of the process.
  double cpu_ms() const { return processor_ms() - cpu_start_; }

 private:
  using Clock = std::chrono::steady_clock;

  static double processor_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  }

  Clock::time_point start_ = Clock::now();
  double cpu_start_ = processor_ms();
};

}  // namespace psivox
