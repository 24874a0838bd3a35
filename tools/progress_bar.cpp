#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "base/text.h"

namespace psivox {
namespace {

constexpr int bar_width = 40;

/// ", 3:05 left", once enough work is done to estimate it.
std::string time_left(double fraction, double passed_s) {
  if (fraction < 0.02 || passed_s < 2) return "";
  const double left_s = passed_s * (1 - fraction) / fraction;
  const auto seconds = int(std::lround(std::min(left_s, 359999.0)));
  if (seconds >= 3600)
    return formatted(", %d:%02d:%02d left", seconds / 3600, seconds / 60 % 60, seconds % 60);
  return formatted(", %d:%02d left", seconds / 60, seconds % 60);
}

}  // namespace

ProgressBar::ProgressBar(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      marks_(terminal_ ? ProgressMarks(100, 0.3, 0.5) : ProgressMarks(10, 2, 10)) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (std::exchange(drawn_, false)) std::fputs("\r\033[K", stderr);
}

Progress ProgressBar::progress() {
  if (quiet_) return {};
  start_ = std::chrono::steady_clock::now();
  return [this](double fraction) { show(fraction); };
}

void ProgressBar::show(double fraction) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
  if (!marks_.passes(fraction, passed.count())) return;
  const std::string left = time_left(fraction, passed.count());
  const int percent = int(fraction * 100);
  if (!terminal_) {
    std::fprintf(stderr, "psivox: %d %%%s\n", percent, left.c_str());
    return;
  }
  drawn_ = true;
  const int filled = int(fraction * bar_width);
  const std::string bar =
      std::string(std::size_t(filled), '#') + std::string(std::size_t(bar_width - filled), '.');
  std::fprintf(stderr, "\r[%s] %3d %%%s\033[K", bar.c_str(), percent, left.c_str());
  std::fflush(stderr);
}

}  // namespace psivox
