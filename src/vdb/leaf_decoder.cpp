#include "leaf_decoder.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "background.h"
#include "file_buffer.h"
#include "grid_types.h"
#include "leaf_floats.h"

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

template <typename LeafT>
constexpr bool of_bits = std::is_same_v<typename LeafT::ValueType, bool>;

}  // namespace

LeafDecoder::LeafDecoder(std::shared_ptr<FileBlocks> file, openvdb::GridBase::Ptr empty,
                         const openvdb::io::StreamMetadata& settings, bool vacuum)
    : file_(std::move(file)),
      empty_(std::move(empty)),
      settings_(settings),
      coding_{settings_.compression(), settings_.halfFloat()},
      channels_(channels_of(empty_->type())),
      vacuum_(vacuum) {
  settings_.setSeekable(false);  // so that a leaf reads its mask and does not skip it
  with_typed_grid(*empty_, [&](const auto& typed) {
    settings_.setBackgroundPtr(&typed.tree().root().background());
  });
}

std::int64_t LeafDecoder::value_bytes() const {
  std::int64_t size = 0;
  with_leaf_type(*empty_, [&](const auto* type) {
    size = sizeof(typename std::decay_t<decltype(*type)>::ValueType);
  });
  return size;
}

namespace {

/// Number of a leaf's active voxels, in place of its mask.
struct ActiveCount {
  static constexpr int SIZE = LeafMask::SIZE;
  int count;
  int countOn() const { return count; }
  std::size_t memUsage() const { return sizeof(LeafMask); }
};

/// Behind a leaf's mask.
template <typename LeafT, typename MaskT>
void skip_behind_mask(std::istream& stream, const MaskT& active, const ValueCoding& coding) {
  constexpr int origin = 3 * 4;
  if constexpr (of_bits<LeafT>)
    stream.seekg(origin + std::streamoff(active.memUsage()), std::ios_base::cur);
  else
    skip_values<typename LeafT::ValueType>(stream, active, coding);
}

}  // namespace

void LeafDecoder::skip(std::istream& stream) const {
  with_leaf_type(*empty_, [&](const auto* type) {
    LeafMask mask;
    mask.load(stream);
    skip_behind_mask<std::decay_t<decltype(*type)>>(stream, mask, coding_);
  });
}

void LeafDecoder::skip(std::istream& stream, int active) const {
  with_leaf_type(*empty_, [&](const auto* type) {
    stream.seekg(sizeof(LeafMask), std::ios_base::cur);
    skip_behind_mask<std::decay_t<decltype(*type)>>(stream, ActiveCount{active}, coding_);
  });
}

template <typename LeafT>
void LeafDecoder::decode_some(std::span<const LeafPlace> places, bool in_runs, float* values,
                              LeafMask* active) const {
  using openvdb::io::StreamMetadata;
  FileBuffer buffer(*file_);
  std::istream stream(&buffer);
  stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  StreamMetadata::Ptr metadata(new StreamMetadata(settings_));  // leaves count themselves in it
  openvdb::io::setStreamMetadataPtr(stream, metadata, /*transfer=*/true);
  LeafT leaf;
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
    if (vacuum_) {
      using ValueT = typename LeafT::ValueType;
      replace_off(leaf, *static_cast<const ValueT*>(settings_.backgroundPtr()),
                  openvdb::zeroVal<ValueT>());
    }
    convert_leaf(leaf, values + n * kLeafVoxels * static_cast<std::size_t>(channels_));
    if (active) active[n] = leaf.getValueMask();
  }
}

void LeafDecoder::decode(std::span<const LeafPlace> places, bool in_runs, float* values,
                         LeafMask* active) const {
  const std::size_t tasks = (places.size() + decoded_per_task - 1) / decoded_per_task;
  with_leaf_type(*empty_, [&](const auto* type) {
    using LeafT = std::decay_t<decltype(*type)>;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      const std::size_t begin = task * decoded_per_task;
      const std::size_t count = std::min(decoded_per_task, places.size() - begin);
      decode_some<LeafT>(places.subspan(begin, count), in_runs,
                         values + begin * kLeafVoxels * static_cast<std::size_t>(channels_),
                         active ? active + begin : nullptr);
    });
  });
}

}  // namespace psivox::vdb
