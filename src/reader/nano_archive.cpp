#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/IO.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "archives.h"
#include "base/memory.h"
#include "base/text.h"
#include "psivox/error.h"
#include "topology_builder.h"
#include "vdb/grids_module.h"

namespace psivox::vdb {
namespace {

constexpr std::string_view name_of_bare_grid = "NanoVDB1";
constexpr std::uint64_t greatest_ratio = 1100;  // of compression: zlib's is 1032, LZ4's 255
/// The only version whose files psivox reads, the one by which it is compiled.
constexpr std::uint32_t nano_major_version = NANOVDB_MAJOR_VERSION_NUMBER;

/// A grid's bytes in memory.
using NanoHandle = nanovdb::GridHandle<nanovdb::HostBuffer>;

/// What is stored of an entry.
struct StoredGrid {
  nanovdb::io::MetaData data{};
  std::uint64_t at = 0;  ///< its place in the file [bytes]
};

struct NanoSource {
  const GridFile& file;
  const GridEntry& entry;
  bool marked;  ///< see GridFile::open
  GridHead head;
  NanoHandle handle;
};

/// A grid whose values NanoVDB stores as `BuildT`, read as if OpenVDB had stored them as `ValueT`.
template <typename BuildT, typename ValueT, bool points = false>
class NanoGrid final : public FileGrid {
  using Leaf = nanovdb::NanoLeaf<BuildT>;
  using StoredT = typename nanovdb::NanoRoot<BuildT>::ValueType;
  using Tile = typename nanovdb::NanoRoot<BuildT>::DataType::Tile;
  static constexpr bool quantised =
      std::is_same_v<BuildT, nanovdb::Fp4> || std::is_same_v<BuildT, nanovdb::Fp8> ||
      std::is_same_v<BuildT, nanovdb::Fp16> || std::is_same_v<BuildT, nanovdb::FpN>;

 public:
  explicit NanoGrid(NanoSource& from)
      : FileGrid(from.file, from.entry, from.marked), handle_(std::move(from.handle)) {
    begin(std::move(from.head));
  }

  std::string why_whole() const override { return "its file has it as one block"; }

 private:
  /// Walks the nodes, in OpenVDB's order.
  Topology read_topology() override {
    leaves_.clear();
    const auto& root =
        reinterpret_cast<const nanovdb::NanoGrid<BuildT>*>(handle_.data())->tree().root();
    background_ = value_of(root.background());
    TopologyBuilder<ValueT> found(fill_, background_);
    const auto& data = *root.data();
    if (data.mTableSize > handle_.size() / sizeof(Tile))
      throw std::runtime_error("its nodes are more than its bytes");
    std::vector<const Tile*> table;
    for (std::uint32_t n = 0; n < data.mTableSize; ++n) table.push_back(data.tile(n));
    std::ranges::sort(table, comes_before, [](auto* tile) { return place(tile->origin()); });
    for (const auto* tile : table)
      if (!tile->isChild())
        found.add_tile(place(tile->origin()), nanovdb::NanoUpper<BuildT>::DIM,
                       value_of(tile->value), tile->state != 0);
    for (const auto* tile : table)
      if (tile->isChild()) take_node(found, *data.getChild(tile), place(tile->origin()));
    return found.take();
  }

  static glm::ivec3 place(const nanovdb::Coord& at) { return {at[0], at[1], at[2]}; }

  template <typename NodeT>
  void take_node(TopologyBuilder<ValueT>& found, const NodeT& node, const glm::ivec3& origin) {
    if constexpr (NodeT::LEVEL == 0) {
      leaves_.push_back(&node);
      found.add_leaf(origin, mask_of(node.valueMask()));
    } else {
      constexpr int width = NodeT::ChildNodeType::DIM, side = NodeT::LOG2DIM;
      constexpr std::uint32_t low = (1u << side) - 1;
      const auto place_of_child = [&](std::uint32_t n) {
        return origin + width * glm::ivec3(n >> 2 * side, n >> side & low, n & low);
      };
      const auto& data = *node.data();
      for (std::uint32_t n = 0; n < NodeT::SIZE; ++n)
        if (!data.mChildMask.isOn(n))
          found.add_tile(place_of_child(n), width, value_of(data.mTable[n].value),
                         data.mValueMask.isOn(n));
      for (auto n = data.mChildMask.beginOn(); n; ++n)
        take_node(found, *data.getChild(*n), place_of_child(*n));
    }
  }

  bool can_be(double value) const override { return value_can_be<ValueT>(value); }

  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override {
    std::size_t end = enough ? 1 : leaves_.size();
    for (std::size_t first = 0; first < leaves_.size(); first = end, end = 2 * first) {
      end = std::min(end, leaves_.size());
      tbb::parallel_for(first, end, [&](std::size_t n) { decode(n, take); });
      if (enough && enough()) return;
    }
  }

  void decode(std::size_t n, const TakeLeaf& take) const {
    const auto& leaf = *leaves_[n]->data();
    const LeafMask active = mask_of(leaf.mValueMask);
    take(n, MadeLeaf(active, [&](auto* to) {
           std::uint32_t last = 0;  // of points: the offset behind a voxel's last one
           for (std::uint32_t i = 0; i < kLeafVoxels; ++i) {
             ValueT value = value_of(leaf.getValue(i));
             if constexpr (points)
               value = ValueT(leaf.getValue(i) - std::exchange(last, leaf.getValue(i)));
             const bool fills = fill_ && !active.is_on(i) && is_background(leaf, value);
             for (int c = 0; c < channels_of_value<ValueT>; ++c)
               *to++ = fills ? static_cast<std::decay_t<decltype(*to)>>(*fill_)
                             : component_of<std::decay_t<decltype(*to)>>(value, c);
           }
         }));
  }

  static ValueT value_of(const StoredT& stored) {
    if constexpr (channels_of_value<ValueT> == 3)
      return ValueT(stored[0], stored[1], stored[2]);
    else
      return static_cast<ValueT>(stored);
  }

  /// Quantised values, which may be dithered, are within a quantum of what they were.
  bool is_background(const typename Leaf::DataType& leaf, const ValueT& value) const {
    if constexpr (quantised)
      if (std::abs(value - background_) <= leaf.mQuantum) return true;
    return same_values(value, background_);
  }

  NanoHandle handle_;
  ValueT background_{};
  std::vector<const Leaf*> leaves_;
};

/// A type of grids and how it is read. What is stored in fewer bits than OpenVDB's types have
/// becomes the next wider one.
struct NanoType {
  nanovdb::GridType type{};
  std::string name;         ///< NanoVDB's: float, Fp8, ...
  std::string grid_type{};  ///< OpenVDB's type with these values; empty if it cannot be rendered
  bool quantised = false;
  std::unique_ptr<FileGrid> (*open)(NanoSource&) = nullptr;
};

template <typename BuildT, typename ValueT, bool points = false>
NanoType known_type(nanovdb::GridType type, const std::string& name, std::string_view value_type,
                    bool quantised = false) {
  return {type, name, grid_type_of(value_type), quantised,
          [](NanoSource& source) -> std::unique_ptr<FileGrid> {
            return std::make_unique<NanoGrid<BuildT, ValueT, points>>(source);
          }};
}

const NanoType& nano_type(nanovdb::GridType type, nanovdb::GridClass grid_class) {
  using nanovdb::GridType;
  static const NanoType types[] = {
      known_type<float, float>(GridType::Float, "float", "float"),
      known_type<double, double>(GridType::Double, "double", "double"),
      known_type<std::int16_t, std::int32_t>(GridType::Int16, "int16", "int32"),
      known_type<std::int32_t, std::int32_t>(GridType::Int32, "int32", "int32"),
      known_type<std::int64_t, std::int64_t>(GridType::Int64, "int64", "int64"),
      known_type<std::uint32_t, std::int64_t>(GridType::UInt32, "uint32", "int64"),
      known_type<nanovdb::Vec3f, openvdb::Vec3f>(GridType::Vec3f, "Vec3f", "vec3s"),
      known_type<nanovdb::Vec3d, openvdb::Vec3d>(GridType::Vec3d, "Vec3d", "vec3d"),
      known_type<nanovdb::ValueMask, bool>(GridType::Mask, "mask", "mask"),
      known_type<bool, bool>(GridType::Boolean, "bool", "bool"),
      known_type<nanovdb::Fp4, float>(GridType::Fp4, "Fp4", "float", true),
      known_type<nanovdb::Fp8, float>(GridType::Fp8, "Fp8", "float", true),
      known_type<nanovdb::Fp16, float>(GridType::Fp16, "Fp16", "float", true),
      known_type<nanovdb::FpN, float>(GridType::FpN, "FpN", "float", true),
      {GridType::Half, "half"},
      {GridType::RGBA8, "RGBA8"},
      {GridType::Vec4f, "Vec4f"},
      {GridType::Vec4d, "Vec4d"},
      {GridType::Index, "index"},
      // since version 32.5: not every header has them
      {GridType(20), "OnIndex"},
      {GridType(21), "IndexMask"},
      {GridType(22), "OnIndexMask"},
      {GridType(23), "PointIndex"},
      {GridType(24), "Vec3u8"},
      {GridType(25), "Vec3u16"},
      known_type<std::uint8_t, std::int32_t>(GridType(26), "uint8", "int32")};
  static const NanoType unknown{GridType::Unknown, "unknown"},
      index{GridType::UInt32, "point index"},
      points = known_type<std::uint32_t, std::int32_t, true>(GridType::UInt32, "points", "points");
  if (type == GridType::UInt32 && grid_class == nanovdb::GridClass::PointData) return points;
  if (type == GridType::UInt32 && grid_class == nanovdb::GridClass::PointIndex) return index;
  const auto* const found = std::ranges::find(types, type, &NanoType::type);
  return found == std::end(types) ? unknown : *found;
}

/// Before version 29 the halves of the number were major and minor.
void check_version(const std::string& path, std::uint32_t version) {
  if (version >> 21 == nano_major_version) return;
  const bool old = version >> 21 == 0;
  const std::string text = std::to_string(old ? version & 0xFFFF : version >> 21) + "." +
                           std::to_string(old ? version >> 16 : version >> 10 & 0x7FF);
  throw Error(ExitCode::input, subject(path) + "was written by NanoVDB " + text +
                                   ", psivox reads " + std::to_string(nano_major_version) +
                                   ": convert the .vdb again");
}

std::string_view class_of(nanovdb::GridClass grid_class) {
  using nanovdb::GridClass;
  return grid_class == GridClass::LevelSet    ? level_set_class
         : grid_class == GridClass::FogVolume ? fog_class
         : grid_class == GridClass::Staggered ? staggered_class
                                              : unknown_class;
}

/// A .nvdb open for reading, its directory read. The file is a sequence of segments: a header, an
/// entry for each grid, and the bytes of each grid, which are compressed as one block. Since
/// version 32.6 a file can also be a sequence of bare grids.
class NanoArchive final : public GridFile {
 public:
  NanoArchive(std::shared_ptr<FileBlocks> file, Progress progress)
      : GridFile(std::move(file), std::move(progress)) {
    list_entries("NanoVDB", [&] {
      do read_segment();
      while (stream_.tellg() < file_->size());
    });
  }

  EntryHead entry_head(const GridEntry& entry) override {
    const nanovdb::io::MetaData& data = stored(entry).data;
    const auto corner = [&](int n) {
      const auto& at = data.worldBBox[n];
      return glm::dvec3(at[0], at[1], at[2]);
    };
    const nanovdb::Vec3R& size = data.voxelSize;
    return {{{"class", std::string(class_of(data.gridClass))}},
            {.voxels = data.voxelCount,
             .known = data.nameSize > 0,  // a bare grid has no entry
             .world_min = corner(0),
             .world_max = corner(1),
             .voxel_size = std::min({size[0], size[1], size[2]})}};
  }

  std::unique_ptr<FileGrid> opened(const GridEntry& entry, bool marked) override {
    const nanovdb::io::MetaData& data = stored(entry).data;
    NanoSource source{*this, entry, marked, {}, unpacked(entry)};
    source.head = head_of(data, source.handle);
    return nano_type(data.gridType, data.gridClass).open(source);
  }

 private:
  const StoredGrid& stored(const GridEntry& entry) const {
    return stored_[std::size_t(&entry - entries_.data())];
  }

  void read_segment() {
    const std::int64_t at = stream_.tellg();
    nanovdb::io::Header header;
    stream_.read(reinterpret_cast<char*>(&header), sizeof header);
    const std::string_view magic(reinterpret_cast<const char*>(&header.magic), 8);
    stream_.seekg(at);
    if (magic == name_of_bare_grid) return read_bare_grid(at);
    if (!magic.starts_with(nano_magic))
      throw std::runtime_error("something else follows its grids");
    check_version(path(), header.version.id());
    nanovdb::io::Segment segment;
    segment.read(stream_);
    if (segment.meta.empty()) throw std::runtime_error("it has no grid");
    const std::size_t first = entries_.size();
    for (nanovdb::io::GridMetaData& grid : segment.meta) {
      grid.codec = header.codec;
      add_entry(grid.gridName, grid);
    }
    place_entries(first, std::uint64_t(stream_.tellg()));
  }

  /// A grid without a segment's header and entry, as NanoVDB has it in memory.
  void read_bare_grid(std::int64_t at) {
    nanovdb::GridData head;
    stream_.read(reinterpret_cast<char*>(&head), sizeof head);
    check_version(path(), head.mVersion.id());
    if (head.mGridSize < sizeof head) throw std::runtime_error("a grid has an impossible size");
    nanovdb::io::MetaData data{};
    data.gridSize = data.fileSize = head.mGridSize;
    data.gridType = head.mGridType;
    data.gridClass = head.mGridClass;
    add_entry(std::string(head.mGridName, strnlen(head.mGridName, sizeof head.mGridName)), data);
    place_entries(entries_.size() - 1, std::uint64_t(at));
  }

  void add_entry(const std::string& name, const nanovdb::io::MetaData& grid) {
    const NanoType& type = nano_type(grid.gridType, grid.gridClass);
    GridEntry listed;
    listed.unique_name = name;
    listed.type = type.grid_type.empty() ? type.name : type.grid_type;
    if (type.grid_type.empty()) listed.problem = unsupported_type(type.name);
    entries_.push_back(std::move(listed));
    stored_.push_back({grid});
  }

  /// The grids of a segment follow each other. Moves the stream behind them. A grid that the file's
  /// end cuts short gets a problem.
  void place_entries(std::size_t first, std::uint64_t at) {
    const auto size = std::uint64_t(file_->size());
    for (std::size_t n = first; n < entries_.size(); ++n) {
      stored_[n].at = at;
      if (const std::uint64_t bytes = stored_[n].data.fileSize; bytes > size - at) {
        entries_[n].problem = "is cut short: it needs " + std::to_string(bytes) +
                              " bytes, the file has " + std::to_string(size - at) + " for it";
        ++lost_;
        at = size;
      } else {
        at += bytes;
      }
    }
    stream_.seekg(std::streamoff(at));
  }

  /// A grid's bytes, decompressed. Throws std::runtime_error if the file is damaged, Error(memory)
  /// if they need more memory than there is.
  NanoHandle unpacked(const GridEntry& entry) {
    const auto& [data, at] = stored(entry);
    if (data.codec >= nanovdb::io::Codec::END)
      throw std::runtime_error("it is compressed by an unknown codec");
    const bool whole = data.codec == nanovdb::io::Codec::NONE;
    if (data.gridSize < sizeof(nanovdb::GridData) ||
        (whole ? data.gridSize != data.fileSize : data.gridSize / greatest_ratio > data.fileSize))
      throw std::runtime_error("its size is impossible");
    const std::uint64_t available = available_memory();
    if (available > 0 && data.gridSize > available)
      throw Error(ExitCode::memory, subject(path(), entry.name) + "needs " +
                                        mebibytes(data.gridSize) + " of memory, there are " +
                                        mebibytes(available));
    NanoHandle handle(nanovdb::HostBuffer::create(data.gridSize));
    stream_.clear();
    stream_.seekg(std::streamoff(at));
    buffer_.expect(std::int64_t(data.fileSize));
    nanovdb::io::Internal::read(stream_, handle, data.codec);
    return handle;
  }

  static GridHead head_of(const nanovdb::io::MetaData& entry, const NanoHandle& handle) {
    const auto& data = *reinterpret_cast<const nanovdb::GridData*>(handle.data());
    if (data.mVersion.getMajor() != nano_major_version || data.mGridType != entry.gridType ||
        data.mGridClass != entry.gridClass || data.mGridSize > handle.size())
      throw std::runtime_error("its header and the file's directory differ");
    const NanoType& known = nano_type(entry.gridType, entry.gridClass);
    GridHead head{.type = known.grid_type, .grid_class = class_of(entry.gridClass)};
    if (known.quantised) head.metadata["nanovdb_type"] = known.name;
    const nanovdb::Map& map = data.mMap;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        head.transform.world_from_index[column][row] = map.mMatD[3 * row + column];
      head.transform.world_from_index[3][row] = map.mVecD[row];
    }
    return head;
  }

  std::vector<StoredGrid> stored_;  ///< of each entry
};

}  // namespace

std::unique_ptr<GridFile> open_nano(std::shared_ptr<FileBlocks> file, Progress progress) {
  return std::make_unique<NanoArchive>(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
