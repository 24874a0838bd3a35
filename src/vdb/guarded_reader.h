#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "guard/process.h"
#include "psivox/progress.h"
#include "reader.h"
#include "reading_messages.h"

namespace psivox::vdb {

/// Reads in a process of its own, which answers as an InPlaceReader does. After an error the next
/// call starts another process.
class GuardedReader final : public Reader {
 public:
  /// `data`: as open_reader takes it.
  GuardedReader(std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data,
                Progress progress = {});

  FileFacts facts() override;
  std::vector<GridInfo> info(const std::string& grid, bool values) override;
  GridContent content(const std::string& grid) override;
  Field read(const std::string& grid, const ReadOptions& options) override;

 private:
  /// The answer to a request, after check(answer). Throws Error(input).
  template <typename R, typename Check>
  typename R::Answer ask(const R& request, int descriptor, const Check& check);
  template <typename R>
  typename R::Answer ask(const R& request);
  GridInfo row(const std::string& grid, bool values);
  void take_field(FieldFacts& facts, int memory, const std::shared_ptr<const void>& held);

  void start();

  std::shared_ptr<FileBlocks> file_, data_;
  Progress progress_;
  std::mutex mutex_;  ///< of what follows: one request at a time
  std::unique_ptr<guard::Process> process_;
  FileFacts facts_;
  std::weak_ptr<const void> last_storage_;  ///< of the process's last field
  Field last_;                              ///< its leaves and tiles, without storage
};

}  // namespace psivox::vdb
