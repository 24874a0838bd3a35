#include "archive.h"

#include <openvdb/io/Stream.h>

#include <array>
#include <memory>
#include <sstream>
#include <utility>

#include "grid_types.h"
#include "value_block.h"

namespace psivox::vdb {
namespace {

using openvdb::io::GridDescriptor;

/// Throws for a file of another format.
void refuse_foreign(FileBlocks& file) {
  constexpr std::string_view magic = " BDV";  // OpenVDB's number 0x56444220, least byte first
  const FileRun first = file.run(0, 1);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  if (head.starts_with(magic)) return;
  if (const std::string format = foreign_format(file.path(), head); !format.empty())
    throw Error(ExitCode::input, file.path() + ": " + format);
}

/// Throws if the root of a grid's tree has nodes or tiles at places where none can be. OpenVDB
/// would compute ends beyond the integers from them.
void check_root(const openvdb::GridBase& grid) {
  with_typed_grid(grid, [](const auto& typed) {
    const auto& root = typed.tree().root();
    constexpr int width = std::decay_t<decltype(root)>::ChildNodeType::DIM;
    for (auto it = root.cbeginChildAll(); it; ++it)
      if ((it.getCoord() & ~(width - 1)) != it.getCoord())
        throw openvdb::IoError("a node of its root is at an impossible place");
  });
}

}  // namespace

Archive::Archive(std::shared_ptr<FileBlocks> file, Progress progress)
    : GridFile(std::move(file), std::move(progress)) {
  refuse_foreign(*file_);
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
    const bool cut_short = inputHasGridOffsets() && entry.descriptor.getEndPos() > file_->size();
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
    const auto positions = take<std::array<std::int64_t, 3>>(stream_);
    descriptor.setGridPos(positions[0]);
    descriptor.setBlockPos(positions[1]);
    descriptor.setEndPos(positions[2]);
  }
  if (channels_of(descriptor.gridType()) == 0) {
    entry.problem = unsupported_type(descriptor.gridType());
  }
  if (!inputHasGridOffsets()) {
    skip_grid(entry);
    return;
  }
  // Positions only grow, so the loop over the directory ends for any file.
  const std::int64_t here = stream_.tellg();
  if (descriptor.getGridPos() < here || descriptor.getEndPos() < descriptor.getGridPos()) {
    throw openvdb::IoError("its position in the file is impossible");
  }
  if (descriptor.getEndPos() > file_->size()) {
    entry.problem = "is cut short: it needs " + std::to_string(descriptor.getEndPos()) +
                    " bytes, the file has " + std::to_string(file_->size());
  }
}

/// Finds the positions of a grid in a file that has none (one that was written to a pipe). The
/// stream is at the grid and goes behind it.
void Archive::skip_grid(GridEntry& entry) {
  constexpr std::int64_t mask_leaf = 64 + 3 * 4;  // the mask once more, and the origin [bytes]
  GridDescriptor& descriptor = entry.descriptor;
  const std::string& type = descriptor.gridType();
  descriptor.setGridPos(stream_.tellg());
  descriptor.setEndPos(file_->size());
  if (is_old() || channels_of(type) == 0) {
    read_old(entry);
  } else if (TreeHead head = begin_grid(entry); !descriptor.isInstance()) {
    const std::size_t leaves = read_topology(*head.grid, stream_).leaves.size();
    if (is_points(type)) {
      stream_.seekg(read_point_counts(leaves, stream_, [](std::size_t, const PointCounts&) {}),
                    std::ios_base::cur);
    } else if (is_mask(type)) {
      stream_.seekg(mask_leaf * std::int64_t(leaves), std::ios_base::cur);
    } else {
      const LeafDecoder decoder(nullptr, head.grid, stream_);
      for (std::size_t n = 0; n < leaves; ++n) decoder.skip(stream_);
    }
  }
  descriptor.setEndPos(stream_.tellg());
}

/// The grid that has an instance's tree.
const GridEntry& Archive::parent_of(const GridEntry& entry) const {
  for (const GridEntry& parent : entries_)
    if (parent.descriptor.uniqueName() == entry.descriptor.instanceParentName()) return parent;
  throw openvdb::KeyError("the grid that has its tree is missing");
}

TreeHead Archive::begin_tree(const GridEntry& entry) {
  TreeHead own = begin_grid(entry);
  if (!entry.descriptor.isInstance()) return own;
  TreeHead tree = begin_grid(parent_of(entry));
  if (tree.grid->type() != own.grid->type())
    throw openvdb::TypeError("the grid that has its tree is of another type");
  tree.grid->clearMetadata();
  tree.grid->insertMeta(*own.grid);
  tree.grid->setTransform(own.grid->transformPtr());
  return tree;
}

/// Reads what stands before a grid's tree.
TreeHead Archive::begin_grid(const GridEntry& entry) {
  const GridDescriptor& descriptor = entry.descriptor;
  stream_.clear();
  TreeHead head{openvdb::GridBase::createGrid(stored_like(descriptor.gridType())),
                {},
                descriptor.getEndPos()};
  openvdb::GridBase& grid = *head.grid;
  grid.setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
  descriptor.seekToGrid(stream_);
  buffer_.expect(descriptor.getEndPos() - descriptor.getGridPos());
  readGridCompression(stream_);
  constexpr std::uint32_t known =
      openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC;
  if (openvdb::io::getDataCompression(stream_) & ~known)
    throw openvdb::IoError("it is compressed by an unknown codec");
  openvdb::io::setHalfFloat(stream_, grid.saveFloatAsHalf());
  openvdb::io::setGridBackgroundValuePtr(stream_, nullptr);
  read_metadata(grid, stream_, &head.delayed_load);
  openvdb::io::setGridClass(stream_, grid.getGridClass());
  check_strings(stream_, 1);  // the type
  grid.readTransform(stream_);
  if (is_points(descriptor.gridType()) &&
      fileVersion() < openvdb::OPENVDB_FILE_VERSION_MULTIPASS_IO)
    throw openvdb::IoError("points in a file of so old a format are not supported");
  return head;
}

/// Reads a grid by OpenVDB itself: what a file of an old format has, or what is passed over.
openvdb::GridBase::Ptr Archive::read_old(const GridEntry& entry) {
  const GridDescriptor& descriptor = entry.descriptor;
  const std::string& type = descriptor.gridType();
  if (stored_like(type) != type)
    throw openvdb::IoError("a grid of its type in so old a format is not supported");
  const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(type);
  grid->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
  stream_.clear();
  descriptor.seekToGrid(stream_);
  buffer_.expect(descriptor.getEndPos() - descriptor.getGridPos());
  readGrid(grid, descriptor, stream_);
  check_root(*grid);
  return grid;
}

std::shared_ptr<FileBlocks> Archive::rewritten(const GridEntry& entry) {
  const openvdb::GridBase::Ptr grid = read_old(entry);
  if (entry.descriptor.isInstance()) grid->setTree(read_old(parent_of(entry))->baseTreePtr());
  std::ostringstream out;
  openvdb::io::Stream stream(out);
  stream.setCompression(openvdb::io::COMPRESS_NONE);
  stream.write(openvdb::GridCPtrVec{grid});
  return std::make_shared<FileBlocks>(path(), std::move(out).str());
}

std::unique_ptr<FileGrid> Archive::open(const GridEntry& entry, bool marked) {
  return open_archive_grid(*this, entry, file_, marked);
}

MetadataText Archive::metadata_of(const GridEntry& entry) {
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
