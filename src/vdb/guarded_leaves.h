#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "file_blocks.h"
#include "psivox/active_values.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "reader_process.h"
#include "reading_messages.h"

namespace psivox::vdb {

/// Leaves whose values stay in the file, read by the process that has read the field.
class GuardedLeaves final : public LeafReader, public ActiveValues {
 public:
  GuardedLeaves(std::unique_ptr<ReaderProcess> process, std::shared_ptr<FileBlocks> file,
                const FieldFacts& facts, GridRole role);

  void read(std::span<const std::uint32_t> leaves, float* values) const override {
    ask(leaves, values, nullptr, false);
  }
  ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const override {
    ValueSurvey survey;
    ask(leaves, values, &survey, false);
    return survey;
  }
  void read_active(std::span<const std::uint32_t> leaves, float* values) const override {
    ask(leaves, values, nullptr, true);
  }
  const std::vector<TileValue>& active_tiles() const override { return active_tiles_; }

 private:
  /// Reads leaves and adds what is found in them, if it is wanted. `active`: see read_active.
  void ask(std::span<const std::uint32_t> leaves, float* values, ValueSurvey* survey,
           bool active) const;

  mutable std::mutex mutex_;  ///< of the process
  std::unique_ptr<ReaderProcess> process_;
  std::shared_ptr<FileBlocks> file_;
  std::size_t floats_per_leaf_;
  GridRole role_;
  bool infinite_;  ///< whether values may be +Inf
  std::vector<TileValue> active_tiles_;
};

}  // namespace psivox::vdb
