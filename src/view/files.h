#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "psivox/sequence.h"

namespace psivox::view {

/// The frames that the window shows: a sequence that was named, or a file and the files beside it
/// whose names differ from it in their last number only. One of them is the current one.
class Sequence {
 public:
  /// `inputs` were opened: a file, several, a folder or a pattern. It starts at the file, else at
  /// the first frame. Throws what sequence_files throws.
  static Sequence of(const std::vector<std::string>& inputs);

  /// Whether there is nothing to play.
  bool empty() const { return files_.size() < 2; }
  /// Files from which `auto` chooses for all frames. A file that was opened alone has none: the
  /// files beside it are shown as it was.
  const std::vector<std::string>& samples() const { return samples_; }
  FrameNumber first() const { return files_.begin()->first; }
  FrameNumber last() const { return files_.rbegin()->first; }
  FrameNumber current() const { return current_; }
  /// Frames between the first and the last that have no file.
  const std::vector<FrameNumber>& missing() const { return missing_; }
  const std::string& file(FrameNumber frame) const { return files_.at(frame); }
  const std::string& path() const { return files_.at(current_); }

  /// Goes to the frame that is nearest and has a file.
  void go_to(FrameNumber frame);
  /// The frame after the current one that has a file; the first one after the last.
  FrameNumber next() const;
  FrameNumber previous() const;

  bool playing = false;  ///< only with more than one frame
  double rate = 24;      ///< [frames/s]
  void toggle_playing() { playing = !empty() && !playing; }
  /// Goes on to the next frame if it plays and the time for it has come.
  void play(std::chrono::steady_clock::time_point now);

 private:
  SequenceFiles files_;
  std::shared_ptr<const VolumeFile> film_;  ///< see file_of_frame
  std::vector<std::string> samples_;
  std::vector<FrameNumber> missing_;
  FrameNumber current_ = 0;
  std::chrono::steady_clock::time_point stepped_at_{};
};

/// Notices that a file was written again. It looks at most twice a second.
class FileWatch {
 public:
  /// Whether the file differs from what it was at the last look; false at the first look at a path,
  /// and while there is no such file.
  bool changed(const std::string& path);

 private:
  std::string path_, stamp_;
  std::chrono::steady_clock::time_point looked_at_{};
};

/// The files that the user opened last, the newest first.
std::vector<std::string> recent_files();

/// Puts a file first. Ignores it if the list cannot be written.
void remember_file(const std::string& path);

}  // namespace psivox::view
