#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/terminal.h"
#include "base/text.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/open.h"
#include "psivox/sequence.h"

namespace psivox {

/// Prints a line to stderr for each.
void print_notices(std::span<const std::string> notices);

/// "look smoke" and how to see the options that give the same picture, or these options.
std::string look_text(const std::string& look, std::span<const Setting> settings, bool to_copy,
                      const std::string& how = "-v prints its options");

/// Prints why the look of a scene is plain, if something made it so.
void print_dark(const Scene& scene, const std::string& dark_because);

/// Prints the look, and the grids that the picture does not show.
void print_look(const LookedScene& looked, bool to_copy,
                const std::string& how = "-v prints its options");

/// Prints how the grids were changed as they were read, and the numbers that `auto` chose where the
/// look leaves them open: rounded, or as options to copy.
void print_choices(const OpenedScene& opened, bool to_copy);

/// Decides when progress is worth showing: first after `patience_s`, then whenever one of `parts`
/// equal parts of the work is done, and at least every `silence_s`.
class ProgressMarks {
 public:
  ProgressMarks(int parts, double patience_s, double silence_s)
      : parts_(parts), patience_s_(patience_s), silence_s_(silence_s) {}

  /// Whether to show `fraction`, 0 to 1, now. Times count from the start of the work.
  bool passes(double fraction, double passed_s) {
    // an end of which nothing was said is none to wait for
    if (passed_s < patience_s_ || (fraction >= 1 && part_ <= 0)) return false;
    const int part = int(fraction * parts_);
    if (part <= part_ && passed_s < shown_s_ + silence_s_) return false;
    part_ = part;
    shown_s_ = passed_s;
    return true;
  }
  /// Another stage begins, of which nothing is done.
  void next_stage() { part_ = 0; }

 private:
  int parts_;
  double patience_s_, silence_s_;
  int part_ = -1;  ///< the last one shown
  double shown_s_ = 0;
};

/// Estimates the time that a stage of work still takes by its rate in the last half of the time, or
/// more.
class TimeLeft {
 public:
  /// ", 3:05 left", once a twentieth is done, of long work a hundredth; until then nothing. Times
  /// count from the start of the stage.
  std::string text(double fraction, double passed_s) {
    if (passed_s >= 2 * middle_.passed_s) {
      since_ = middle_;
      middle_ = {fraction, passed_s};
    }
    const double gained = fraction - since_.fraction;
    const bool early = fraction < 0.01 || (fraction < 0.05 && passed_s < 60) || passed_s < 2;
    if (early || gained <= 0 || fraction >= 1) return "";
    const double left_s = (passed_s - since_.passed_s) * (1 - fraction) / gained;
    constexpr double day_s = 24 * 3600, most_days = 9999;
    if (left_s >= 4 * day_s)
      return formatted(", %d days left", int(std::lround(std::min(left_s / day_s, most_days))));
    const auto seconds = int(std::lround(left_s));
    if (seconds >= 3600)
      return formatted(", %d:%02d:%02d left", seconds / 3600, seconds / 60 % 60, seconds % 60);
    return formatted(", %d:%02d left", seconds / 60, seconds % 60);
  }

 private:
  struct Mark {
    double fraction = 0, passed_s = 0;
  };
  Mark since_, middle_;  ///< `since_` is in the first half of the time
};

/// Shows progress on stderr with the time left, of a picture that of its stage: a bar on a
/// terminal; elsewhere a line for every tenth or every ten seconds. Work that is done in a moment
/// shows nothing.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// For work that begins now; empty if there is nothing to show. The bar must outlive it.
  Progress progress();
  /// The same for work in stages.
  StageProgress stages();

  /// Removes the bar from the terminal, for a line of text; it comes back with the next progress.
  void clear();
  /// Prints a notice where the bar was.
  void say(const std::string& notice);

 private:
  /// `what`: the stage; null: there is none.
  void show(const char* what, double fraction);

  std::chrono::steady_clock::time_point start_, stage_start_;
  const char* stage_ = nullptr;
  bool quiet_;
  bool terminal_;
  ProgressMarks marks_;
  TimeLeft left_;
  bool drawn_ = false;
};

/// Notices about frames: each is said once, for all frames of which it is true.
class FrameNotices {
 public:
  /// Notices that differ in their numbers are one.
  void add(const std::string& notice, FrameNumber frame);
  /// Says them, and forgets them.
  void say(ProgressBar& bar);

 private:
  struct Collected {
    std::string text;      ///< of the first frame
    bool differs = false;  ///< its numbers do
    std::vector<FrameNumber> frames;
  };
  std::map<std::string, Collected> all_;  ///< by their texts without numbers
};

}  // namespace psivox
