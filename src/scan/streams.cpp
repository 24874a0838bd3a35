#include "scan/streams.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>

#include "psivox/error.h"

namespace psivox::scan {
namespace {

constexpr std::int64_t run_bytes = 1 << 20, longest_line = 64 << 10;
constexpr uInt unpacked_bytes = 256 << 10;

constexpr std::int64_t values_at_once = 64 << 10;

/// A double beyond the floats is infinite, as the conversion of a .vdb has it.
float rounded(double value) {
  constexpr double most = double(std::numeric_limits<float>::max());
  if (std::abs(value) > most)
    return std::copysign(std::numeric_limits<float>::infinity(), float(std::copysign(1.0, value)));
  return float(value);
}

template <typename T>
void convert(const char* from, const Header& header, std::span<float> to) {
  const bool swapped = header.big_endian != (std::endian::native == std::endian::big);
  const bool scaled = header.slope != 1 || header.intercept != 0;
  for (float& value : to) {
    std::array<char, sizeof(T)> bytes;
    std::copy_n(from, sizeof(T), bytes.begin());
    if (swapped) std::ranges::reverse(bytes);
    from += sizeof(T);
    const auto stored = std::bit_cast<T>(bytes);
    if (scaled)
      value = rounded(header.slope * double(stored) + header.intercept);
    else if constexpr (std::is_same_v<T, double>)
      value = rounded(stored);
    else
      value = float(stored);
  }
}

struct TypeFacts {
  std::string_view name;
  int bytes;
  void (*convert)(const char* from, const Header& header, std::span<float> to);
};

template <typename T>
constexpr TypeFacts facts(std::string_view name) {
  return {name, int(sizeof(T)), convert<T>};
}

/// In the order of Type.
constexpr TypeFacts type_facts[] = {
    facts<std::int8_t>("int8"),     facts<std::uint8_t>("uint8"),   facts<std::int16_t>("int16"),
    facts<std::uint16_t>("uint16"), facts<std::int32_t>("int32"),   facts<std::uint32_t>("uint32"),
    facts<std::int64_t>("int64"),   facts<std::uint64_t>("uint64"), facts<float>("float32"),
    facts<double>("float64"),
};

bool is_space(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

int hex_digit(int c) {
  if (c >= '0' && c <= '9') return c - '0';
  const int lower = c | 0x20;
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/// Where lines have been passed over. They are those of the file, not of what is packed in it.
std::int64_t begin_of(const Header& header, FileBlocks& file) {
  ByteStream stream(file, header.begin);
  for (std::int64_t n = 0; n < header.lines; ++n) stream.line();
  return header.begin + stream.position();
}

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

void ByteStream::check_rest() {
  if (!packed_) return;
  pass_over_rest();
  if (!ended_) refuse(file_, "the file ends too early");
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

std::string_view name_of(Type type) { return type_facts[int(type)].name; }
int size_of(Type type) { return type_facts[int(type)].bytes; }

ValueStream::ValueStream(const Header& header, FileBlocks& file)
    : header_(header), bytes_(file, begin_of(header, file), header.encoding == Encoding::gzip) {
  bytes_.pass_over(header.skip);
}

void ValueStream::pass_over(std::int64_t values) {
  if (header_.encoding == Encoding::raw || header_.encoding == Encoding::gzip) {
    bytes_.pass_over(values * size_of(header_.type));
    position_ += values;
    return;
  }
  std::vector<float> passed(std::size_t(std::min(values, values_at_once)));
  for (; values > 0; values -= std::ssize(passed)) {
    passed.resize(std::size_t(std::min(values, values_at_once)));
    read(passed);
  }
}

void ValueStream::read(std::span<float> to) {
  position_ += std::ssize(to);
  if (header_.encoding == Encoding::text) {
    for (float& value : to) value = rounded(next_number());
    return;
  }
  while (!to.empty()) {
    const auto some = to.first(std::min(to.size(), std::size_t(values_at_once)));
    buffer_.resize(some.size() * std::size_t(size_of(header_.type)));
    read_bytes(buffer_.data(), std::ssize(buffer_));
    type_facts[int(header_.type)].convert(buffer_.data(), header_, some);
    to = to.subspan(some.size());
  }
  if (position_ == header_.values) bytes_.check_rest();
}

void ValueStream::read_bytes(char* to, std::int64_t size) {
  if (header_.encoding != Encoding::hex) return bytes_.read_all(to, size);
  for (; size > 0; --size) {
    int digits[2];
    for (int& digit : digits) {
      int c = bytes_.next();
      while (is_space(c)) c = bytes_.next();
      digit = hex_digit(c);
      if (digit < 0)
        refuse(bytes_.file(), c < 0 ? "the file ends too early" : "has a value that is no hex");
    }
    *to++ = char(digits[0] << 4 | digits[1]);
  }
}

double ValueStream::next_number() {
  // commas separate values, too
  const auto parts = [](int c) { return is_space(c) || c == ','; };
  int c = bytes_.next();
  while (parts(c)) c = bytes_.next();
  constexpr std::size_t longest = 400;
  buffer_.clear();
  for (; c >= 0 && !parts(c); c = bytes_.next()) {
    if (buffer_.size() == longest) refuse(bytes_.file(), "has a value that does not end");
    buffer_ += char(c);
  }
  if (buffer_.empty()) refuse(bytes_.file(), "the file ends too early");
  return number<double>(bytes_.file(), buffer_, "a value");
}

}  // namespace psivox::scan
