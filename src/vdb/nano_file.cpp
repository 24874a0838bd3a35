#include "nano_file.h"

#include <openvdb/io/Compression.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "file_grid.h"
#include "grid_types.h"
#include "nano_tree.h"
#include "psivox/error.h"
#include "value_block.h"

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

/// What a grid's bytes begin with, as nanovdb::GridData.
struct GridHead {
  std::array<char, 8> magic;
  std::uint64_t checksum;
  std::uint32_t version, flags, index, count;
  std::uint64_t bytes;
  std::array<char, 256> name;
  std::array<char, 336> place;  ///< transform, box, size of a voxel
  std::uint32_t grid_class, type;
  std::array<char, 32> more;
};
static_assert(sizeof(GridHead) == 672);

constexpr std::string_view name_of_format = "NanoVDB", name_of_bare_grid = "NanoVDB1";
constexpr std::uint64_t blosc_chunk = 1 << 30;    // that Blosc compresses at a time [bytes]
constexpr std::uint64_t longest_name = 64 << 10;  // [bytes]
constexpr std::uint64_t greatest_ratio = 1100;    // zlib's is 1032, LZ4's 255

/// Before version 29 the halves of the number were major and minor.
std::string version_text(std::uint32_t version) {
  const bool old = version >> 21 == 0;
  return std::to_string(old ? version & 0xFFFF : version >> 21) + "." +
         std::to_string(old ? version >> 16 : version >> 10 & 0x7FF);
}

void check_version(const std::string& path, std::uint32_t version) {
  if (version >> 21 == nano_major_version()) return;
  throw Error(ExitCode::input, subject(path) + "was written by NanoVDB " + version_text(version) +
                                   ", psivox reads " + std::to_string(nano_major_version()) +
                                   ": convert the .vdb again");
}

/// A grid of a .nvdb. All of its bytes are in memory.
class NanoGrid final : public FileGrid {
 public:
  NanoGrid(NanoFile& file, const GridEntry& entry, bool marked)
      : FileGrid(file, entry, marked || is_mask(entry.descriptor.gridType())) {
    file.guarded(entry, [&] {
      const std::uint32_t type = file.stored(entry).type,
                          grid_class = file.stored(entry).grid_class;
      NanoBytes bytes;
      std::tie(memory_, bytes) = file.unpacked(entry);
      openvdb::GridBase::Ptr head = nano_head(bytes, type, grid_class);
      head->setName(entry.descriptor.gridName());
      if (const NanoType stored = nano_type(type, grid_class); stored.quantised)
        head->insertMeta("nanovdb_type", openvdb::StringMetadata(stored.name));
      tree_ = nano_tree(bytes, type, grid_class);
      begin(std::move(head), /*masks=*/false);
    });
  }

  std::string why_whole() const override { return "its file has it as one block"; }
  std::shared_ptr<StoredLeaves> stored_leaves(const LeafSurvey&, std::string, bool) override {
    return nullptr;
  }

 private:
  Topology read_topology(const TopologyWish& wish) override {
    return tree_->topology(*head_, wish);
  }

  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override {
    const std::size_t count = topology_.leaves.size();
    std::size_t end = enough ? 1 : count;
    for (std::size_t first = 0; first < count; first = end, end = 2 * first) {
      end = std::min(end, count);
      tbb::parallel_for(first, end, [&](std::size_t n) { tree_->decode(n, fill_, take); });
      if (enough && enough()) return;
    }
  }

  std::shared_ptr<const void> memory_;
  std::unique_ptr<NanoTree> tree_;
};

}  // namespace

bool is_nano(FileBlocks& file) {
  const FileRun first = file.run(0, 1);
  return std::string_view(first.bytes.get(), std::size_t(first.size)).starts_with(name_of_format);
}

NanoFile::NanoFile(std::shared_ptr<FileBlocks> file, Progress progress)
    : GridFile(std::move(file), std::move(progress)) {
  openvdb::initialize();
  try {
    do {
      read_segment();
    } while (stream_.tellg() < file_->size());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject(path()) + "is a damaged NanoVDB file: " + explain(e));
  }
  name_entries();
}

void NanoFile::read_segment() {
  const auto header = take<SegmentHeader>(stream_);
  const std::string_view magic(header.magic.data(), header.magic.size());
  if (magic == name_of_bare_grid) return read_bare_grid();
  if (!magic.starts_with(name_of_format))
    throw openvdb::IoError("something else follows its grids");
  check_version(path(), header.version);
  if (header.grids == 0) throw openvdb::IoError("it has no grid");
  const std::size_t first = entries_.size();
  for (std::uint16_t n = 0; n < header.grids; ++n) read_entry(header.codec);
  place_entries(first, std::uint64_t(stream_.tellg()));
}

/// A grid without a segment's header and entry, as NanoVDB has it in memory.
void NanoFile::read_bare_grid() {
  const std::uint64_t at = std::uint64_t(stream_.tellg()) - sizeof(SegmentHeader);
  stream_.seekg(std::streamoff(at));
  const auto head = take<GridHead>(stream_);
  check_version(path(), head.version);
  if (head.bytes < sizeof head) throw openvdb::IoError("a grid has an impossible size");
  add_entry({head.name.data(), head.name.size()},
            {head.bytes, head.bytes, 0, head.type, head.grid_class, none});
  place_entries(entries_.size() - 1, at);
}

void NanoFile::read_entry(std::uint16_t codec) {
  const auto entry = take<NanoEntry>(stream_);
  if (entry.name_length > longest_name) throw openvdb::IoError("a name has an impossible length");
  std::string name(entry.name_length, '\0');
  stream_.read(name.data(), std::streamsize(name.size()));
  add_entry(std::move(name), {entry.memory, entry.bytes, 0, entry.type, entry.grid_class, codec});
}

void NanoFile::add_entry(std::string name, const Stored& grid) {
  name.resize(std::min(name.find('\0'), name.size()));
  const NanoType type = nano_type(grid.type, grid.grid_class);
  GridEntry listed;
  listed.descriptor = {name, type.grid_type.empty() ? type.name : type.grid_type};
  if (type.grid_type.empty()) listed.problem = unsupported_type(type.name);
  entries_.push_back(std::move(listed));
  stored_.push_back(grid);
}

/// The grids of a segment follow each other. Moves the stream behind them. A grid that the file's
/// end cuts short gets a problem.
void NanoFile::place_entries(std::size_t first, std::uint64_t at) {
  const auto size = std::uint64_t(file_->size());
  for (std::size_t n = first; n < entries_.size(); ++n) {
    stored_[n].at = at;
    if (stored_[n].bytes > size - at) {
      entries_[n].problem = "is cut short: it needs " + std::to_string(stored_[n].bytes) +
                            " bytes, the file has " + std::to_string(size - at) + " for it";
      at = size;
    } else {
      at += stored_[n].bytes;
    }
  }
  stream_.seekg(std::streamoff(at));
}

const NanoFile::Stored& NanoFile::stored(const GridEntry& entry) const {
  return stored_[std::size_t(&entry - entries_.data())];
}

MetadataText NanoFile::metadata_of(const GridEntry& entry) {
  return {{"class", openvdb::GridBase::gridClassToString(nano_class(stored(entry).grid_class))}};
}

std::unique_ptr<FileGrid> NanoFile::open(const GridEntry& entry, bool marked) {
  return std::make_unique<NanoGrid>(*this, entry, marked);
}

std::pair<std::shared_ptr<const void>, NanoBytes> NanoFile::unpacked(const GridEntry& entry) {
  const Stored& grid = stored(entry);
  if (grid.codec > blosc) throw openvdb::IoError("it is compressed by an unknown codec");
  if (grid.codec == none ? grid.memory != grid.bytes : grid.memory / greatest_ratio > grid.bytes)
    throw openvdb::IoError("its size is impossible");
  const std::uint64_t available = available_memory();
  if (available > 0 && grid.memory > available)
    throw Error(ExitCode::memory, subject(path(), entry.name) + "needs " + mebibytes(grid.memory) +
                                      " of memory, there are " + mebibytes(available));
  struct alignas(32) Block {
    char bytes[32];
  };
  const auto blocks = std::make_shared_for_overwrite<Block[]>(
      std::size_t(grid.memory + blosc_overhead) / sizeof(Block) + 1);
  char* const bytes = reinterpret_cast<char*>(blocks.get());
  stream_.clear();
  stream_.seekg(std::streamoff(grid.at));
  buffer_.expect(std::int64_t(grid.bytes));
  unpack(grid, bytes);
  return {blocks, NanoBytes(bytes, std::size_t(grid.memory))};
}

void NanoFile::unpack(const Stored& grid, char* to) {
  if (grid.codec == none) {
    stream_.read(to, std::streamsize(grid.memory));
    return;
  }
  const auto end = std::int64_t(grid.at + grid.bytes);
  for (std::uint64_t rest = grid.memory; rest > 0;) {
    const std::uint64_t size = grid.codec == zip ? rest : std::min(rest, blosc_chunk);
    const auto length = take<std::int64_t>(stream_);
    if (length <= 0 || length > end - std::int64_t(stream_.tellg()))
      throw openvdb::IoError("a compressed block has an impossible length");
    if (grid.codec == zip) {
      stream_.seekg(-std::streamoff(sizeof length), std::ios_base::cur);
      openvdb::io::unzipFromStream(stream_, to, std::size_t(size));
    } else {
      std::string block(std::size_t(length), '\0');
      stream_.read(block.data(), length);
      expand_blosc(block, to, std::size_t(size));
    }
    to += size;
    rest -= size;
  }
}

}  // namespace psivox::vdb
