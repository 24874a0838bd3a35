#include "view/files.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/file_blocks.h"
#include "base/text_file.h"
#include "psivox/error.h"

namespace psivox::view {

namespace fs = std::filesystem;

Sequence Sequence::of(const std::vector<std::string>& inputs) {
  Sequence sequence;
  const std::string& path = inputs.front();
  if (auto files = sequence_files(inputs, /*within=*/true)) {
    sequence.files_ = std::move(*files);
    sequence.film_ = file_of_frame(sequence.files_.begin()->second);
    sequence.samples_ = auto_samples(sequence.files_);
    sequence.current_ = sequence.first();
  } else {
    const auto pattern = FramePattern::of_number(path);
    const auto own = pattern ? pattern->frame_of(path) : std::nullopt;
    if (own) sequence.files_ = pattern->files();
    sequence.current_ = own.value_or(0);
    sequence.files_[sequence.current_] = path;
  }
  sequence.missing_ = gaps(sequence.files_);
  return sequence;
}

void Sequence::go_to(FrameNumber frame) {
  const auto after = files_.lower_bound(frame);
  if (after == files_.end()) {
    current_ = last();
  } else if (after == files_.begin()) {
    current_ = first();
  } else {
    const FrameNumber before = std::prev(after)->first;
    current_ = frame - before < after->first - frame ? before : after->first;
  }
}

void Sequence::play(std::chrono::steady_clock::time_point now) {
  if (!playing || now - stepped_at_ < std::chrono::duration<double>(1 / std::max(rate, 0.1)))
    return;
  stepped_at_ = now;
  go_to(next());
}

FrameNumber Sequence::previous() const {
  const auto here = files_.find(current_);
  return here == files_.begin() ? last() : std::prev(here)->first;
}

FrameNumber Sequence::next() const {
  const auto after = files_.upper_bound(current_);
  return after == files_.end() ? first() : after->first;
}

bool FileWatch::changed(const std::string& path) {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_at_ < std::chrono::milliseconds(500)) return false;
  looked_at_ = now;
  const std::string stamp = file_stamp(frame_of_file(path).file);
  const bool changed = path_ == path && !stamp.empty() && stamp != stamp_;
  path_ = path;
  stamp_ = stamp;
  return changed;
}

namespace {

/// Files that the list keeps.
constexpr std::size_t kept = 10;

/// By the XDG base directory specification; empty if there is no home.
fs::path list_file() {
  if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state)
    return fs::path(state) / "psivox" / "recent";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".local/state/psivox/recent";
  return {};
}

}  // namespace

std::vector<std::string> recent_files() {
  std::vector<std::string> files;
  std::ifstream list(list_file());
  for (std::string line; files.size() < kept && std::getline(list, line);)
    if (!line.empty()) files.push_back(line);
  return files;
}

void remember_file(const std::string& path) {
  const fs::path list = list_file();
  if (list.empty()) return;
  std::error_code failed;
  const std::string whole = fs::absolute(path, failed).string();
  std::vector<std::string> files = recent_files();
  std::erase(files, whole);
  files.insert(files.begin(), whole);
  std::string text;
  for (std::size_t i = 0; i < std::min(files.size(), kept); ++i) text += files[i] + "\n";
  fs::create_directories(list.parent_path(), failed);
  try {
    write_text(list.string(), text);
  } catch (const Error&) {
  }
}

}  // namespace psivox::view
