#pragma once

#include <openvdb/io/Compression.h>
#include <openvdb/points/StreamCompression.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <ios>
#include <istream>
#include <string_view>
#include <type_traits>

namespace psivox::vdb {

/// Takes a value from a stream that has it as it is in memory.
template <typename T>
T take(std::istream& stream) {
  T value;
  stream.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

/// Whether values are equal; NaN is the same as NaN.
template <typename ValueT>
bool same_values(const ValueT& a, const ValueT& b) {
  return a == b || (!(a == a) && !(b == b));
}

/// How a grid's nodes store their values.
struct ValueCoding {
  std::uint32_t compression;  ///< flags of openvdb::io
  bool half;                  ///< 16 bits for each real number

  /// The coding of the grid at which the stream is.
  explicit ValueCoding(std::istream& stream)
      : compression(openvdb::io::getDataCompression(stream)),
        half(openvdb::io::getHalfFloat(stream)) {}

  bool has_lengths() const {
    return compression & (openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_BLOSC);
  }
};

/// What a node stores beside its active values, by the byte that stands before them.
struct StoredKind {
  int inactive = 0;   ///< how many inactive values
  bool mask = false;  ///< which inactive voxels have which
  bool all = false;   ///< all voxels' values in place of the active ones'

  explicit StoredKind(int kind) {
    using namespace openvdb::io;
    const bool two = kind == MASK_AND_TWO_INACTIVE_VALS;
    const bool one = kind == NO_MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_ONE_INACTIVE_VAL;
    inactive = two ? 2 : one ? 1 : 0;
    mask = two || kind == MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_NO_INACTIVE_VALS;
    all = kind == NO_MASK_AND_ALL_VALS;
  }
};

/// Bytes that must be free behind what is decompressed.
constexpr std::size_t blosc_overhead = 16;

/// Blosc's header, whose sizes before and after compression Blosc trusts. [bytes]
constexpr int blosc_header = 16;
inline bool blosc_header_fits(const char* header, std::int64_t size, std::int64_t length) {
  constexpr int size_at = 4, length_at = 12;
  std::uint32_t stored_size, stored_length;
  std::memcpy(&stored_size, header + size_at, sizeof stored_size);
  std::memcpy(&stored_length, header + length_at, sizeof stored_length);
  return length >= blosc_header && stored_size == size && stored_length == length;
}

/// Decompresses what Blosc has made of `size` bytes. Throws if it is not that.
inline void expand_blosc(std::string_view stored, char* to, std::size_t size) {
  if (stored.size() < blosc_header ||
      !blosc_header_fits(stored.data(), std::int64_t(size), std::int64_t(stored.size())))
    throw openvdb::IoError("a compressed block has an impossible length");
  openvdb::compression::bloscDecompress(to, size, size + blosc_overhead, stored.data());
}

/// Moves the stream from the beginning of a compressed block behind its end. Throws if the block
/// cannot hold `size` bytes: OpenVDB 10 believes the lengths that a file claims.
inline void skip_compressed(std::istream& stream, std::int64_t size, const ValueCoding& coding) {
  const auto length = take<std::int64_t>(stream);  // 0 or negative: the bytes are not compressed
  bool fits = length > 0 || length == -size;
  if (length > 0 && coding.compression & openvdb::io::COMPRESS_BLOSC) {  // OpenVDB's first choice
    const auto header = take<std::array<char, blosc_header>>(stream);
    stream.seekg(-blosc_header, std::ios_base::cur);
    fits = blosc_header_fits(header.data(), size, length);
  }
  if (!fits) throw openvdb::IoError("a block of its values has an impossible length");
  stream.seekg(length <= 0 ? size : length, std::ios_base::cur);
}

/// Moves the stream from the beginning of a node's values behind their end, for files since format
/// version 222. `active` is the node's mask of active values. Throws if a length is impossible.
template <typename ValueT, typename MaskT>
void skip_values(std::istream& stream, const MaskT& active, const ValueCoding& coding) {
  using namespace openvdb::io;
  const StoredKind kind(stream.get());
  const std::int64_t before = kind.inactive * static_cast<std::int64_t>(sizeof(ValueT)) +
                              (kind.mask ? static_cast<std::int64_t>(active.memUsage()) : 0);
  if (before > 0) stream.seekg(before, std::ios_base::cur);

  const bool all = kind.all || !(coding.compression & COMPRESS_ACTIVE_MASK);
  const std::int64_t count = all ? MaskT::SIZE : active.countOn();
  const bool half = coding.half && RealToHalf<ValueT>::isReal;
  if (half && count == 0) return;  // not even a length
  const std::int64_t size =
      count *
      static_cast<std::int64_t>(half ? sizeof(typename RealToHalf<ValueT>::HalfT) : sizeof(ValueT));
  if (coding.has_lengths()) {
    skip_compressed(stream, size, coding);
  } else {
    stream.seekg(size, std::ios_base::cur);
  }
}

}  // namespace psivox::vdb
