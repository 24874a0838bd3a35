#pragma once

#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <functional>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "file_metadata.h"

namespace psivox::vdb {

/// One grid as the file's directory lists it.
struct GridEntry {
  std::string name;                        ///< as --grid takes it
  openvdb::io::GridDescriptor descriptor;  ///< type, half, positions in the file
  std::string problem;                     ///< why it cannot be read; else empty
};

/// A grid without its tree, and where that ends.
struct TreeHead {
  openvdb::GridBase::Ptr grid;
  std::string delayed_load{};  ///< bytes of the metadata for delayed loading, if it has them
  std::int64_t end = 0;        ///< [bytes]
};

/// A .vdb open for reading, its directory read.
///
/// It replaces openvdb::io::File for two reasons. That class refuses a whole file if one grid has
/// an unregistered type, and it does not notice a read beyond the end of the file, so a truncated
/// grid has uninitialised values. Here the stream throws, and positions are first checked against
/// the file's size. Nothing is loaded later, so a file that shrinks meanwhile cannot crash the
/// program.
class Archive final : private openvdb::io::Archive {
 public:
  /// Throws Error(input) if the file is no .vdb, or ends within its first directory entry.
  /// `progress` receives the fraction of a grid that has been read. The file must live as long.
  explicit Archive(FileBlocks& file, Progress progress = {});

  /// The entries in file order.
  const std::vector<GridEntry>& entries() const { return entries_; }

  /// The entry of a selectable name; a repeated name without its number means the first.
  /// Throws Error(input) that lists the names if there is none.
  const GridEntry& find(std::string_view name) const;

  /// The file's own metadata.
  const MetadataText& metadata() const { return file_metadata_; }

  /// The entry's metadata, without its tree; empty if it cannot be read.
  MetadataText metadata_of(const GridEntry& entry);

  /// The entry's grid without its tree, at which the stream is now. A tree that grids share is in
  /// the file once. Throws if the file is damaged.
  TreeHead begin_tree(const GridEntry& entry);
  std::istream& stream() { return stream_; }
  FileBuffer& buffer() { return buffer_; }

  /// Whether the file's format is too old for `begin_tree`.
  bool is_old() const {
    return fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION;
  }
  /// A file in memory, in today's format, that has the entry's grid alone.
  std::shared_ptr<FileBlocks> rewritten(const GridEntry& entry);

  /// Does work that reads the entry. Throws Error(input) that names it, for any exception.
  void guarded(const GridEntry& entry, const std::function<void()>& work) const;

  const std::string& path() const { return file_.path(); }

 private:
  void read_directory();
  void read_entry(GridEntry& entry);
  void skip_grid(GridEntry& entry);
  void name_entries();
  const GridEntry& parent_of(const GridEntry& entry) const;
  TreeHead begin_grid(const GridEntry& entry);
  openvdb::GridBase::Ptr read_old(const GridEntry& entry);

  FileBlocks& file_;
  openvdb::io::StreamMetadata::Ptr metadata_;  ///< the stream keeps a plain pointer to it
  MetadataText file_metadata_;
  FileBuffer buffer_;
  std::istream stream_{&buffer_};
  std::vector<GridEntry> entries_;
};

}  // namespace psivox::vdb
