#pragma once

#include <functional>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grid_head.h"
#include "reader.h"
#include "survey.h"
#include "topology.h"

namespace psivox::vdb {

class FileGrid;

/// One grid as the file's directory lists it.
struct GridEntry {
  std::string name{};               ///< as --grid takes it
  std::string base_name{};          ///< as the file has it: names may repeat
  std::string unique_name{};        ///< with what makes it differ from others: see name_entries
  std::string parent{};             ///< unique_name of the grid that has the tree, if it is another
  std::string type{};               ///< OpenVDB's: Tree_float_5_4_3
  bool half = false;                ///< real numbers are stored in 16 bits
  std::int64_t begin = 0, end = 0;  ///< in the file [bytes]
  std::string problem{};            ///< why it cannot be read; else empty
};

struct EntryHead {
  MetadataText metadata{};
  GridPlace place{};
};

/// A message for the user, in one line, about an exception from a library or the stream.
std::string explain(const std::exception& e);

/// A file of grids, open for reading, its directory read: the module `reader` makes it of a .vdb or
/// a .nvdb. It has one stream, so that only one grid is read at a time.
class GridFile {
 public:
  virtual ~GridFile() = default;

  /// The entries in file order.
  const std::vector<GridEntry>& entries() const { return entries_; }

  /// Number of grids that are cut off or damaged; entries may list them.
  int lost() const { return lost_; }

  /// Throws Error(input) if there is none.
  const GridEntry& find(const std::string& name) const { return named(entries_, name, path()); }

  const MetadataText& metadata() const { return file_metadata_; }

  /// What stands before the entry's tree; nothing of what cannot be read.
  virtual EntryHead entry_head(const GridEntry& entry) = 0;

  /// Reads head and topology of a grid, which must not outlive this. `marked`: the grid is a scalar
  /// that is 1 at active voxels, in place of its values. A mask always is. Throws Error(input).
  std::unique_ptr<FileGrid> open(const GridEntry& entry, bool marked = false);

  /// Does work that reads the entry. Throws Error(input) that names it, for any exception.
  void guarded(const GridEntry& entry, const std::function<void()>& work) const;

  const std::string& path() const { return file_->path(); }

 protected:
  /// `progress` receives the fraction of a grid that has been read.
  explicit GridFile(std::shared_ptr<FileBlocks> file, Progress progress);

  /// Lists all entries by `read`, and gives them their names. Throws Error(input) about a damaged
  /// file of that format.
  void list_entries(const char* format, const std::function<void()>& read);

  /// Opens a grid; `marked` if it is a mask, too.
  virtual std::unique_ptr<FileGrid> opened(const GridEntry& entry, bool marked) = 0;

  std::shared_ptr<FileBlocks> file_;
  MetadataText file_metadata_;
  FileBuffer buffer_;
  std::istream stream_{&buffer_};  ///< throws where the file ends
  std::vector<GridEntry> entries_;
  int lost_ = 0;
};

/// A grid of a file: its head and topology, which are in memory, and its leaves, which are read
/// when they are asked for. All grids are read like this, whatever the file's format.
class FileGrid {
 public:
  virtual ~FileGrid() = default;

  const GridHead& head() const { return head_; }
  const Topology& topology() const { return topology_; }
  const GridSummary& summary() const { return topology_.summary; }
  int channels() const { return topology_.summary.channels; }

  /// Why its values cannot be read leaf by leaf again. Empty if they can.
  virtual std::string why_whole() const = 0;

  /// Gives `value` to all that has the grid's background: its inactive voxels and tiles, and,
  /// unless the value is 0, the rest of the active voxels' box. Throws std::runtime_error if the
  /// grid's type does not have the value, or the box is too large to fill.
  void set_background(double value);

  /// Reads all leaves, in batches. With `enough` it ends after a batch after which enough() holds,
  /// and batches grow from one leaf, because most grids have what is looked for in their first.
  /// Throws Error(input).
  void each_leaf(const TakeLeaf& take, const std::function<bool()>& enough = {});

  /// Reads some leaves; `take` gets their places among the numbers. Only if why_whole is empty.
  /// Throws Error(input).
  void some_leaves(std::span<const std::uint32_t> numbers, const TakeLeaf& take);

 protected:
  /// `marked`: see GridFile::open.
  FileGrid(const GridFile& file, const GridEntry& entry, bool marked)
      : grid_file_(file), entry_(entry), marked_(marked) {}

  /// Sets the grid's head and topology, and what `marked` makes of them.
  void begin(GridHead head);

  /// The topology of a grid whose head is set, with `fill_` where it has its background.
  virtual Topology read_topology() = 0;
  /// Whether values of the grid's type can be this number.
  virtual bool can_be(double value) const = 0;
  /// Read the leaves of a grid that is not marked.
  virtual void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) = 0;
  virtual void read_some(std::span<const std::uint32_t>, const TakeLeaf&) {}

  bool is_marked() const { return marked_; }
  /// Does work that reads the grid, as GridFile::guarded does.
  void guarded(const std::function<void()>& work) const { grid_file_.guarded(entry_, work); }

  GridHead head_;
  Topology topology_;
  std::optional<double> fill_;  ///< in place of the background

 private:
  void fill_root(double value);

  const GridFile& grid_file_;
  const GridEntry& entry_;
  bool marked_;
};

/// Reads a grid, as Reader::read does; VolumeFile::read says what is thrown.
Field read_grid(GridFile& file, const GridEntry& entry, const ReadOptions& options);

/// Opens a grid again whose values have stayed in the file, to read leaves of it.
std::unique_ptr<FileGrid> open_stored(GridFile& file, const GridEntry& entry,
                                      const ReadOptions& options);
std::vector<float> stored_leaves(FileGrid& grid, const LeavesWish& wish);

/// What VolumeFile::z_up returns: evidence of a program whose Z axis is up. `grids` has the
/// metadata of each grid, `names` the grids' names.
std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids);

}  // namespace psivox::vdb
