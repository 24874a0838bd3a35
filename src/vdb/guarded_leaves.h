#pragma once

#include <memory>
#include <mutex>

#include "file_blocks.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "reader_process.h"

namespace psivox::vdb {

/// Leaves whose values stay in the file, read by the process that has read the field.
class GuardedLeaves final : public LeafReader {
 public:
  GuardedLeaves(std::unique_ptr<ReaderProcess> process, std::shared_ptr<FileBlocks> file,
                const Field& field, GridRole role);

  void read(std::span<const std::uint32_t> leaves, float* values) const override {
    ask(leaves, values, nullptr);
  }
  ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const override {
    ValueSurvey survey;
    ask(leaves, values, &survey);
    return survey;
  }

 private:
  /// Reads leaves and adds what is found in them, if it is wanted.
  void ask(std::span<const std::uint32_t> leaves, float* values, ValueSurvey* survey) const;

  mutable std::mutex mutex_;  ///< of the process
  std::unique_ptr<ReaderProcess> process_;
  std::shared_ptr<FileBlocks> file_;
  std::size_t floats_per_leaf_;
  GridRole role_;
  bool infinite_;  ///< whether values may be +Inf
};

}  // namespace psivox::vdb
