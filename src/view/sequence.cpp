#include "view/sequence.h"

#include <algorithm>
#include <filesystem>
#include <regex>

namespace psivox::view {
namespace {

namespace fs = std::filesystem;

struct Pattern {
  std::string before, after;
  bool open = false;  ///< a placeholder stands for the number
};

std::optional<Pattern> pattern_of(const std::string& name) {
  static const std::regex placeholder(R"(^(.*?)(#+|%0?\d*d|\$F\d*)(.*)$)");
  static const std::regex number(R"(^(.*?)(\d+)(\D*)$)");
  std::smatch m;
  if (std::regex_match(name, m, placeholder)) return Pattern{m[1], m[3], true};
  if (std::regex_match(name, m, number)) return Pattern{m[1], m[3], false};
  return std::nullopt;
}

/// The number in a name that matches the pattern.
std::optional<int> number_in(const std::string& name, const Pattern& pattern) {
  const std::size_t fixed = pattern.before.size() + pattern.after.size();
  if (name.size() <= fixed || name.size() > fixed + 9 || !name.starts_with(pattern.before) ||
      !name.ends_with(pattern.after))
    return std::nullopt;
  const std::string digits = name.substr(pattern.before.size(), name.size() - fixed);
  if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return std::stoi(digits);
}

}  // namespace

Sequence Sequence::of(const std::string& path) {
  Sequence sequence;
  const fs::path whole(path);
  const std::string name = whole.filename().string();
  const std::optional<Pattern> pattern = pattern_of(name);
  if (pattern) {
    std::error_code unreadable;
    const fs::path folder = whole.has_parent_path() ? whole.parent_path() : fs::path(".");
    for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
      const std::string other = entry.path().filename().string();
      if (const auto frame = number_in(other, *pattern))
        sequence.files_.emplace(*frame, (whole.parent_path() / other).string());
    }
  }
  const std::optional<int> own =
      pattern && !pattern->open ? number_in(name, *pattern) : std::nullopt;
  if (own) sequence.files_[*own] = path;
  if (sequence.files_.empty()) sequence.files_.emplace(0, path);
  sequence.current_ = own.value_or(sequence.files_.begin()->first);
  return sequence;
}

std::optional<std::string> Sequence::file(int frame) const {
  const auto found = files_.find(frame);
  return found == files_.end() ? std::nullopt : std::optional(found->second);
}

bool Sequence::go_to(int frame) {
  if (frame == current_ || !files_.contains(frame)) return false;
  current_ = frame;
  return true;
}

void Sequence::play(std::chrono::steady_clock::time_point now) {
  if (!playing || now - stepped_at_ < std::chrono::duration<double>(1 / std::max(rate, 0.1)))
    return;
  stepped_at_ = now;
  go_to(next());
}

int Sequence::previous() const {
  if (files_.empty()) return current_;
  const auto here = files_.find(current_);
  return here == files_.begin() ? files_.rbegin()->first : std::prev(here)->first;
}

int Sequence::next() const {
  if (files_.empty()) return current_;
  const auto after = files_.upper_bound(current_);
  return after == files_.end() ? files_.begin()->first : after->first;
}

}  // namespace psivox::view
