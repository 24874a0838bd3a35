#pragma once

#include <openvdb/io/GridDescriptor.h>

#include <functional>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "file_metadata.h"

namespace psivox::vdb {

class FileGrid;

/// One grid as the file's directory lists it.
struct GridEntry {
  std::string name;                        ///< as --grid takes it
  openvdb::io::GridDescriptor descriptor;  ///< type, half, positions in the file
  std::string problem;                     ///< why it cannot be read; else empty
};

/// A message for the user, in one line, about an exception from a library or the stream.
std::string explain(const std::exception& e);

/// A file of grids, open for reading, its directory read: an Archive or a NanoFile. It has one
/// stream, so that only one grid is read at a time.
class GridFile {
 public:
  virtual ~GridFile() = default;
  GridFile(const GridFile&) = delete;
  GridFile& operator=(const GridFile&) = delete;

  /// The entries in file order.
  const std::vector<GridEntry>& entries() const { return entries_; }

  /// The entry of a selectable name; a repeated name without its number means the first.
  /// Throws Error(input) that lists the names if there is none.
  const GridEntry& find(std::string_view name) const;

  /// The file's own metadata.
  const MetadataText& metadata() const { return file_metadata_; }

  /// The entry's metadata, without its tree; empty if it cannot be read.
  virtual MetadataText metadata_of(const GridEntry& entry) = 0;

  /// Reads head and topology of a grid, which must not outlive this. `marked`: the grid is a scalar
  /// that is 1 at active voxels, in place of its values. A mask always is. Throws Error(input).
  virtual std::unique_ptr<FileGrid> open(const GridEntry& entry, bool marked = false) = 0;

  /// Does work that reads the entry. Throws Error(input) that names it, for any exception.
  void guarded(const GridEntry& entry, const std::function<void()>& work) const;

  const std::string& path() const { return file_->path(); }
  FileBlocks& file() const { return *file_; }

 protected:
  /// `progress` receives the fraction of a grid that has been read.
  explicit GridFile(std::shared_ptr<FileBlocks> file, Progress progress);

  /// Gives entries their names when all are listed.
  void name_entries();

  std::shared_ptr<FileBlocks> file_;
  MetadataText file_metadata_;
  FileBuffer buffer_;
  std::istream stream_{&buffer_};  ///< throws where the file ends
  std::vector<GridEntry> entries_;
};

}  // namespace psivox::vdb
