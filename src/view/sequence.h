#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

namespace psivox::view {

/// The files of a folder whose names differ in their last number only: frames of a sequence.
class Sequence {
 public:
  /// The sequence that a file belongs to; one frame where its name has no number or stands alone.
  /// The last number of `name.####.vdb`, `name.%04d.vdb` or `name.$F4.vdb` is any: the first file
  /// there is.
  static Sequence of(const std::string& path);

  bool empty() const { return files_.size() < 2; }
  int first() const { return files_.begin()->first; }
  int last() const { return files_.rbegin()->first; }
  int current() const { return current_; }
  /// Its file; nothing where the frame is missing.
  std::optional<std::string> file(int frame) const;
  /// Goes to a frame, or where that is missing stays. True if it is another one.
  bool go_to(int frame);
  /// The frame that is played after the current one: the next that is there, the first after the
  /// last.
  int next() const;
  int previous() const;
  int missing() const { return last() - first() + 1 - static_cast<int>(files_.size()); }

  /// The current frame's file.
  const std::string& path() const { return files_.at(current_); }

  bool playing = false;  ///< only with more than one frame
  double rate = 12;      ///< [frames/s]
  void toggle_playing() { playing = !empty() && !playing; }
  /// Goes on to the next frame if it plays and the time for it has come.
  void play(std::chrono::steady_clock::time_point now);

 private:
  std::map<int, std::string> files_;
  int current_ = 0;
  std::chrono::steady_clock::time_point stepped_at_{};
};

}  // namespace psivox::view
