#include "archive.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <set>

// A tree in a .vdb: its nodes, and then its leaves.

namespace psivox::vdb {
namespace {

constexpr int root_child_width = 4096;

template <typename ValueT>
class TopologyReader {
 public:
  TopologyReader(GridHead& head, std::istream& stream, const ValueCoding& coding,
                 const TopologyWish& wish)
      : stream_(stream), coding_(coding), found_(wish) {
    read_root();
    head.set_background(background_);
  }

  Topology take() { return found_.take(); }

 private:
  glm::ivec3 read_origin() {
    const auto origin = vdb::take<glm::ivec3>(stream_);
    const bool within = (origin & ~(root_child_width - 1)) == origin;
    if (!within || !roots_.insert({origin.x, origin.y, origin.z}).second)
      throw std::runtime_error("a node of its root is at an impossible place");
    return origin;
  }

  void read_root() {
    vdb::take<std::uint32_t>(stream_);  // number of buffers
    background_ = vdb::take<ValueT>(stream_);
    found_.set_background(background_);
    auto tiles = vdb::take<std::uint32_t>(stream_), children = vdb::take<std::uint32_t>(stream_);
    for (; tiles > 0; --tiles) {
      const glm::ivec3 origin = read_origin();
      const auto value = vdb::take<ValueT>(stream_);
      found_.add_tile(origin, root_child_width, value, vdb::take<char>(stream_) != 0);
    }
    std::optional<glm::ivec3> last;
    for (; children > 0; --children) {
      const glm::ivec3 origin = read_origin();
      // the values of leaves come in that order
      if (last && !comes_before(*last, origin))
        throw std::runtime_error("the nodes of its root are out of order");
      last = origin;
      read_inner<5>(origin);
    }
  }

  /// A node of 2^side tiles or children in each direction.
  template <unsigned side>
  void read_inner(const glm::ivec3& origin) {
    using Mask = openvdb::util::NodeMask<side>;
    Mask children, active;
    children.load(stream_);
    active.load(stream_);
    const auto values = std::make_unique_for_overwrite<ValueT[]>(Mask::SIZE);
    read_values(stream_, active, background_, coding_, values.get());
    found_.template add_inner<side>(
        origin, children, active, [&](unsigned n) { return values[n]; },
        [&](unsigned, const glm::ivec3& place) {
          if constexpr (side == 4)
            read_leaf(place);
          else
            read_inner<4>(place);
        });
  }

  void read_leaf(const glm::ivec3& origin) {
    LeafMask mask;
    mask.load(stream_);
    found_.add_leaf(origin, mask);
  }

  std::istream& stream_;
  ValueCoding coding_;
  std::set<std::array<int, 3>> roots_;  ///< origins of tiles and nodes of the root
  ValueT background_{};
  TopologyBuilder<ValueT> found_;
};

}  // namespace

Topology read_topology(GridHead& head, std::istream& stream, const ValueCoding& coding,
                       const TopologyWish& wish) {
  return with_value_type(head.type, [&]<typename ValueT>() {
    return TopologyReader<ValueT>(head, stream, coding, wish).take();
  });
}

namespace {

constexpr std::size_t decoded_per_task = 64;
constexpr std::int64_t widest_gap = 4 << 10;  // that is read rather than skipped [bytes]

/// A leaf as its grid has it.
template <typename ValueT>
struct StoredLeaf {
  LeafMask active;
  std::array<ValueT, kLeafVoxels> values;
};

/// A leaf of bools stores its origin, and values as bits, which are not compressed. [bytes]
constexpr std::int64_t origin_of_bools = 3 * 4;

template <typename ValueT>
void skip_behind_mask(std::istream& stream, std::size_t active, const ValueCoding& coding) {
  if constexpr (is_bool<ValueT>)
    stream.seekg(origin_of_bools + std::int64_t(sizeof(LeafMask)), std::ios_base::cur);
  else
    skip_values<ValueT, LeafMask>(stream, active, coding);
}

template <typename ValueT>
void read_leaf(std::istream& stream, const ValueT& background, const ValueCoding& coding,
               StoredLeaf<ValueT>& leaf) {
  leaf.active.load(stream);
  if constexpr (is_bool<ValueT>) {
    stream.seekg(origin_of_bools, std::ios_base::cur);
    LeafMask values;
    values.load(stream);
    for (unsigned i = 0; i < kLeafVoxels; ++i) leaf.values[i] = values.isOn(i);
  } else {
    read_values(stream, leaf.active, background, coding, leaf.values.data());
  }
}

template <typename ValueT, typename Number>
void copy_values(const std::array<ValueT, kLeafVoxels>& from, Number* to) {
  for (const ValueT& value : from)
    for (int c = 0; c < ValueTraits<ValueT>::channels; ++c) *to++ = component_of<Number>(value, c);
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
  std::vector<T> array(count);
  if (*length == 0)
    std::memcpy(array.data(), stored.data(), size);
  else
    expand_blosc(stored, reinterpret_cast<char*>(array.data()), size);
  return array;
}

}  // namespace

void LeafDecoder::skip(std::istream& stream) const {
  LeafMask mask;
  mask.load(stream);
  with_value_type(head_.type, [&]<typename ValueT>() {
    skip_behind_mask<ValueT>(stream, mask.countOn(), coding_);
  });
}

void LeafDecoder::skip(std::istream& stream, std::size_t active) const {
  stream.seekg(sizeof(LeafMask), std::ios_base::cur);
  with_value_type(head_.type,
                  [&]<typename ValueT>() { skip_behind_mask<ValueT>(stream, active, coding_); });
}

std::vector<std::int64_t> LeafDecoder::lengths(std::string_view metadata,
                                               const Topology& topology) const {
  constexpr auto mask_bytes = static_cast<std::int64_t>(sizeof(LeafMask));
  const std::size_t count = topology.leaves.size();
  const std::int64_t value_bytes =
      with_value_type(head_.type, []<typename ValueT>() { return std::int64_t(sizeof(ValueT)); });
  std::vector<std::int64_t> lengths;
  try {
    if (take_number(metadata) != count) return {};
    const auto kinds = take_array<std::int8_t>(metadata, count);
    lengths = take_array<std::int64_t>(metadata, kinds.size());
    for (std::size_t n = 0; n < lengths.size(); ++n) {
      const StoredKind kind(
          coding_.compression & ValueCoding::active_mask ? kinds[n] : StoredKind::all_values);
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

template <typename ValueT>
void LeafDecoder::decode_some(std::span<const LeafPlace> places, std::size_t first, bool in_runs,
                              const TakeLeaf& take) const {
  const auto background = head_.background<ValueT>();
  FileBuffer buffer(*file_);
  std::istream stream(&buffer);
  stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  StoredLeaf<ValueT> leaf;
  const MadeLeaf decoded(leaf.active,
                         [&values = leaf.values](auto* to) { copy_values(values, to); });
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
    read_leaf(stream, background, coding_, leaf);
    if (stream.tellg() != places[n].end)
      throw std::runtime_error("a block of its values has another length");
    if (fill_) {
      const auto fill = value_from<ValueT>(*fill_);
      for (auto off = leaf.active.beginOff(); off; ++off)
        if (ValueT& value = leaf.values[off.pos()]; same_values(value, background)) value = fill;
    }
    take(first + n, decoded);
  }
}

void LeafDecoder::decode(std::span<const LeafPlace> places, bool in_runs,
                         const TakeLeaf& take) const {
  const std::size_t tasks = (places.size() + decoded_per_task - 1) / decoded_per_task;
  with_value_type(head_.type, [&]<typename ValueT>() {
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      const std::size_t begin = task * decoded_per_task;
      const std::size_t count = std::min(decoded_per_task, places.size() - begin);
      decode_some<ValueT>(places.subspan(begin, count), begin, in_runs, take);
    });
  });
}

}  // namespace psivox::vdb
