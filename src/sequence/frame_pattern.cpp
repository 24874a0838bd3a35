#include <algorithm>
#include <filesystem>
#include <regex>

#include "psivox/error.h"
#include "psivox/sequence.h"
#include "psivox/text.h"

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

}  // namespace psivox
