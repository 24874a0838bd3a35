#pragma once

#include <openvdb/io/Compression.h>

#include <cstdint>
#include <istream>
#include <string_view>
#include <type_traits>

namespace psivox::vdb {

/// How a grid's nodes store their values.
struct ValueCoding {
  std::uint32_t compression;  ///< flags of openvdb::io
  bool half;                  ///< 16 bits for each real number

  bool has_lengths() const {
    return compression & (openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_BLOSC);
  }
};

/// Bytes that must be free behind what is decompressed.
constexpr std::size_t blosc_overhead = 16;

/// Decompresses what Blosc has made of `size` bytes. Throws if it is not that.
void expand_blosc(std::string_view stored, char* to, std::size_t size);

/// Moves the stream from the beginning of a compressed block behind its end. Throws if the block
/// cannot hold `size` bytes: OpenVDB 10 believes the lengths that a file claims.
void skip_compressed(std::istream& stream, std::int64_t size, const ValueCoding& coding);

/// Moves the stream from the beginning of a node's values behind their end, for files since format
/// version 222. `active` is the node's mask of active values. Throws if a length is impossible.
template <typename ValueT, typename MaskT>
void skip_values(std::istream& stream, const MaskT& active, const ValueCoding& coding) {
  using namespace openvdb::io;
  const int kind = stream.get();
  int inactive_values = 0;
  if (kind == NO_MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_ONE_INACTIVE_VAL)
    inactive_values = 1;
  if (kind == MASK_AND_TWO_INACTIVE_VALS) inactive_values = 2;
  const bool mask = kind == MASK_AND_NO_INACTIVE_VALS || kind == MASK_AND_ONE_INACTIVE_VAL ||
                    kind == MASK_AND_TWO_INACTIVE_VALS;
  const std::int64_t before = inactive_values * static_cast<std::int64_t>(sizeof(ValueT)) +
                              (mask ? static_cast<std::int64_t>(active.memUsage()) : 0);
  if (before > 0) stream.seekg(before, std::ios_base::cur);

  const bool all = kind == NO_MASK_AND_ALL_VALS || !(coding.compression & COMPRESS_ACTIVE_MASK);
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
