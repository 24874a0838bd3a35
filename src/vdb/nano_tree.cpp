#include "nano_tree.h"

#include <nanovdb/NanoVDB.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace psivox::vdb {
namespace {

constexpr int nano_root_width = 4096;
constexpr std::size_t nano_alignment = 32;

[[noreturn]] void refuse_nano(const char* why) { throw std::runtime_error(why); }

/// A grid whose values NanoVDB stores as `BuildT`, read as if OpenVDB had stored them as `ValueT`.
/// All of its bytes are in memory.
template <typename BuildT, typename ValueT, bool points = false>
class NanoGrid final : public FileGrid {
  using Root = typename nanovdb::NanoRoot<BuildT>::DataType;
  using Upper = typename nanovdb::NanoUpper<BuildT>::DataType;
  using Lower = typename nanovdb::NanoLower<BuildT>::DataType;
  using Leaf = typename nanovdb::NanoLeaf<BuildT>::DataType;
  using StoredT = typename Root::ValueT;
  static constexpr bool quantised =
      std::is_same_v<BuildT, nanovdb::Fp4> || std::is_same_v<BuildT, nanovdb::Fp8> ||
      std::is_same_v<BuildT, nanovdb::Fp16> || std::is_same_v<BuildT, nanovdb::FpN>;

 public:
  explicit NanoGrid(const NanoSource& from)
      : FileGrid(from.file, from.entry, from.marked || is_mask(from.entry.type)),
        bytes_(from.bytes),
        memory_(from.memory) {
    begin(from.head, /*masks=*/false);
  }

  std::string why_whole() const override { return "its file has it as one block"; }
  std::shared_ptr<LeafReader> stored_leaves(const LeafSurvey&, std::string) override {
    return nullptr;
  }

 private:
  /// Walks the nodes, in OpenVDB's order.
  Topology read_topology(const TopologyWish& wish) override {
    leaves_.clear();
    lowers_ = uppers_ = 0;
    const std::uint64_t at = root_at();
    const Root& root = node<Root>(at);
    background_ = value_of(root.mBackground);
    head_.set_background(background_);
    TopologyBuilder<ValueT> found(wish);
    found.set_background(background_);
    const auto table = root_table(root, at);
    for (const auto& [origin, tile] : table)
      if (tile->child == 0)
        found.add_tile(origin, nano_root_width, value_of(tile->value), tile->state != 0);
    for (const auto& [origin, tile] : table)
      if (tile->child != 0) take_upper(found, child(at, tile->child), origin);
    return found.take();
  }

  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override {
    const std::size_t count = topology_.leaves.size();
    std::size_t end = enough ? 1 : count;
    for (std::size_t first = 0; first < count; first = end, end = 2 * first) {
      end = std::min(end, count);
      tbb::parallel_for(first, end, [&](std::size_t n) { decode(n, take); });
      if (enough && enough()) return;
    }
  }

  void decode(std::size_t n, const TakeLeaf& take) const {
    const Leaf& leaf = *reinterpret_cast<const Leaf*>(bytes_.data() + leaves_[n]);
    const auto mask = mask_of<LeafMask>(leaf.mValueMask);
    if constexpr (points) {
      const PointCounts counts =
          point_counts([&](std::size_t i) { return leaf.getValue(std::uint32_t(i)); });
      take(n, MadeLeaf(mask, each_voxel([&](std::size_t i) { return counts[i]; })));
    } else {
      take(n, MadeLeaf(mask, [&](auto* values) { copy(leaf, mask, values); }));
    }
  }

  template <typename Number>
  void copy(const Leaf& leaf, const LeafMask& active, Number* to) const {
    constexpr int channels = ValueTraits<ValueT>::channels;
    for (std::uint32_t i = 0; i < kLeafVoxels; ++i) {
      const ValueT value = value_of(leaf.getValue(i));
      if (fill_ && !active.isOn(i) && is_background(leaf, value))
        to = std::fill_n(to, channels, static_cast<Number>(*fill_));
      else
        for (int c = 0; c < channels; ++c) *to++ = component_of<Number>(value, c);
    }
  }

  static ValueT value_of(const StoredT& stored) {
    if constexpr (std::is_same_v<StoredT, bool>)  // its byte can have any value
      return reinterpret_cast<const unsigned char&>(stored) != 0;
    else if constexpr (ValueTraits<ValueT>::channels == 3)
      return ValueT(stored[0], stored[1], stored[2]);
    else
      return static_cast<ValueT>(stored);
  }

  /// OpenVDB's mask of the same bits.
  template <typename MaskT, typename StoredMaskT>
  static MaskT mask_of(const StoredMaskT& stored) {
    static_assert(sizeof(MaskT) == sizeof stored);
    MaskT mask;
    std::memcpy(static_cast<void*>(&mask), &stored, sizeof mask);
    return mask;
  }

  /// Quantised values, which may be dithered, are within a quantum of what they were.
  bool is_background(const Leaf& leaf, const ValueT& value) const {
    if constexpr (quantised)
      if (std::abs(value - background_) <= leaf.mQuantum) return true;
    return same_values(value, background_);
  }

  /// A node at this place, or several of one kind that follow each other.
  template <typename T>
  const T& node(std::uint64_t at, std::uint64_t bytes = sizeof(T)) const {
    if (at % nano_alignment != 0 || at > bytes_.size() || bytes > bytes_.size() - at)
      refuse_nano("a node is not within its bytes");
    return *reinterpret_cast<const T*>(bytes_.data() + at);
  }

  /// Where a child is, by its distance from its parent. [bytes]
  std::uint64_t child(std::uint64_t parent, std::int64_t distance) const {
    const std::uint64_t at = parent + static_cast<std::uint64_t>(distance);
    if (distance < 0 ? at > parent : at < parent) refuse_nano("a node is not within its bytes");
    return at;
  }

  std::uint64_t root_at() const {
    constexpr std::size_t tree_at = sizeof(nanovdb::GridData), root_offset = 24;
    std::uint64_t offset;
    if (bytes_.size() < tree_at + root_offset + sizeof offset) refuse_nano("its tree is cut off");
    std::memcpy(&offset, bytes_.data() + tree_at + root_offset, sizeof offset);
    if (offset > bytes_.size()) refuse_nano("a node is not within its bytes");
    return tree_at + offset;
  }

  using RootTable = std::vector<std::pair<glm::ivec3, const typename Root::Tile*>>;

  /// In OpenVDB's order.
  RootTable root_table(const Root& root, std::uint64_t at) const {
    using Tile = typename Root::Tile;
    const std::uint64_t count = root.mTableSize;
    const Tile* tiles = &node<Tile>(at + sizeof(Root), count * sizeof(Tile));
    RootTable table;
    for (std::uint64_t n = 0; n < count; ++n)
      table.emplace_back(origin_of(tiles[n].key), &tiles[n]);
    std::ranges::sort(table, comes_before, &RootTable::value_type::first);
    for (std::size_t n = 1; n < table.size(); ++n)
      if (table[n].first == table[n - 1].first) refuse_place();
    return table;
  }

  [[noreturn]] static void refuse_place() {
    refuse_nano("a node of its tree is at an impossible place");
  }

  /// x, y, z / 4096 in 21 bits each, of which the first is 0.
  static glm::ivec3 origin_of(std::uint64_t key) {
    constexpr std::uint64_t bits = 0xFFFFF;
    if (key & ~(bits | bits << 21 | bits << 42)) refuse_place();
    const auto part = [&](int shift) {
      return static_cast<int>(static_cast<std::uint32_t>((key >> shift & bits) * nano_root_width));
    };
    return {part(42), part(21), part(0)};
  }

  /// A damaged file can have many ways to the same node.
  template <typename T>
  void check_count(std::uint64_t nodes) const {
    if (nodes > bytes_.size() / sizeof(T)) refuse_nano("its nodes are more than its bytes");
  }

  /// The box of a node's active values begins in the node, unless it is empty.
  template <typename NodeT>
  static void check_box(const NodeT& node, const glm::ivec3& origin, int width) {
    const auto& box = node.mBBox;
    for (int axis = 0; axis < 3; ++axis)
      if (box[0][axis] > box[1][axis]) return;
    check_origin(box[0], origin, width);
  }
  template <typename PlaceT>
  static void check_origin(const PlaceT& place, const glm::ivec3& origin, int width) {
    for (int axis = 0; axis < 3; ++axis)
      if ((place[axis] & ~(width - 1)) != origin[axis]) refuse_place();
  }

  void take_upper(TopologyBuilder<ValueT>& found, std::uint64_t at, const glm::ivec3& origin) {
    check_count<Upper>(++uppers_);
    take_inner<Upper, 5>(found, at, origin, [&](std::uint64_t child_at, const glm::ivec3& place) {
      check_count<Lower>(++lowers_);
      take_inner<Lower, 4>(found, child_at, place,
                           [&](std::uint64_t leaf_at, const glm::ivec3& corner) {
                             take_leaf(found, leaf_at, corner);
                           });
    });
  }

  /// A node of 2^side tiles or children in each direction.
  template <typename NodeT, int side, typename TakeChild>
  void take_inner(TopologyBuilder<ValueT>& found, std::uint64_t at, const glm::ivec3& origin,
                  const TakeChild& take_child) {
    using MaskT = openvdb::util::NodeMask<side>;
    const NodeT& inner = node<NodeT>(at);
    check_box(inner, origin, 1 << (side + child_bits<side>));
    found.add_inner(
        origin, mask_of<MaskT>(inner.mChildMask), mask_of<MaskT>(inner.mValueMask),
        [&](unsigned n) { return value_of(inner.mTable[n].value); },
        [&](unsigned n, const glm::ivec3& place) {
          take_child(child(at, inner.mTable[n].child), place);
        });
  }

  void take_leaf(TopologyBuilder<ValueT>& found, std::uint64_t at, const glm::ivec3& origin) {
    const Leaf& leaf = node<Leaf>(at);
    if constexpr (std::is_same_v<BuildT, nanovdb::FpN>) {
      constexpr int widest = 4;  // 2^4 bits for each value
      const int width = leaf.mFlags >> 5;
      if (width > widest) refuse_nano("values of an impossible width");
      node<Leaf>(at, sizeof(Leaf) + (kLeafVoxels / 8 << width));
    }
    check_count<Leaf>(leaves_.size() + 1);
    const auto mask = mask_of<LeafMask>(leaf.mValueMask);
    if (!mask.isOff()) check_origin(leaf.mBBoxMin, origin, 8);
    leaves_.push_back(at);
    found.add_leaf(origin, mask);
  }

  std::span<const char> bytes_;
  std::shared_ptr<const void> memory_;
  ValueT background_{};
  std::vector<std::uint64_t> leaves_;
  std::uint64_t lowers_ = 0, uppers_ = 0;
};

template <typename BuildT, typename ValueT, bool points = false>
std::unique_ptr<FileGrid> opened(const NanoSource& source) {
  return std::make_unique<NanoGrid<BuildT, ValueT, points>>(source);
}

/// A type of grids and how it is read. What is stored in fewer bits than OpenVDB's types have
/// becomes the next wider one.
struct KnownType {
  nanovdb::GridType type;
  NanoType as;
  std::unique_ptr<FileGrid> (*open)(const NanoSource&) = nullptr;
};

const std::vector<KnownType>& known_types() {
  using nanovdb::GridType;
  static const std::vector<KnownType> types{
      {GridType::Float, {"float", grid_type_of("float")}, opened<float, float>},
      {GridType::Double, {"double", grid_type_of("double")}, opened<double, double>},
      {GridType::Int16, {"int16", grid_type_of("int32")}, opened<std::int16_t, std::int32_t>},
      {GridType::Int32, {"int32", grid_type_of("int32")}, opened<std::int32_t, std::int32_t>},
      {GridType::Int64, {"int64", grid_type_of("int64")}, opened<std::int64_t, std::int64_t>},
      {GridType::UInt32, {"uint32", grid_type_of("int64")}, opened<std::uint32_t, std::int64_t>},
      {GridType::Vec3f, {"Vec3f", grid_type_of("vec3s")}, opened<nanovdb::Vec3f, glm::vec3>},
      {GridType::Vec3d, {"Vec3d", grid_type_of("vec3d")}, opened<nanovdb::Vec3d, glm::dvec3>},
      {GridType::Mask, {"mask", grid_type_of("mask")}, opened<nanovdb::ValueMask, std::uint8_t>},
      {GridType::Boolean, {"bool", grid_type_of("bool")}, opened<bool, std::uint8_t>},
      {GridType::Fp4, {"Fp4", grid_type_of("float"), true}, opened<nanovdb::Fp4, float>},
      {GridType::Fp8, {"Fp8", grid_type_of("float"), true}, opened<nanovdb::Fp8, float>},
      {GridType::Fp16, {"Fp16", grid_type_of("float"), true}, opened<nanovdb::Fp16, float>},
      {GridType::FpN, {"FpN", grid_type_of("float"), true}, opened<nanovdb::FpN, float>},
      {GridType::Half, {"half"}},
      {GridType::RGBA8, {"RGBA8"}},
      {GridType::Vec4f, {"Vec4f"}},
      {GridType::Vec4d, {"Vec4d"}},
      {GridType::Index, {"index"}},
      // since version 32.5: not every header has them
      {GridType(20), {"OnIndex"}},
      {GridType(21), {"IndexMask"}},
      {GridType(22), {"OnIndexMask"}},
      {GridType(23), {"PointIndex"}},
      {GridType(24), {"Vec3u8"}},
      {GridType(25), {"Vec3u16"}},
      {GridType(26), {"uint8", grid_type_of("int32")}, opened<std::uint8_t, std::int32_t>}};
  return types;
}

const KnownType& find_type(std::uint32_t type, std::uint32_t grid_class) {
  static const KnownType unknown{nanovdb::GridType::Unknown, {"unknown"}};
  static const KnownType points{nanovdb::GridType::UInt32,
                                {"points", grid_type_of("points")},
                                opened<std::uint32_t, std::int32_t, /*points=*/true>};
  static const KnownType index{nanovdb::GridType::UInt32, {"point index"}};
  if (type == std::uint32_t(nanovdb::GridType::UInt32)) {
    if (grid_class == std::uint32_t(nanovdb::GridClass::PointData)) return points;
    if (grid_class == std::uint32_t(nanovdb::GridClass::PointIndex)) return index;
  }
  for (const KnownType& known : known_types())
    if (std::uint32_t(known.type) == type) return known;
  return unknown;
}

}  // namespace

NanoType nano_type(std::uint32_t type, std::uint32_t grid_class) {
  return find_type(type, grid_class).as;
}

std::unique_ptr<FileGrid> nano_grid(const NanoSource& source) {
  return find_type(source.type, source.grid_class).open(source);
}

}  // namespace psivox::vdb
