#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "file_blocks.h"
#include "fork_server.h"
#include "psivox/progress.h"
#include "socket.h"

namespace psivox::vdb {

/// What a reader may take for one answer [s]. A file that takes longer is refused, so these are far
/// above what good files take. Tests set others.
struct ReaderLimits {
  double seconds = 5;       ///< processor time for a small file
  double per_mebibyte = 1;  ///< and for each MiB of the file
  double idle = 60;         ///< without any use of the processor
};
extern ReaderLimits reader_limits;

/// The message of an Error(input) about an answer that no reader of a good file gives.
std::string nonsense(const FileBlocks& file, const std::string& what);

/// One reader process, as the program sees it. All that it sends may be the work of a hostile file.
class ReaderProcess {
 public:
  /// Starts the process.
  explicit ReaderProcess(std::shared_ptr<FileBlocks> file);

  /// The content of the answer to a request, which may be about a grid. Throws Error: the reader's
  /// own, or Error(input) about what became of it. Passes on what `progress` throws.
  std::string ask(MessageKind kind, std::string_view content, int descriptor,
                  const std::string& grid, const Progress& progress);

 private:
  class Watch;

  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void explain_end() const;
  std::optional<std::string> take_answer(const Progress& progress);
  pid_t process();

  std::shared_ptr<FileBlocks> file_;
  ReaderEnds ends_;
  MessageInput input_;
  pid_t process_ = 0;    ///< 0: not known yet
  std::string subject_;  ///< of messages: the file, and the grid if the request is about one
};

}  // namespace psivox::vdb
