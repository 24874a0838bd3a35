#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "psivox/progress.h"
#include "service.h"
#include "socket.h"

namespace psivox::guard {

/// What a reader may take for one answer [s]. A file that takes longer is refused, so these are far
/// above what good files take. Tests set others.
struct Limits {
  double seconds = 5;       ///< processor time for a small file
  double per_mebibyte = 1;  ///< and for each MiB of the file
  double idle = 60;         ///< without any use of the processor
};
extern Limits limits;

/// One reader process, as the program sees it. It serves one file. All that it sends may be the
/// work of a hostile file.
class Process {
 public:
  /// Starts the process and hands it an open file. Throws Error(failure).
  Process(std::string path, int file, std::int64_t file_size);

  /// The answer to a request, with which a descriptor may go. `subject` begins messages. Throws
  /// Error: the reader's own, or Error(input) about what became of it. Passes on what `progress`
  /// throws.
  std::string ask(std::string_view request, int descriptor, std::string subject,
                  const Progress& progress);

 private:
  class Watch;

  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void explain_end() const;
  std::optional<std::string> take_answer(const Progress& progress);
  pid_t process();

  std::string path_;
  double most_seconds_;  ///< of the processor, for an answer
  ProcessEnds ends_;
  MessageInput input_;
  pid_t process_ = 0;  ///< 0: not known yet
  std::string subject_;
};

}  // namespace psivox::guard
