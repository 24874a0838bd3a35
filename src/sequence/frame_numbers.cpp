#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "psivox/error.h"
#include "psivox/sequence.h"
#include "psivox/text.h"

namespace psivox {
namespace {

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
