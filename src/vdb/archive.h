#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "grid_file.h"
#include "topology.h"
#include "values.h"

namespace psivox::vdb {

/// What stands before a grid's tree.
struct TreeHead {
  GridHead head;
  ValueCoding coding;
  std::string delayed_load{};  ///< bytes of the metadata for delayed loading, if it has them
  std::int64_t end = 0;        ///< of the grid [bytes]
};

/// A .vdb open for reading, its directory read.
///
/// It reads what openvdb::io::File would, for three reasons. To load OpenVDB takes longer than to
/// read a small file. That class refuses a whole file if one grid has an unregistered type, and it
/// does not notice a read beyond the end of the file, so a truncated grid has uninitialised values.
/// Here the stream throws, and positions are first checked against the file's size. Nothing is
/// loaded later, so a file that shrinks meanwhile cannot crash the program.
class Archive final : public GridFile {
 public:
  /// Throws Error(input) if the file is no .vdb, or ends within its first directory entry.
  explicit Archive(std::shared_ptr<FileBlocks> file, Progress progress = {});

  EntryHead entry_head(const GridEntry& entry) override;
  std::unique_ptr<FileGrid> open(const GridEntry& entry, bool marked) override;

  /// Reads what stands before the entry's tree, at which the stream is then. A tree that grids
  /// share is in the file once. Throws if the file is damaged.
  TreeHead begin_tree(const GridEntry& entry);
  std::istream& stream() { return stream_; }
  FileBuffer& buffer() { return buffer_; }

  /// Whether the file's format is too old for `begin_tree`.
  bool is_old() const;
  /// A file in memory, in today's format, that has the entry's grid alone. OpenVDB makes it.
  std::shared_ptr<FileBlocks> rewritten(const GridEntry& entry) const;

 private:
  void read_header();
  void read_directory();
  void read_entry(GridEntry& entry);
  void skip_grid(GridEntry& entry);
  const GridEntry& parent_of(const GridEntry& entry) const;
  TreeHead begin_grid(const GridEntry& entry);

  std::uint32_t version_ = 0;  ///< of the format
  bool has_places_ = false;    ///< of grids, in its directory
};

/// Reads head and topology of the entry's grid, whatever its type and format.
std::unique_ptr<FileGrid> open_archive_grid(Archive& archive, const GridEntry& entry,
                                            std::shared_ptr<FileBlocks> file, bool marked);

using TakeCounts = std::function<void(std::size_t leaf, const PointCounts& counts)>;

/// Reads the numbers of points in a grid's voxels, leaf by leaf. The stream is behind the topology
/// of a grid of points (OpenVDB's PointDataGrid, file format 224 or later). Attributes of points
/// are passed over, so that their types and codecs do not matter. Leaves the stream before the
/// attributes' values, and returns how many bytes those take. Throws if the file is damaged.
std::int64_t read_point_counts(std::size_t leaves, std::istream& stream, const TakeCounts& take);

/// Where a leaf's values are in the file [bytes].
struct LeafPlace {
  std::int64_t begin, end;
};

/// Decodes a grid's leaves, each from its place in the file, without the grid's tree.
class LeafDecoder {
 public:
  /// The file's format must be 222 or later. Inactive voxels that have the background's value
  /// become `fill`, if it is set.
  LeafDecoder(std::shared_ptr<FileBlocks> file, const GridHead& head, const ValueCoding& coding,
              std::optional<double> fill = {})
      : file_(std::move(file)), head_(head), coding_(coding), fill_(fill) {}

  /// Moves the stream from the beginning of a leaf's values behind their end. Throws if a length is
  /// impossible.
  void skip(std::istream& stream) const;
  /// Skips a leaf that has so many active voxels without reading its mask.
  void skip(std::istream& stream, std::size_t active) const;

  /// How many bytes each leaf's values take in the file, as the grid's metadata for delayed loading
  /// say: their kinds, and their compressed lengths. Empty if those metadata do not have all of it,
  /// or cannot be right. `decode` checks them, for the file can claim anything.
  std::vector<std::int64_t> lengths(std::string_view metadata, const Topology& topology) const;

  /// Decodes the leaves at these places, in all threads. Reads large runs, which the file keeps, or
  /// nothing but the leaves. Throws if a leaf is longer or shorter than its place.
  void decode(std::span<const LeafPlace> places, bool in_runs, const TakeLeaf& take) const;

 private:
  template <typename ValueT>
  void decode_some(std::span<const LeafPlace> places, std::size_t first, bool in_runs,
                   const TakeLeaf& take) const;

  std::shared_ptr<FileBlocks> file_;
  GridHead head_;
  ValueCoding coding_;
  std::optional<double> fill_;
};

}  // namespace psivox::vdb
