#include <nanovdb/NanoVDB.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "nano_tree.h"
#include "psivox/error.h"
#include "values.h"

namespace psivox::vdb {
namespace {

enum Codec : std::uint16_t { none, zip, blosc };

/// The header of a segment.
struct SegmentHeader {
  std::array<char, 8> magic;
  std::uint32_t version;  ///< major in 11 bits, minor in 11, patch in 10
  std::uint16_t grids;
  std::uint16_t codec;
};
static_assert(sizeof(SegmentHeader) == 16);

/// The directory's entry of a grid, before its name, as nanovdb::io::MetaData.
struct NanoEntry {
  std::uint64_t memory, bytes, name_key, active_voxels;
  std::uint32_t type, grid_class;
  std::array<double, 6> world_box;
  std::array<std::int32_t, 6> index_box;
  std::array<double, 3> voxel_size;
  std::uint32_t name_length;  ///< with the 0 at its end
  std::array<std::uint32_t, 4> nodes;
  std::array<std::uint32_t, 3> tiles;
  std::uint16_t codec, padding;
  std::uint32_t version;
};
static_assert(sizeof(NanoEntry) == 176);

constexpr std::string_view name_of_format = "NanoVDB", name_of_bare_grid = "NanoVDB1";
constexpr std::uint64_t blosc_chunk = 1 << 30;    // that Blosc compresses at a time [bytes]
constexpr std::uint64_t longest_name = 64 << 10;  // [bytes]
constexpr std::uint64_t greatest_ratio = 1100;    // zlib's is 1032, LZ4's 255

/// The only version whose files psivox reads, the one by which it is compiled.
constexpr std::uint32_t nano_major_version = NANOVDB_MAJOR_VERSION_NUMBER;

/// Before version 29 the halves of the number were major and minor.
std::string version_text(std::uint32_t version) {
  const bool old = version >> 21 == 0;
  return std::to_string(old ? version & 0xFFFF : version >> 21) + "." +
         std::to_string(old ? version >> 16 : version >> 10 & 0x7FF);
}

void check_version(const std::string& path, std::uint32_t version) {
  if (version >> 21 == nano_major_version) return;
  throw Error(ExitCode::input, subject(path) + "was written by NanoVDB " + version_text(version) +
                                   ", psivox reads " + std::to_string(nano_major_version) +
                                   ": convert the .vdb again");
}

/// What is stored of an entry.
struct StoredGrid {
  std::uint64_t memory = 0;  ///< size of the grid [bytes]
  std::uint64_t bytes = 0;   ///< its size in the file [bytes]
  std::uint64_t at = 0;      ///< its place in the file [bytes]
  std::uint32_t type = 0, grid_class = 0;
  std::uint16_t codec = 0;
  GridPlace place{};
};

/// An enumeration of a file, which can have any value.
template <typename Enum>
std::uint32_t number_of(const Enum& stored) {
  std::uint32_t number;
  static_assert(sizeof number == sizeof stored);
  std::memcpy(&number, &stored, sizeof number);
  return number;
}

std::string_view nano_class(std::uint32_t grid_class) {
  switch (nanovdb::GridClass(grid_class)) {
    case nanovdb::GridClass::LevelSet:
      return level_set_class;
    case nanovdb::GridClass::FogVolume:
      return fog_class;
    case nanovdb::GridClass::Staggered:
      return staggered_class;
    default:
      return unknown_class;
  }
}

/// Throws std::runtime_error if the bytes are not that grid's.
GridHead head_of(const StoredGrid& from, std::span<const char> bytes) {
  if (bytes.size() < sizeof(nanovdb::GridData)) throw std::runtime_error("its header is cut off");
  const auto& data = *reinterpret_cast<const nanovdb::GridData*>(bytes.data());
  if (data.mVersion.getMajor() != nano_major_version || number_of(data.mGridType) != from.type ||
      number_of(data.mGridClass) != from.grid_class || data.mGridSize > bytes.size())
    throw std::runtime_error("its header and the file's directory differ");
  const NanoType known = nano_type(from.type, from.grid_class);
  GridHead head;
  head.type = value_type_number(stored_like(known.grid_type));
  head.grid_class = nano_class(from.grid_class);
  if (known.quantised) head.metadata["nanovdb_type"] = known.name;
  const nanovdb::Map& map = data.mMap;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      head.transform.world_from_index[column][row] = map.mMatD[3 * row + column];
    head.transform.world_from_index[3][row] = map.mVecD[row];
  }
  return head;
}

/// A .nvdb open for reading, its directory read. The file is a sequence of segments: a header, an
/// entry for each grid, and the bytes of each grid, which are compressed as one block. Since
/// version 32.6 a file can also be a sequence of bare grids.
class NanoFile final : public GridFile {
 public:
  NanoFile(std::shared_ptr<FileBlocks> file, Progress progress)
      : GridFile(std::move(file), std::move(progress)) {
    const auto read_segments = [&] {
      do {
        read_segment();
      } while (stream_.tellg() < file_->size());
    };
    or_input_error(read_segments, [&](const std::exception& e) {
      return subject(path()) + "is a damaged NanoVDB file: " + explain(e);
    });
    name_entries();
  }

  EntryHead entry_head(const GridEntry& entry) override {
    return {{{"class", std::string(nano_class(stored(entry).grid_class))}}, stored(entry).place};
  }

  std::unique_ptr<FileGrid> open(const GridEntry& entry, bool marked) override {
    std::unique_ptr<FileGrid> grid;
    guarded(entry, [&] {
      const auto [memory, bytes] = unpacked(entry);
      const StoredGrid& from = stored(entry);
      grid = nano_grid(
          {*this, entry, marked, head_of(from, bytes), from.type, from.grid_class, bytes, memory});
    });
    return grid;
  }

 private:
  const StoredGrid& stored(const GridEntry& entry) const {
    return stored_[std::size_t(&entry - entries_.data())];
  }

  void read_segment() {
    const auto header = take<SegmentHeader>(stream_);
    const std::string_view magic(header.magic.data(), header.magic.size());
    if (magic == name_of_bare_grid) return read_bare_grid();
    if (!magic.starts_with(name_of_format))
      throw std::runtime_error("something else follows its grids");
    check_version(path(), header.version);
    if (header.grids == 0) throw std::runtime_error("it has no grid");
    const std::size_t first = entries_.size();
    for (std::uint16_t n = 0; n < header.grids; ++n) read_entry(header.codec);
    place_entries(first, std::uint64_t(stream_.tellg()));
  }

  /// A grid without a segment's header and entry, as NanoVDB has it in memory.
  void read_bare_grid() {
    const std::uint64_t at = std::uint64_t(stream_.tellg()) - sizeof(SegmentHeader);
    stream_.seekg(std::streamoff(at));
    const auto head = take<nanovdb::GridData>(stream_);
    check_version(path(), head.mVersion.id());
    if (head.mGridSize < sizeof head) throw std::runtime_error("a grid has an impossible size");
    add_entry({head.mGridName, sizeof head.mGridName},
              {head.mGridSize, head.mGridSize, 0, number_of(head.mGridType),
               number_of(head.mGridClass), none});
    place_entries(entries_.size() - 1, at);
  }

  void read_entry(std::uint16_t codec) {
    const auto entry = take<NanoEntry>(stream_);
    if (entry.name_length > longest_name)
      throw std::runtime_error("a name has an impossible length");
    std::string name(entry.name_length, '\0');
    stream_.read(name.data(), std::streamsize(name.size()));
    const auto& box = entry.world_box;
    const GridPlace place{entry.active_voxels,
                          true,
                          {box[0], box[1], box[2]},
                          {box[3], box[4], box[5]},
                          *std::ranges::min_element(entry.voxel_size)};
    add_entry(std::move(name),
              {entry.memory, entry.bytes, 0, entry.type, entry.grid_class, codec, place});
  }

  /// The name may end before its text.
  void add_entry(std::string name, const StoredGrid& grid) {
    name.resize(std::min(name.find('\0'), name.size()));
    const NanoType type = nano_type(grid.type, grid.grid_class);
    GridEntry listed;
    listed.unique_name = std::move(name);
    listed.type = type.grid_type.empty() ? type.name : type.grid_type;
    if (type.grid_type.empty()) listed.problem = unsupported_type(type.name);
    entries_.push_back(std::move(listed));
    stored_.push_back(grid);
  }

  /// The grids of a segment follow each other. Moves the stream behind them. A grid that the file's
  /// end cuts short gets a problem.
  void place_entries(std::size_t first, std::uint64_t at) {
    const auto size = std::uint64_t(file_->size());
    for (std::size_t n = first; n < entries_.size(); ++n) {
      stored_[n].at = at;
      if (stored_[n].bytes > size - at) {
        entries_[n].problem = "is cut short: it needs " + std::to_string(stored_[n].bytes) +
                              " bytes, the file has " + std::to_string(size - at) + " for it";
        ++lost_;
        at = size;
      } else {
        at += stored_[n].bytes;
      }
    }
    stream_.seekg(std::streamoff(at));
  }

  /// A grid's bytes, decompressed, behind the owner of their memory. Throws std::runtime_error if
  /// the file is damaged, Error(memory) if they need more memory than there is.
  std::pair<std::shared_ptr<const void>, std::span<const char>> unpacked(const GridEntry& entry) {
    const StoredGrid& grid = stored(entry);
    if (grid.codec > blosc) throw std::runtime_error("it is compressed by an unknown codec");
    if (grid.codec == none ? grid.memory != grid.bytes : grid.memory / greatest_ratio > grid.bytes)
      throw std::runtime_error("its size is impossible");
    const std::uint64_t available = available_memory();
    if (available > 0 && grid.memory > available)
      throw Error(ExitCode::memory, subject(path(), entry.name) + "needs " +
                                        mebibytes(grid.memory) + " of memory, there are " +
                                        mebibytes(available));
    struct alignas(32) Block {
      char bytes[32];
    };
    const auto blocks =
        std::make_shared_for_overwrite<Block[]>(std::size_t(grid.memory) / sizeof(Block) + 1);
    char* const bytes = reinterpret_cast<char*>(blocks.get());
    stream_.clear();
    stream_.seekg(std::streamoff(grid.at));
    buffer_.expect(std::int64_t(grid.bytes));
    unpack(grid, bytes);
    return {blocks, {bytes, std::size_t(grid.memory)}};
  }

  void unpack(const StoredGrid& grid, char* to) {
    if (grid.codec == none) {
      stream_.read(to, std::streamsize(grid.memory));
      return;
    }
    const auto end = std::int64_t(grid.at + grid.bytes);
    for (std::uint64_t rest = grid.memory; rest > 0;) {
      const std::uint64_t size = grid.codec == zip ? rest : std::min(rest, blosc_chunk);
      const auto length = take<std::int64_t>(stream_);
      if (length <= 0 || length > end - std::int64_t(stream_.tellg()))
        throw std::runtime_error("a compressed block has an impossible length");
      std::string block(std::size_t(length), '\0');
      stream_.read(block.data(), length);
      (grid.codec == zip ? expand_zip : expand_blosc)(block, to, std::size_t(size));
      to += size;
      rest -= size;
    }
  }

  std::vector<StoredGrid> stored_;  ///< of each entry
};

}  // namespace

bool is_nano(FileBlocks& file) {
  const FileRun first = file.run(0, 1);
  return std::string_view(first.bytes.get(), std::size_t(first.size)).starts_with(name_of_format);
}

std::unique_ptr<GridFile> open_nano_file(std::shared_ptr<FileBlocks> file, Progress progress) {
  return std::make_unique<NanoFile>(std::move(file), std::move(progress));
}

}  // namespace psivox::vdb
