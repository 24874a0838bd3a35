#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "archive.h"
#include "leaf_decoder.h"
#include "psivox/field.h"
#include "survey.h"
#include "topology.h"

namespace psivox::vdb {

/// A grid of a file: its head and topology, which are in memory, and its leaves, which are read one
/// batch after another. All grids are read like this, whatever their type and format.
class FileGrid {
 public:
  /// Reads head and topology. `marked`: the grid is a scalar that is 1 at active voxels, in place
  /// of its values. A mask always is. Throws Error(input).
  FileGrid(Archive& archive, const GridEntry& entry, std::shared_ptr<FileBlocks> file,
           bool marked = false);

  /// Type, metadata, transform and background of the grid, without nodes.
  const openvdb::GridBase& head() const { return *head_; }
  const Topology& topology() const { return topology_; }
  const GridSummary& summary() const { return topology_.summary; }
  int channels() const { return topology_.summary.channels; }

  /// Why its values cannot be read leaf by leaf again: they are not in leaves. Empty if they can.
  std::string why_whole() const;

  /// Gives `value` to all that has the grid's background: its inactive voxels and tiles, and,
  /// unless the value is 0, the rest of the active voxels' box. Throws std::runtime_error if the
  /// grid's type does not have the value, or the box is too large to fill.
  void set_background(double value);

  /// Reads all leaves, in batches. With `enough` it ends after a batch after which enough() holds,
  /// and batches grow from one leaf, because most grids have what is looked for in their first.
  /// Throws Error(input).
  void each_leaf(const TakeLeaf& take, const std::function<bool()>& enough = {});

  /// Where leaves begin in the file, and where the last one ends [bytes]. each_leaf finds the
  /// places of the leaves that it reads. find_places finds all of them by the metadata for delayed
  /// loading or, if these do not lead to the grid's end, by a few bytes of each leaf.
  const std::vector<std::int64_t>& places() const { return places_; }
  void find_places();
  LeafDecoder decoder() const { return {file_, head_, archive_->stream(), fill_}; }

 private:
  enum class Kind { values, points, marked };

  void each_stored_leaf(const TakeLeaf& take, const std::function<bool()>& enough);
  void mark();
  void fill_root(double value);

  std::unique_ptr<Archive> rewritten_;  ///< of a grid in an old format
  Archive* archive_;
  const GridEntry* entry_;
  std::shared_ptr<FileBlocks> file_;
  Kind kind_;
  openvdb::GridBase::Ptr head_;
  std::string delayed_load_;
  std::int64_t tree_at_ = 0, leaves_at_ = 0, end_ = 0;  ///< in the file [bytes]
  Topology topology_;
  std::optional<double> fill_;  ///< in place of the background
  std::vector<std::int64_t> places_;
};

/// The leaves of a grid whose values stay in the file. Any of them are read again by their places.
class FileLeaves final : public LeafReader {
 public:
  /// The grid's places are known. `subject` begins messages. Leaves that have been surveyed cannot
  /// be surveyed again.
  FileLeaves(const FileGrid& grid, const LeafSurvey& survey, std::string subject, bool surveyed);

  /// Without this, +Inf stays.
  void replace_infinite(float largest) { largest_ = largest; }

  void read(std::span<const std::uint32_t> leaves, float* values) const override;
  ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const override;
  void read_active(std::span<const std::uint32_t> leaves, float* values) const override;
  const std::vector<TileValue>& active_tiles() const override { return active_tiles_; }

 private:
  /// Copies the values of leaves, and calls take(n, values, active) for each.
  template <typename Take>
  void decode(std::span<const std::uint32_t> leaves, float* values, const Take& take) const;
  /// Cleans a leaf's values.
  void clean(float* values, const LeafMask& active) const;

  LeafDecoder decoder_;
  LeafSurvey survey_;
  std::string subject_;
  std::vector<std::int64_t> places_;
  std::vector<glm::ivec3> origins_;  ///< unless they have been surveyed
  std::size_t floats_per_leaf_;
  float largest_ = std::numeric_limits<float>::infinity();
  std::vector<TileValue> active_tiles_;
};

}  // namespace psivox::vdb
