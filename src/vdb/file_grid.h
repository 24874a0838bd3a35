#pragma once

#include <openvdb/openvdb.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "grid_file.h"
#include "psivox/field.h"
#include "survey.h"
#include "topology.h"

namespace psivox::vdb {

/// The leaves of a grid whose values stay in the file.
class StoredLeaves : public LeafReader {
 public:
  /// Without this, +Inf stays.
  virtual void replace_infinite(float largest) = 0;
};

/// A grid of a file: its head and topology, which are in memory, and its leaves, which are read
/// when they are asked for. All grids are read like this, whatever the file's format.
class FileGrid {
 public:
  virtual ~FileGrid() = default;
  FileGrid(const FileGrid&) = delete;
  FileGrid& operator=(const FileGrid&) = delete;

  /// Type, metadata, transform and background of the grid, without nodes.
  const openvdb::GridBase& head() const { return *head_; }
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

  /// Any leaf, read again from the file; `subject` begins messages. Only if why_whole is empty.
  /// `surveyed`: each_leaf has read all of them, and they need not be surveyed again.
  virtual std::shared_ptr<StoredLeaves> stored_leaves(const LeafSurvey& survey, std::string subject,
                                                      bool surveyed) = 0;

 protected:
  /// `marked`: see GridFile::open.
  FileGrid(const GridFile& file, const GridEntry& entry, bool marked)
      : grid_file_(file), entry_(entry), marked_(marked) {}

  /// Sets the grid's head and topology, and what `marked` makes of them.
  void begin(openvdb::GridBase::Ptr head, bool masks);

  /// The topology of a grid whose head is set. Gives the head its background.
  virtual Topology read_topology(const TopologyWish& wish) = 0;
  /// Reads the leaves of a grid that is not marked.
  virtual void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) = 0;

  bool is_marked() const { return marked_; }
  /// Does work that reads the grid, as GridFile::guarded does.
  void guarded(const std::function<void()>& work) const { grid_file_.guarded(entry_, work); }

  openvdb::GridBase::Ptr head_;
  Topology topology_;
  std::optional<double> fill_;  ///< in place of the background

 private:
  void mark();
  void fill_root(double value);

  const GridFile& grid_file_;
  const GridEntry& entry_;
  bool marked_, masks_ = false;
};

}  // namespace psivox::vdb
