#include "file_buffer.h"

#include <algorithm>
#include <utility>

namespace psivox::vdb {
namespace {

// As long as reading goes on where it ended, runs grow. [bytes]
constexpr std::int64_t first_run = 64 << 10, longest_run = 1 << 20;

}  // namespace

FileBuffer::FileBuffer(FileBlocks& file, Progress progress)
    : file_(file), progress_(std::move(progress)), wanted_(first_run) {}

void FileBuffer::expect(std::int64_t bytes) {
  expected_from_ = reported_ = position();
  expected_ = std::max<std::int64_t>(bytes, 1);
}

void FileBuffer::report(std::int64_t reached) {
  if (!progress_ || expected_ == 0 || reached <= reported_) return;
  reported_ = reached;
  const double fraction =
      static_cast<double>(reached - expected_from_) / static_cast<double>(expected_);
  progress_(std::clamp(fraction, 0.0, 1.0));
}

bool FileBuffer::fetch(std::int64_t position) {
  const bool goes_on = position >= run_.end() && position < run_.end() + first_run;
  wanted_ = goes_on ? std::min(2 * wanted_, longest_run) : first_run;
  FileRun next = only_ > 0 ? file_.read(position, only_) : file_.run(position, wanted_);
  if (next.size == 0) return false;
  run_ = std::move(next);
  return true;
}

void FileBuffer::read_to(std::int64_t end) {
  begin_ = position();
  setg(nullptr, nullptr, nullptr);  // into the last run
  while (run_.end() < end && fetch(run_.end())) report(run_.end());
  report(end);  // of a small file, all is in the last run
}

FileBuffer::int_type FileBuffer::underflow() {
  const std::int64_t here = position();
  if (!run_.has(here)) {
    if (!fetch(here)) return traits_type::eof();
    report(here);
  }
  begin_ = run_.begin;
  char* const bytes = const_cast<char*>(run_.bytes.get());  // a streambuf's type; never written to
  setg(bytes, bytes + (here - begin_), bytes + run_.size);
  return traits_type::to_int_type(*gptr());
}

FileBuffer::pos_type FileBuffer::seekoff(off_type offset, std::ios_base::seekdir from,
                                         std::ios_base::openmode) {
  std::int64_t origin = 0;
  if (from == std::ios_base::cur) origin = position();
  if (from == std::ios_base::end) origin = file_.size();
  // A damaged file can hold any offset; the sum must not overflow.
  if (offset < -origin || offset > file_.size() - origin) return pos_type(off_type(-1));
  const std::int64_t target = origin + offset;
  if (target >= begin_ && target - begin_ <= egptr() - eback()) {
    setg(eback(), eback() + (target - begin_), egptr());
  } else {
    setg(nullptr, nullptr, nullptr);
    begin_ = target;
  }
  return pos_type(target);
}

FileBuffer::pos_type FileBuffer::seekpos(pos_type position, std::ios_base::openmode mode) {
  return seekoff(off_type(position), std::ios_base::beg, mode);
}

}  // namespace psivox::vdb
