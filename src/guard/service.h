#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "channel.h"
#include "psivox/error.h"

namespace psivox::guard {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitised = true;  ///< slow, with terabytes of addresses, and it opens files
#else
inline constexpr bool sanitised = false;
#endif

/// What a guarded process says, in a message's first byte.
enum class MessageKind : std::uint8_t {
  begun,     ///< its id, and whether the kernel restricts its calls; before the first answer
  crash,     ///< the signal that ends it
  progress,  ///< the fraction that is done
  failure,   ///< an Error, and whether the service can answer more
  data,      ///< an answer, in memory: its text, and then its blocks
};

struct OpenFile {
  std::string path;  ///< for messages
  Descriptor descriptor;
};

struct Answer {
  std::string text;
  std::vector<Descriptor> blocks{};  ///< made by shared_copy
};

/// What a guarded process does with its files: it answers a request. What it throws goes back, too.
using Service = std::function<Answer(std::string_view request)>;
using OpenService = Service (*)(std::vector<OpenFile> files, Progress progress);

/// Answers a Process's requests until the connection ends; this process then ends, too. The first
/// message has the open files. From then on the process is limited, for good: it can have most of
/// the free memory and write as much to shared memory, leaves no core file, and can neither open
/// files nor start programs, nor reach others.
[[noreturn]] void serve(int connection, OpenService open);

/// What the processes do that a server forks.
struct ServerWork {
  void (*prepare)();  ///< in the server, for all that it forks later; see start_process
  OpenService open;
};

/// Starts the server by a fork, before the program has threads. It ends with the program. Does
/// nothing if one runs. Throws Error(failure).
void start_server(const ServerWork& work);

/// Starts the server as a program of its own, which calls serve_as_program(). Any thread may do so.
void start_server(const std::filesystem::path& program);
[[noreturn]] void serve_as_program(const ServerWork& work);

bool has_server();

/// The ends of a new process that belong to this one.
struct ProcessEnds {
  Descriptor connection;  ///< messages to and from the process
  Descriptor life;        ///< closing it ends the process
};

/// Starts a process; `prepared`: after ServerWork::prepare. May be called from several threads.
/// Throws Error(failure).
ProcessEnds start_process(bool prepared);

/// For tests: called with the file's path, the request and the connection before each answer, in
/// the guarded process. To be set before the server starts.
extern std::function<void(const std::string& path, std::string_view request, int connection)>
    before_answer;

/// Whether processes whose calls the kernel does not restrict are refused.
extern std::atomic<bool> demands_restriction;

/// What the readers of a file may take, all answers together [s]. A file that takes longer is
/// refused, so these are far above what good files take. Tests set others.
struct Limits {
  double seconds = 10;                 ///< processor time for a small file
  double per_mebibyte = 2;             ///< and for each MiB of the file
  double per_unpacked_mebibyte = 0.1;  ///< and for each MiB of values
  double idle = 60;                    ///< without use of the processor,
  double idle_per_second = 10;         ///< and for each second of its use
};
extern Limits limits;

/// The time of a file's readers. Several threads may use it.
class Budget {
 public:
  explicit Budget(std::int64_t file_size);

  /// The file's header claims so many bytes of values, of which no more count than a file of that
  /// size can hold.
  void claim(std::uint64_t bytes);
  /// A reader has sent so many bytes of values.
  void deliver(std::uint64_t bytes);
  /// Notes processor time and time without its use. Returns false if that is too much.
  bool spend(double processor, double idle);

  std::int64_t file_size() const { return file_size_; }

 private:
  std::int64_t file_size_;
  std::atomic<double> most_, processor_ = 0, idle_ = 0;
};

/// A file that another process is to read.
struct SharedFile {
  std::string path;
  int descriptor;
};

/// What a process answers.
struct SealedAnswer {
  std::string text;
  std::vector<SealedMemory> blocks;
};

/// One reader process, as the program sees it. It serves one file. All that it sends may be the
/// work of a hostile file.
class Process {
 public:
  /// Starts the process and hands it open files; the first one's path begins messages. Throws
  /// Error(failure).
  Process(const std::vector<SharedFile>& files, std::shared_ptr<Budget> budget, bool prepared);

  /// Waits until the process has limited itself. Returns whether the kernel restricts its calls.
  /// Throws Error(input) about what became of it.
  bool begin(std::string subject);

  /// Whether it can answer after ask() threw.
  bool is_intact() const { return intact_; }

  /// The answer to a request. `subject` begins messages. Throws Error: the reader's own, or
  /// Error(input) about what became of it. Passes on what `progress` throws.
  SealedAnswer ask(std::string_view request, std::string subject, const Progress& progress);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  /// `signal`: what it said of a crash; 0: nothing.
  [[noreturn]] void explain_end(int signal) const;
  Message next_message();
  SealedAnswer sealed(Message message) const;
  double seconds() const;
  void count_time(double waited);

  std::string path_;
  std::shared_ptr<Budget> budget_;
  double counted_ = 0;  ///< of the processor's time [s]
  bool restricted_ = false, intact_ = true;
  ProcessEnds ends_;
  pid_t process_ = 0;  ///< 0: it has not begun
  std::string subject_;
};

}  // namespace psivox::guard
