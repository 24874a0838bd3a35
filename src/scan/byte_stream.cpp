#include "scan/byte_stream.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>

#include "psivox/error.h"

namespace psivox::scan {
namespace {

constexpr std::int64_t run_bytes = 1 << 20, longest_line = 64 << 10;
constexpr uInt unpacked_bytes = 256 << 10;

}  // namespace

void refuse(const FileBlocks& file, const std::string& what) {
  throw Error(ExitCode::input, subject(file.path()) + what);
}

ByteStream::ByteStream(FileBlocks& file, std::int64_t begin, bool packed)
    : file_(file), in_file_(begin) {
  if (!packed) return;
  auto stream = std::make_unique<z_stream>();
  constexpr int window_bits = 15, zlib_or_gzip = 32;
  if (inflateInit2(stream.get(), window_bits + zlib_or_gzip) != Z_OK) throw std::bad_alloc();
  packed_ = std::move(stream);
  unpacked_ = std::make_unique_for_overwrite<char[]>(unpacked_bytes);
}

ByteStream::~ByteStream() {
  if (packed_) inflateEnd(packed_.get());
}

bool ByteStream::read_run() {
  try {
    run_ = file_.read(in_file_, run_bytes);
  } catch (const std::runtime_error& error) {
    refuse(file_, std::string("cannot be read: ") + error.what());
  }
  in_file_ += run_.size;
  return run_.size > 0;
}

bool ByteStream::fill() {
  if (packed_) return unpack();
  const bool more = read_run();
  here_ = run_.bytes.get();
  end_ = here_ + run_.size;
  return more;
}

bool ByteStream::unpack() {
  z_stream& stream = *packed_;
  while (!ended_) {
    if (stream.avail_in == 0) {
      if (!read_run()) return false;
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(run_.bytes.get()));
      stream.avail_in = uInt(run_.size);
    }
    stream.next_out = reinterpret_cast<Bytef*>(unpacked_.get());
    stream.avail_out = unpacked_bytes;
    const int result = inflate(&stream, Z_NO_FLUSH);
    if (result == Z_STREAM_END) {
      // a gzip may have several members; zeros after the last one are padding
      const bool more = stream.avail_in > 0 ? *stream.next_in == 0x1f : in_file_ < file_.size();
      ended_ = !more || inflateReset(&stream) != Z_OK;
    } else if (result != Z_OK && result != Z_BUF_ERROR) {
      refuse(file_, "its gzip is damaged");
    }
    here_ = unpacked_.get();
    end_ = here_ + (unpacked_bytes - stream.avail_out);
    if (here_ != end_) return true;
  }
  return false;
}

std::int64_t ByteStream::read(char* to, std::int64_t size) {
  std::int64_t done = 0;
  while (done < size && (here_ != end_ || fill())) {
    const std::int64_t some = std::min<std::int64_t>(size - done, end_ - here_);
    if (to) std::memcpy(to + done, here_, std::size_t(some));
    here_ += some;
    done += some;
  }
  position_ += done;
  return done;
}

void ByteStream::read_all(char* to, std::int64_t size) {
  if (read(to, size) < size) refuse(file_, "the file ends too early");
}

void ByteStream::pass_over(std::int64_t size) {
  const std::int64_t beyond = size - (end_ - here_);
  if (packed_ || beyond <= 0) return read_all(nullptr, size);
  here_ = end_;
  in_file_ += beyond;
  position_ += size;
}

std::int64_t ByteStream::pass_over_rest() {
  std::int64_t passed = 0;
  for (; here_ != end_ || fill(); here_ = end_) passed += end_ - here_;
  position_ += passed;
  return passed;
}

int ByteStream::next() {
  if (here_ == end_ && !fill()) return -1;
  ++position_;
  return static_cast<unsigned char>(*here_++);
}

std::string ByteStream::line() {
  std::string text;
  for (int c = next(); c >= 0 && c != '\n'; c = next()) {
    if (std::int64_t(text.size()) >= longest_line) refuse(file_, "a line has no end");
    text += char(c);
  }
  if (text.ends_with('\r')) text.pop_back();
  return text;
}

}  // namespace psivox::scan
