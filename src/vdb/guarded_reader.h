#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "file_blocks.h"
#include "psivox/progress.h"
#include "reader.h"
#include "reader_process.h"

namespace psivox::vdb {

/// Reads in a process of its own. After an error the next call starts another one.
class GuardedReader final : public Reader {
 public:
  explicit GuardedReader(std::shared_ptr<FileBlocks> file, Progress progress = {});

  FileFacts facts() override;
  std::vector<GridInfo> info(bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  /// Calls take(answer) with an Unpacker. The request may be about a grid. Throws Error(input).
  template <typename Take>
  void ask(MessageKind kind, const std::string& content, int descriptor, const std::string& grid,
           const Take& take);
  /// The rows of a grid, or of all: "".
  std::vector<GridInfo> rows(const std::string& grid, bool values);
  GridInfo row(const std::string& grid, bool values);

  std::shared_ptr<FileBlocks> file_;
  Progress progress_;
  std::mutex mutex_;  ///< of what follows: one request at a time
  std::unique_ptr<ReaderProcess> process_;
  FileFacts facts_;
  std::weak_ptr<const void> last_storage_;  ///< of the process's last field
  Field last_;                              ///< leaves and tiles of the last field, without storage
};

}  // namespace psivox::vdb
