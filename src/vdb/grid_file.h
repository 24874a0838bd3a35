#pragma once

#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <functional>
#include <istream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "reader.h"

namespace psivox::vdb {

class FileGrid;

/// Metadata as text, by name.
using MetadataText = std::map<std::string, std::string>;
MetadataText text_of(const openvdb::MetaMap& metadata);

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

  /// Throws Error(input) if there is none.
  const GridEntry& find(const std::string& name) const { return named(entries_, name, path()); }

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

/// Whether a file's first bytes are those of a .nvdb.
bool is_nano(FileBlocks& file);
/// Opens a .nvdb. Throws Error(input) if it is damaged before its first grid, or of another major
/// version than psivox reads.
std::unique_ptr<GridFile> open_nano_file(std::shared_ptr<FileBlocks> file, Progress progress = {});

/// Reads metadata, each from its own bytes. OpenVDB would allocate what lengths in the file claim
/// and go on where a value ends by its type; here the stream throws if a length is beyond its end.
/// Metadata for delayed loading are left out; `delayed_load` gets their bytes.
void read_metadata(openvdb::MetaMap& metadata, std::istream& stream,
                   std::string* delayed_load = nullptr);

/// Moves the stream behind a string, which is a length and that many bytes.
void skip_string(std::istream& stream);

/// Throws if strings that OpenVDB is to read next are longer than the rest of the file. The stream
/// stays.
void check_strings(std::istream& stream, int count);

/// What VdbFile::z_up returns: evidence of a program whose Z axis is up. `grids` has the metadata
/// of each grid, `names` the grids' names.
std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids);

}  // namespace psivox::vdb
