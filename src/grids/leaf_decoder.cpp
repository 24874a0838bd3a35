#include "archive.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <type_traits>
#include <utility>

#include "grid_types.h"

namespace psivox::vdb {
namespace {

constexpr std::size_t decoded_per_task = 64;
constexpr std::int64_t widest_gap = 4 << 10;  // that is read rather than skipped [bytes]

/// Calls op(leaf) with a null pointer of the grid's type of leaves.
template <typename Op>
void with_leaf_type(const openvdb::GridBase& grid, Op&& op) {
  with_typed_grid(grid, [&](const auto& typed) {
    op(static_cast<const typename std::decay_t<decltype(typed)>::TreeType::LeafNodeType*>(nullptr));
  });
}

/// Number of a leaf's active voxels, in place of its mask.
struct ActiveCount {
  static constexpr int SIZE = LeafMask::SIZE;
  int count;
  int countOn() const { return count; }
  std::size_t memUsage() const { return sizeof(LeafMask); }
};

/// Moves the stream from the end of a leaf's mask behind its values.
template <typename LeafT, typename MaskT>
void skip_behind_mask(std::istream& stream, const MaskT& active, const ValueCoding& coding) {
  constexpr int origin = 3 * 4;
  if constexpr (std::is_same_v<typename LeafT::ValueType, bool>)  // bits, which are not compressed
    stream.seekg(origin + std::streamoff(active.memUsage()), std::ios_base::cur);
  else
    skip_values<typename LeafT::ValueType>(stream, active, coding);
}

template <typename LeafT, typename Number>
void copy_leaf(const LeafT& leaf, Number* values) {
  using ValueT = typename LeafT::ValueType;
  if constexpr (std::is_same_v<ValueT, bool>) {
    for (openvdb::Index i = 0; i < LeafT::SIZE; ++i) values[i] = leaf.getValue(i) ? 1 : 0;
  } else if constexpr (openvdb::VecTraits<ValueT>::IsVec) {
    const ValueT* from = leaf.buffer().data();
    for (openvdb::Index i = 0; i < LeafT::SIZE; ++i)
      for (int c = 0; c < 3; ++c) *values++ = static_cast<Number>(from[i][c]);
  } else {
    const ValueT* from = leaf.buffer().data();
    for (openvdb::Index i = 0; i < LeafT::SIZE; ++i) values[i] = static_cast<Number>(from[i]);
  }
}

template <typename Number>
Number number_from(double value) {
  if constexpr (std::is_arithmetic_v<Number>)
    return static_cast<Number>(value);
  else  // half
    return Number(static_cast<float>(value));
}

/// Takes a number from the front of bytes, if they have it.
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

LeafDecoder::LeafDecoder(std::shared_ptr<FileBlocks> file, openvdb::GridBase::ConstPtr head,
                         std::istream& stream, std::optional<double> fill)
    : file_(std::move(file)),
      head_(std::move(head)),
      settings_(stream),
      coding_(stream),
      channels_(channels_of(head_->type())),
      fill_(fill) {
  settings_.setSeekable(false);  // so that a leaf reads its mask and does not skip it
  with_typed_grid(*head_, [&](const auto& typed) {
    settings_.setBackgroundPtr(&typed.tree().root().background());
  });
}

void LeafDecoder::skip(std::istream& stream) const {
  with_leaf_type(*head_, [&](const auto* type) {
    LeafMask mask;
    mask.load(stream);
    skip_behind_mask<std::decay_t<decltype(*type)>>(stream, mask, coding_);
  });
}

void LeafDecoder::skip(std::istream& stream, int active) const {
  with_leaf_type(*head_, [&](const auto* type) {
    stream.seekg(sizeof(LeafMask), std::ios_base::cur);
    skip_behind_mask<std::decay_t<decltype(*type)>>(stream, ActiveCount{active}, coding_);
  });
}

std::vector<std::int64_t> LeafDecoder::lengths(std::string_view metadata,
                                               const Topology& topology) const {
  using namespace openvdb::io;
  constexpr auto mask_bytes = static_cast<std::int64_t>(sizeof(LeafMask));
  const std::size_t count = topology.leaves.size();
  std::int64_t value_bytes = 0;
  with_leaf_type(*head_, [&](const auto* type) {
    value_bytes = sizeof(typename std::decay_t<decltype(*type)>::ValueType);
  });
  std::vector<std::int64_t> lengths;
  try {
    if (take_number(metadata) != count) return {};
    const auto kinds = take_array<std::int8_t>(metadata, count);
    lengths = take_array<std::int64_t>(metadata, kinds.size());
    for (std::size_t n = 0; n < lengths.size(); ++n) {
      const StoredKind kind(coding_.compression & COMPRESS_ACTIVE_MASK ? kinds[n]
                                                                       : int(NO_MASK_AND_ALL_VALS));
      // OpenVDB counts the length of a block of nothing, which half floats do not have
      if (coding_.half && !kind.all && topology.active[n] == 0) lengths[n] = 0;
      if (lengths[n] < 0 || lengths[n] > (1 << 20)) return {};
      lengths[n] += mask_bytes + 1 + kind.inactive * value_bytes + (kind.mask ? mask_bytes : 0);
    }
  } catch (const std::exception&) {  // of Blosc
    return {};
  }
  return lengths;
}

template <typename LeafT>
void LeafDecoder::decode_some(std::span<const LeafPlace> places, std::size_t first, bool in_runs,
                              const TakeLeaf& take) const {
  using openvdb::io::StreamMetadata;
  using ValueT = typename LeafT::ValueType;
  FileBuffer buffer(*file_);
  std::istream stream(&buffer);
  stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  StreamMetadata::Ptr metadata(new StreamMetadata(settings_));  // leaves count themselves in it
  openvdb::io::setStreamMetadataPtr(stream, metadata, /*transfer=*/true);
  LeafT leaf;
  const MadeLeaf decoded(leaf.getValueMask(), [&](auto* to) { copy_leaf(leaf, to); });
  std::size_t together = 0;  // leaves before this one are in what was read
  for (std::size_t n = 0; n < places.size(); ++n) {
    stream.seekg(places[n].begin);
    if (!in_runs && n == together) {
      while (++together < places.size())
        if (const auto gap = places[together].begin - places[together - 1].end;
            gap < 0 || gap > widest_gap)
          break;
      buffer.read_only(places[together - 1].end - places[n].begin);
    }
    LeafMask mask;
    mask.load(stream);
    skip_behind_mask<LeafT>(stream, mask, coding_);
    if (stream.tellg() != places[n].end)
      throw openvdb::IoError("a block of its values has another length");
    stream.seekg(places[n].begin);
    leaf.readBuffers(stream, settings_.halfFloat());
    if (fill_) {
      const auto& background = *static_cast<const ValueT*>(settings_.backgroundPtr());
      const ValueT fill(number_from<typename openvdb::VecTraits<ValueT>::ElementType>(*fill_));
      for (auto off = leaf.beginValueOff(); off; ++off)
        if (same_values<ValueT>(off.getValue(), background)) off.setValue(fill);
    }
    take(first + n, decoded);
  }
}

void LeafDecoder::decode(std::span<const LeafPlace> places, bool in_runs,
                         const TakeLeaf& take) const {
  const std::size_t tasks = (places.size() + decoded_per_task - 1) / decoded_per_task;
  with_leaf_type(*head_, [&](const auto* type) {
    using LeafT = std::decay_t<decltype(*type)>;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      const std::size_t begin = task * decoded_per_task;
      const std::size_t count = std::min(decoded_per_task, places.size() - begin);
      decode_some<LeafT>(places.subspan(begin, count), begin, in_runs, take);
    });
  });
}

}  // namespace psivox::vdb
