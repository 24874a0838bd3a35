#pragma once

#include <chrono>

#include "progress_marks.h"
#include "psivox/progress.h"

namespace psivox {

/// Shows progress on stderr with the time left: a bar on a terminal; elsewhere a line for every
/// tenth or every ten seconds. Work that is done in a moment shows nothing.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Empty if there is nothing to show. The bar must outlive it.
  Progress progress();

  /// Removes the bar from the terminal, for a line of text; it comes back with the next progress.
  void clear();

 private:
  void show(double fraction);

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool quiet_;
  bool terminal_;
  ProgressMarks marks_;
  bool drawn_ = false;
};

}  // namespace psivox
