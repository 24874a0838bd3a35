#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

namespace psivox::view {

/// A sequence: the files of a folder whose names differ in their last number only are its frames.
class Sequence {
 public:
  /// The sequence of a file. It has one frame if the name has no number or no other file matches.
  /// `name.####.vdb`, `name.%04d.vdb` and `name.$F4.vdb` start at the first file that matches.
  static Sequence of(const std::string& path);

  bool empty() const { return files_.size() < 2; }
  int first() const { return files_.begin()->first; }
  int last() const { return files_.rbegin()->first; }
  int current() const { return current_; }
  /// The file of a frame; nothing if it is missing.
  std::optional<std::string> file(int frame) const;
  /// Goes to a frame if it is there. True if that changes the frame.
  bool go_to(int frame);
  /// The frame after the current one that has a file; the first one after the last.
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
