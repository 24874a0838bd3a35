#include "view/sequence.h"

#include <algorithm>

namespace psivox::view {

Sequence Sequence::of(const std::vector<std::string>& inputs) {
  Sequence sequence;
  const std::string& path = inputs.front();
  if (auto files = sequence_files(inputs)) {
    sequence.files_ = std::move(*files);
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

void Sequence::go_to(int frame) {
  const auto after = files_.lower_bound(frame);
  if (after == files_.end()) {
    current_ = last();
  } else if (after == files_.begin()) {
    current_ = first();
  } else {
    const int before = std::prev(after)->first;
    current_ = frame - before < after->first - frame ? before : after->first;
  }
}

void Sequence::play(std::chrono::steady_clock::time_point now) {
  if (!playing || now - stepped_at_ < std::chrono::duration<double>(1 / std::max(rate, 0.1)))
    return;
  stepped_at_ = now;
  go_to(next());
}

int Sequence::previous() const {
  const auto here = files_.find(current_);
  return here == files_.begin() ? last() : std::prev(here)->first;
}

int Sequence::next() const {
  const auto after = files_.upper_bound(current_);
  return after == files_.end() ? first() : after->first;
}

}  // namespace psivox::view
