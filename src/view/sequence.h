#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "psivox/sequence.h"

namespace psivox::view {

/// The frames that the window shows: those of a sequence that was named, or the files beside a file
/// whose names differ from it in their last number only. One of them is the current one.
class Sequence {
 public:
  /// Of what was opened: a file, several, a folder or a pattern. Starts at the file, else at the
  /// first frame. Throws what sequence_files throws.
  static Sequence of(const std::vector<std::string>& inputs);

  /// Whether there is nothing to play.
  bool empty() const { return files_.size() < 2; }
  /// From which `auto` chooses for all frames. None of a file that was opened alone: what it was
  /// shown with counts for the files beside it.
  const std::vector<std::string>& samples() const { return samples_; }
  int first() const { return files_.begin()->first; }
  int last() const { return files_.rbegin()->first; }
  int current() const { return current_; }
  /// Frames between the first and the last that have no file.
  const std::vector<int>& missing() const { return missing_; }
  const std::string& file(int frame) const { return files_.at(frame); }
  /// The current frame's file.
  const std::string& path() const { return files_.at(current_); }

  /// Goes to the frame that is nearest and has a file.
  void go_to(int frame);
  /// The frame after the current one that has a file; the first one after the last.
  int next() const;
  int previous() const;

  bool playing = false;  ///< only with more than one frame
  double rate = 24;      ///< [frames/s]
  void toggle_playing() { playing = !empty() && !playing; }
  /// Goes on to the next frame if it plays and the time for it has come.
  void play(std::chrono::steady_clock::time_point now);

 private:
  SequenceFiles files_;
  std::vector<std::string> samples_;
  std::vector<int> missing_;
  int current_ = 0;
  std::chrono::steady_clock::time_point stepped_at_{};
};

}  // namespace psivox::view
