#include <algorithm>
#include <filesystem>
#include <limits>
#include <numeric>
#include <regex>
#include <set>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/sequence.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_digits = 9;  // of an int

const std::regex& placeholder() {
  static const std::regex pattern(R"((#+)|%(0(\d))?d|\$F(\d?))");
  return pattern;
}

/// Digits that a placeholder asks for, 1 at least.
std::size_t digits_of(const std::smatch& found) {
  if (found[1].matched) return std::size_t(found[1].length());
  const std::string digits = found[3].matched ? found[3].str() : found[4].str();
  return digits.empty() || digits == "0" ? 1 : std::size_t(digits[0] - '0');
}

constexpr std::size_t most_frames = 1000000;

[[noreturn]] void refuse_frames(const std::string& option, const std::string& text) {
  throw Error(
      ExitCode::usage,
      option + ": expected frames such as 1-100, 1-100x2 or 1-10,20, not " + in_quotes(text));
}

/// First, last and step of `7`, `1-100` or `1-100x2`.
struct Span {
  int first = 0, last = 0, step = 1;
};

Span read_span(const std::string& item, const std::string& option, const std::string& text) {
  Span span;
  const std::size_t x = item.find('x');
  const std::string ends = item.substr(0, x);
  const std::size_t dash = ends.find('-');
  bool good = read_number(ends.substr(0, dash), span.first);
  span.last = span.first;
  if (dash != std::string::npos) good &= read_number(ends.substr(dash + 1), span.last);
  if (x != std::string::npos)
    good &= dash != std::string::npos && read_number(item.substr(x + 1), span.step);
  if (!good || span.first < 0 || span.last < span.first || span.step < 1)
    refuse_frames(option, text);
  return span;
}

}  // namespace

std::optional<FramePattern> FramePattern::of_placeholder(const std::string& path) {
  std::smatch found;
  if (!std::regex_search(path, found, placeholder())) return {};
  FramePattern pattern;
  pattern.before_ = found.prefix();
  pattern.after_ = found.suffix();
  pattern.digits_ = digits_of(found);
  if (std::regex_search(pattern.after_, placeholder()))
    throw Error(ExitCode::usage, in_quotes(path) + " has two places for a frame's number");
  if (pattern.after_.find('/') != std::string::npos)
    throw Error(ExitCode::usage,
                in_quotes(path) + ": the place for a frame's number must be in the file's name");
  if (pattern.digits_ > most_digits)
    throw Error(ExitCode::usage, in_quotes(path) + ": a frame's number has at most " +
                                     std::to_string(most_digits) + " digits");
  return pattern;
}

std::optional<FramePattern> FramePattern::of_number(const std::string& path) {
  const std::size_t name = path.find_last_of('/') + 1;  // npos + 1 is 0
  const std::string extension = fs::path(path).extension().string();
  const std::size_t end = path.size() - extension.size();
  const std::size_t last = path.find_last_of("0123456789", end ? end - 1 : 0);
  if (last == std::string::npos || last < name) return {};
  const std::size_t before = path.find_last_not_of("0123456789", last);
  FramePattern pattern;
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  pattern.before_ = path.substr(0, std::max(first, name));
  pattern.after_ = path.substr(last + 1);
  return pattern;
}

std::string FramePattern::path(int frame) const {
  return before_ + formatted("%0*d", int(std::max<std::size_t>(digits_, 1)), frame) + after_;
}

std::string FramePattern::printf_form() const {
  return before_ + (digits_ > 1 ? "%0" + std::to_string(digits_) + "d" : "%d") + after_;
}

std::optional<int> FramePattern::frame_of(const std::string& path) const {
  if (!path.starts_with(before_) || !path.ends_with(after_) ||
      path.size() <= before_.size() + after_.size())
    return {};
  const std::string number =
      path.substr(before_.size(), path.size() - before_.size() - after_.size());
  int frame = 0;
  if (number.size() > most_digits || number[0] == '-' || !read_number(number, frame)) return {};
  const bool padded = digits_ > 0;
  if (padded && number.size() < digits_) return {};
  if (padded && number.size() > digits_ && number[0] == '0') return {};
  return frame;
}

std::map<int, std::string> FramePattern::files() const {
  std::map<int, std::string> found;
  const fs::path folder = fs::path(before_).parent_path();
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, unreadable)) {
    const std::string path =
        before_.substr(0, before_.find_last_of('/') + 1) + entry.path().filename().string();
    if (const std::optional<int> frame = frame_of(path)) found.emplace(*frame, path);
  }
  return found;
}

std::vector<int> read_frames(const std::string& text, const std::string& option) {
  std::set<int> frames;
  for (const std::string& item : split(text)) {
    const Span span = read_span(item, option, text);
    for (long long frame = span.first; frame <= span.last; frame += span.step) {
      frames.insert(int(frame));
      if (frames.size() > most_frames)
        throw Error(ExitCode::usage, option + " " + in_quotes(text) + ": more than " +
                                         std::to_string(most_frames) + " frames");
    }
  }
  if (frames.empty()) refuse_frames(option, text);
  return {frames.begin(), frames.end()};
}

std::string frames_text(std::span<const int> frames) {
  std::vector<std::string> items;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i + 1;
    const int step = end < frames.size() ? frames[end] - frames[i] : 0;
    while (end < frames.size() && frames[end] - frames[end - 1] == step) ++end;
    if (end - i == 2 && step > 1) end = i + 1;  // two numbers are no series
    std::string item = std::to_string(frames[i]);
    if (end - i > 1) item += "-" + std::to_string(frames[end - 1]);
    if (end - i > 1 && step > 1) item += "x" + std::to_string(step);
    items.push_back(item);
    i = end;
  }
  return joined(items);
}

std::vector<int> gaps(const SequenceFiles& files) {
  std::vector<int> missing;
  int step = std::numeric_limits<int>::max(), common = 0;
  for (auto file = files.begin(), next = file; file != files.end(); file = next) {
    if (++next == files.end()) break;
    step = std::min(step, next->first - file->first);
    common = std::gcd(common, next->first - file->first);
  }
  if (common != step) return missing;  // the numbers follow no step
  for (auto file = files.begin(), next = file; file != files.end(); file = next)
    if (++next != files.end())
      for (int frame = file->first + step; frame < next->first; frame += step)
        missing.push_back(frame);
  return missing;
}

}  // namespace psivox
