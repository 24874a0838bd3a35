#include "archive.h"

#include <algorithm>
#include <map>
#include <new>
#include <utility>

#include "check_topology.h"
#include "conform.h"
#include "grid_types.h"
#include "point_counts.h"
#include "psivox/error.h"
#include "psivox/foreign_format.h"
#include "psivox/text.h"
#include "read_leaves.h"
#include "subject.h"

namespace psivox::vdb {
namespace {

using openvdb::io::GridDescriptor;

/// A message for the user, in one line, about an exception from OpenVDB or the stream.
std::string explain(const std::exception& e) {
  if (dynamic_cast<const std::ios_base::failure*>(&e)) return "the file ends too early";
  if (dynamic_cast<const std::bad_alloc*>(&e)) return "it asks for more memory than there is";
  std::string text = e.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return printable(text);
}

/// Throws for a file of another format.
void refuse_foreign(FileBlocks& file) {
  constexpr std::string_view magic = " BDV";  // OpenVDB's number 0x56444220, least byte first
  const FileRun first = file.run(0, 1);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  if (head.starts_with(magic)) return;
  if (const std::string format = foreign_format(file.path(), head); !format.empty())
    throw Error(ExitCode::input, file.path() + ": " + format);
}

}  // namespace

Archive::Archive(FileBlocks& file, Progress progress)
    : file_(file), buffer_(file, std::move(progress)) {
  openvdb::initialize();
  refuse_foreign(file);
  stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  try {
    readHeader(stream_);
    // OpenVDB's readers ask the stream for the format and library versions and the compression.
    metadata_.reset(new openvdb::io::StreamMetadata);
    metadata_->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    openvdb::MetaMap metadata;
    read_metadata(metadata, stream_);
    file_metadata_ = text_of(metadata);
    read_directory();
  } catch (const std::exception& e) {
    throw Error(ExitCode::input,
                subject(path()) + "is not a VDB file or is damaged: " + explain(e));
  }
  name_entries();
}

void Archive::read_directory() {
  const std::int32_t count = readGridCount(stream_);
  for (std::int32_t i = 0; i < count; ++i) {
    GridEntry entry;
    try {
      read_entry(entry);
    } catch (const std::exception& e) {
      // Grids listed before can still be read; without a type this one cannot be listed.
      if (entries_.empty() && entry.descriptor.gridType().empty()) throw;
      if (entry.descriptor.gridType().empty()) return;
      entry.problem = "cannot be read: " + explain(e);
      entries_.push_back(std::move(entry));
      return;
    }
    const bool cut_short = inputHasGridOffsets() && entry.descriptor.getEndPos() > file_.size();
    if (cut_short && i + 1 < count) {
      entry.problem += "; " + std::to_string(count - i - 1) + " more behind it cannot be found";
    }
    if (inputHasGridOffsets() && !cut_short) entry.descriptor.seekToEnd(stream_);
    entries_.push_back(std::move(entry));
    if (cut_short) return;
  }
}

void Archive::read_entry(GridEntry& entry) {
  GridDescriptor& descriptor = entry.descriptor;
  const bool has_parent = fileVersion() >= openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING;
  check_strings(stream_, has_parent ? 3 : 2);  // name, type, name of the grid that has the tree
  try {
    descriptor.read(stream_);
  } catch (const openvdb::LookupError&) {
    // The type is not registered. OpenVDB stops behind its name, where the three positions begin.
    std::int64_t positions[3];
    stream_.read(reinterpret_cast<char*>(positions), sizeof positions);
    descriptor.setGridPos(positions[0]);
    descriptor.setBlockPos(positions[1]);
    descriptor.setEndPos(positions[2]);
  }
  if (channels_of(descriptor.gridType()) == 0) {
    entry.problem = unsupported_type(descriptor.gridType());
  }
  if (!inputHasGridOffsets()) {
    stream_grid(entry);
    return;
  }
  // Positions only grow, so the loop over the directory ends for any file.
  const std::int64_t here = stream_.tellg();
  if (descriptor.getGridPos() < here || descriptor.getEndPos() < descriptor.getGridPos()) {
    throw openvdb::IoError("its position in the file is impossible");
  }
  if (descriptor.getEndPos() > file_.size()) {
    entry.problem = "is cut short: it needs " + std::to_string(descriptor.getEndPos()) +
                    " bytes, the file has " + std::to_string(file_.size());
  }
}

/// A file without positions (written to a pipe) can only be read from its beginning to its end.
void Archive::stream_grid(GridEntry& entry) {
  entry.streamed = openvdb::GridBase::createGrid(stored_like(entry.descriptor.gridType()));
  entry.streamed->setSaveFloatAsHalf(entry.descriptor.saveFloatAsHalf());
  buffer_.expect(file_.size());
  read_here(entry.streamed, entry.descriptor, /*values=*/true);
}

/// OpenVDB's names, `density` or `density[1]`, with control characters escaped. It writes grids
/// without a name as `[0]`, `[1]`; where another program repeats a name without numbers, they are
/// numbered here.
void Archive::name_entries() {
  std::map<std::string, int> uses;
  for (GridEntry& entry : entries_) {
    entry.name = printable(GridDescriptor::nameAsString(entry.descriptor.uniqueName()));
    ++uses[entry.name];
  }
  std::map<std::string, int> next;
  for (GridEntry& entry : entries_) {
    const std::string name = entry.name;
    if (name.empty() || uses[name] > 1) entry.name += "[" + std::to_string(next[name]++) + "]";
  }
}

const GridEntry& Archive::find(std::string_view name) const {
  for (const GridEntry& entry : entries_) {
    if (entry.name == name) return entry;
  }
  for (const GridEntry& entry : entries_) {
    if (entry.descriptor.gridName() == name) return entry;
  }
  std::vector<std::string> names;
  for (const GridEntry& entry : entries_) names.push_back(entry.name);
  std::string message = subject(path()) + "has no grid " + in_quotes(name) + "; it has";
  for (const std::string& known : nearest_first(name, names)) message += " " + in_quotes(known);
  if (names.empty()) message += " none";
  throw Error(ExitCode::input, message);
}

void Archive::guarded(const GridEntry& entry, const std::function<void()>& work) const {
  if (!entry.problem.empty())
    throw Error(ExitCode::input, subject(path(), entry.name) + entry.problem);
  try {
    work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject(path(), entry.name) + "cannot be read: " + explain(e));
  }
}

openvdb::GridBase::Ptr Archive::read(const GridEntry& entry, bool values) {
  openvdb::GridBase::Ptr grid;
  guarded(entry, [&] {
    grid = read_tree(entry, values);
    if (!entry.descriptor.isInstance()) return;
    // Two grids share a tree; the file has it once, under the other grid's name.
    for (const GridEntry& parent : entries_) {
      if (parent.descriptor.uniqueName() != entry.descriptor.instanceParentName()) continue;
      grid->setTree(read_tree(parent, values)->baseTreePtr());
      return;
    }
    throw openvdb::KeyError("the grid that has its tree is missing");
  });
  return values && is_mask(entry.descriptor.gridType()) ? activity_of(grid) : grid;
}

/// A new grid, for which the stream is at the entry's place.
openvdb::GridBase::Ptr Archive::begin_grid(const GridEntry& entry) {
  stream_.clear();
  openvdb::GridBase::Ptr grid =
      openvdb::GridBase::createGrid(stored_like(entry.descriptor.gridType()));
  grid->setSaveFloatAsHalf(entry.descriptor.saveFloatAsHalf());
  entry.descriptor.seekToGrid(stream_);
  buffer_.expect(entry.descriptor.getEndPos() - entry.descriptor.getGridPos());
  return grid;
}

openvdb::GridBase::Ptr Archive::read_tree(const GridEntry& entry, bool values) {
  if (entry.streamed) return entry.streamed->deepCopyGrid();
  openvdb::GridBase::Ptr grid = begin_grid(entry);
  read_here(grid, entry.descriptor, values);
  return grid;
}

openvdb::GridBase::Ptr Archive::begin_tree(const GridEntry& entry, std::string* delayed_load) {
  openvdb::GridBase::Ptr grid;
  guarded(entry, [&] {
    if (entry.streamed || entry.descriptor.isInstance() ||
        channels_of(entry.descriptor.gridType()) == 0 ||
        fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION)
      return;
    grid = begin_grid(entry);
    read_head(*grid, delayed_load);
  });
  return grid;
}

/// What stands before a grid's tree.
void Archive::read_head(openvdb::GridBase& grid, std::string* delayed_load) {
  readGridCompression(stream_);
  constexpr std::uint32_t known =
      openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC;
  if (openvdb::io::getDataCompression(stream_) & ~known)
    throw openvdb::IoError("it is compressed by an unknown codec");
  openvdb::io::setHalfFloat(stream_, grid.saveFloatAsHalf());
  openvdb::io::setGridBackgroundValuePtr(stream_, nullptr);
  read_metadata(grid, stream_, delayed_load);
  // It has the places of leaves, for OpenVDB's own skipping. They can be wrong.
  grid.removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD);
  openvdb::io::setGridClass(stream_, grid.getGridClass());
  check_strings(stream_, 1);  // the type
  grid.readTransform(stream_);
}

/// The values of leaves behind a grid's topology; the stream goes behind them.
void Archive::read_values(openvdb::GridBase& grid, const std::string& grid_type) {
  constexpr std::int64_t mask_leaf = 64 + 3 * 4;  // of a mask once more, and the origin [bytes]
  if (is_points(grid_type)) {
    if (fileVersion() < openvdb::OPENVDB_FILE_VERSION_MULTIPASS_IO)
      throw openvdb::IoError("points in a file of so old a format are not supported");
    const std::int64_t attributes =
        read_point_counts(static_cast<openvdb::Int32Grid&>(grid), stream_);
    // a grid that has a position may begin wherever this one ends
    if (!inputHasGridOffsets()) stream_.seekg(attributes, std::ios_base::cur);
  } else if (is_mask(grid_type)) {
    stream_.seekg(mask_leaf * std::int64_t(grid.constBaseTree().leafCount()), std::ios_base::cur);
  } else {
    read_leaves(grid, stream_, buffer_);
  }
}

/// OpenVDB's readGrid for the grid at the stream's position, with leaves read by all threads.
void Archive::read_here(const openvdb::GridBase::Ptr& grid, const GridDescriptor& descriptor,
                        bool values) {
  const std::string& grid_type = descriptor.gridType();
  if (channels_of(grid_type) == 0 ||
      fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION) {
    if (stored_like(grid_type) != grid_type)
      throw openvdb::IoError("a grid of its type in so old a format is not supported");
    readGrid(grid, descriptor, stream_);
    check_root(*grid);
    return;
  }
  read_head(*grid);
  if (descriptor.isInstance()) return;
  check_topology(*grid, stream_);
  grid->readTopology(stream_);
  check_root(*grid);
  if (values) read_values(*grid, grid_type);
}

MetadataText Archive::metadata_of(const GridEntry& entry) {
  if (entry.streamed) return text_of(*entry.streamed);
  if (!entry.problem.empty()) return {};
  try {
    stream_.clear();
    entry.descriptor.seekToGrid(stream_);
    readGridCompression(stream_);
    openvdb::MetaMap metadata;
    read_metadata(metadata, stream_);
    return text_of(metadata);
  } catch (const std::exception&) {  // reading the grid says what is wrong with it
    return {};
  }
}

}  // namespace psivox::vdb
