#include "leaf_lengths.h"

#include <openvdb/io/Compression.h>

#include <cstddef>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>

#include "leaf_decoder.h"

namespace psivox::vdb {
namespace {

/// Takes a number from the front.
std::optional<std::uint32_t> take_number(std::string_view& bytes) {
  std::uint32_t number;
  if (bytes.size() < sizeof number) return {};
  std::memcpy(&number, bytes.data(), sizeof number);
  bytes.remove_prefix(sizeof number);
  return number;
}

/// Takes an array, which OpenVDB has written as its length and what Blosc makes of it, or as 0 and
/// itself. Empty if it is no array of `count` items.
template <typename T>
std::vector<T> take_array(std::string_view& bytes, std::size_t count) {
  const std::optional<std::uint32_t> length = take_number(bytes);
  const std::size_t size = count * sizeof(T);
  const std::size_t taken = length.value_or(0) > 0 ? *length : size;
  if (!length || taken > bytes.size() || size > std::numeric_limits<std::int32_t>::max()) return {};
  const std::string_view stored = bytes.substr(0, taken);
  bytes.remove_prefix(taken);
  std::vector<T> array(count + blosc_overhead / sizeof(T));
  if (*length == 0)
    std::memcpy(array.data(), stored.data(), size);
  else
    expand_blosc(stored, reinterpret_cast<char*>(array.data()), size);
  array.resize(count);
  return array;
}

}  // namespace

std::vector<std::int64_t> leaf_lengths(std::string_view metadata, const Topology& topology,
                                       const ValueCoding& coding, std::int64_t value_bytes) {
  using namespace openvdb::io;
  const std::size_t count = topology.leaves.size();
  std::vector<std::int64_t> lengths;
  try {
    if (take_number(metadata) != count) return {};
    const auto kinds = take_array<std::int8_t>(metadata, count);
    lengths = take_array<std::int64_t>(metadata, kinds.size());
    for (std::size_t n = 0; n < lengths.size(); ++n) {
      const int kind =
          coding.compression & COMPRESS_ACTIVE_MASK ? kinds[n] : int(NO_MASK_AND_ALL_VALS);
      // OpenVDB counts the length of a block of nothing, which half floats do not have
      if (coding.half && kind != NO_MASK_AND_ALL_VALS && topology.active[n] == 0) lengths[n] = 0;
      if (lengths[n] < 0 || lengths[n] > (1 << 20)) return {};
      lengths[n] += static_cast<std::int64_t>(sizeof(LeafMask)) + 1;
      if (kind == NO_MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_ONE_INACTIVE_VAL)
        lengths[n] += value_bytes;
      if (kind == MASK_AND_TWO_INACTIVE_VALS) lengths[n] += 2 * value_bytes;
      if (kind == MASK_AND_NO_INACTIVE_VALS || kind == MASK_AND_ONE_INACTIVE_VAL ||
          kind == MASK_AND_TWO_INACTIVE_VALS)
        lengths[n] += static_cast<std::int64_t>(sizeof(LeafMask));
    }
  } catch (const std::exception&) {  // of Blosc
    return {};
  }
  return lengths;
}

}  // namespace psivox::vdb
