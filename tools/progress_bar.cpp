#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace psivox {
namespace {

constexpr int bar_width = 40;
// Shorter work needs no progress: a bar that flashes up, or a log with ten lines a frame.
constexpr double patience_terminal_s = 0.3;
constexpr double patience_log_s = 2;

}  // namespace

ProgressBar::ProgressBar(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

Progress ProgressBar::progress() {
  if (quiet_) return {};
  return [this](double fraction) { show(fraction); };
}

void ProgressBar::show(double fraction) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
  const int mark = static_cast<int>(fraction * (terminal_ ? 100 : 10));
  if (mark <= shown_ || passed.count() < (terminal_ ? patience_terminal_s : patience_log_s)) return;
  shown_ = mark;
  if (!terminal_) {
    std::fprintf(stderr, "psivox: %d %%\n", 10 * mark);
    return;
  }
  drawn_ = true;
  const int filled = static_cast<int>(fraction * bar_width);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(bar_width - filled), '.');
  std::fprintf(stderr, "\r[%s] %3d %%", bar.c_str(), mark);
  std::fflush(stderr);
}

}  // namespace psivox
