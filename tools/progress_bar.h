#pragma once

#include <chrono>

#include "psivox/progress.h"

namespace psivox {

/// Progress on stderr with the time left: a bar on a terminal, elsewhere a line every tenth of work
/// that takes long.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Empty where nothing is to be shown. The bar must outlive it.
  Progress progress();

 private:
  void show(double fraction);

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool quiet_;
  bool terminal_;
  int shown_ = 0;  ///< percent, or tenths where it is no terminal
  bool drawn_ = false;
};

}  // namespace psivox
