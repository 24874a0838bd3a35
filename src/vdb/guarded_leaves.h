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

  void read(std::span<const std::uint32_t> leaves, float* values) const override;

 private:
  mutable std::mutex mutex_;  ///< of the process
  std::unique_ptr<ReaderProcess> process_;
  std::shared_ptr<FileBlocks> file_;
  std::size_t floats_per_leaf_;
  GridRole role_;
};

}  // namespace psivox::vdb
