#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "archive.h"
#include "file_grid.h"
#include "leaf_decoder.h"
#include "psivox/field.h"
#include "survey.h"

namespace psivox::vdb {

/// A grid of an Archive, whatever its type and format: its leaves are read one batch after another.
class ArchiveGrid final : public FileGrid {
 public:
  ArchiveGrid(Archive& archive, const GridEntry& entry, std::shared_ptr<FileBlocks> file,
              bool marked);

  std::string why_whole() const override;
  std::shared_ptr<StoredLeaves> stored_leaves(const LeafSurvey& survey, std::string subject,
                                              bool surveyed) override;

  /// Where leaves begin in the file, and where the last one ends [bytes].
  const std::vector<std::int64_t>& places() const { return places_; }
  LeafDecoder decoder() const { return {file_, head_, archive_->stream(), fill_}; }

 private:
  Topology read_topology(const TopologyWish& wish) override;
  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override;
  void find_places();

  std::unique_ptr<Archive> rewritten_;  ///< of a grid in an old format
  Archive* archive_;
  std::shared_ptr<FileBlocks> file_;
  bool points_;
  std::string delayed_load_;
  std::int64_t tree_at_ = 0, leaves_at_ = 0, end_ = 0;  ///< in the file [bytes]
  std::vector<std::int64_t> places_;
};

/// The leaves of a grid whose values stay in the file. Any of them are read again by their places.
class FileLeaves final : public StoredLeaves {
 public:
  /// The grid's places are known. `subject` begins messages. Leaves that have been surveyed cannot
  /// be surveyed again.
  FileLeaves(const ArchiveGrid& grid, const LeafSurvey& survey, std::string subject, bool surveyed);

  void replace_infinite(float largest) override { largest_ = largest; }

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
