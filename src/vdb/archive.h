#pragma once

#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <functional>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "file_blocks.h"
#include "file_buffer.h"
#include "file_metadata.h"

namespace psivox::vdb {

/// One grid as the file's directory lists it.
struct GridEntry {
  std::string name;                        ///< as --grid takes it
  openvdb::io::GridDescriptor descriptor;  ///< type, half, positions in the file
  openvdb::GridBase::Ptr streamed;         ///< already read, if the file has no positions
  std::string problem;                     ///< why it cannot be read; else empty
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

  /// The entry's grid, which the caller may change: of int32 if the file has points, the numbers of
  /// points in each voxel; 1 at active voxels if it has a mask. Throws Error(input).
  openvdb::GridBase::Ptr read(const GridEntry& entry) { return read(entry, /*values=*/true); }

  /// The same without values, which must not be used.
  openvdb::GridBase::Ptr read_topology(const GridEntry& entry) {
    return read(entry, /*values=*/false);
  }

  /// The entry's grid without its tree, at which the stream is now; null if the file has it in
  /// another place or format than `read_topology` (topology.h) takes. Throws Error(input).
  /// `delayed_load` gets the bytes of the metadata of that name, if the grid has them.
  openvdb::GridBase::Ptr begin_tree(const GridEntry& entry, std::string* delayed_load = nullptr);
  std::istream& stream() { return stream_; }
  FileBuffer& buffer() { return buffer_; }

  /// Does work that reads the entry. Throws Error(input) that names it, for any exception.
  void guarded(const GridEntry& entry, const std::function<void()>& work) const;

  const std::string& path() const { return file_.path(); }

 private:
  void read_directory();
  void read_entry(GridEntry& entry);
  void stream_grid(GridEntry& entry);
  void name_entries();
  openvdb::GridBase::Ptr read(const GridEntry& entry, bool values);
  openvdb::GridBase::Ptr read_tree(const GridEntry& entry, bool values);
  openvdb::GridBase::Ptr begin_grid(const GridEntry& entry);
  void read_head(openvdb::GridBase& grid, std::string* delayed_load = nullptr);
  void read_values(openvdb::GridBase& grid, const std::string& grid_type);
  void read_here(const openvdb::GridBase::Ptr& grid, const openvdb::io::GridDescriptor& descriptor,
                 bool values);

  FileBlocks& file_;
  openvdb::io::StreamMetadata::Ptr metadata_;  ///< the stream keeps a plain pointer to it
  MetadataText file_metadata_;
  FileBuffer buffer_;
  std::istream stream_{&buffer_};
  std::vector<GridEntry> entries_;
};

}  // namespace psivox::vdb
