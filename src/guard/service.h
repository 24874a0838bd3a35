#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "psivox/error.h"

namespace psivox::guard {

/// A descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();

  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

/// Two connected ends. Throws Error(failure).
std::pair<Descriptor, Descriptor> socket_pair(int type);

/// Sends bytes, with up to two descriptors. Returns false if the other end is closed.
bool send_with(int socket, std::string_view bytes, int first = -1, int second = -1);

/// Receives up to `size` bytes, and descriptors that came with them. Returns 0 at the end of the
/// connection, and -1 if there is nothing yet.
std::int64_t receive_with(int socket, char* bytes, std::size_t size, Descriptor* first = nullptr,
                          Descriptor* second = nullptr);

enum class MessageKind : std::uint32_t {
  open,     ///< the path of the file that a process is to serve; with its descriptor
  begun,    ///< whether the kernel restricts the process's calls; before the first answer
  request,  ///< whatever a Service takes; with a descriptor or none
  progress,
  answer,
  failure,  ///< an Error, and whether the service can answer more
};

struct Message {
  MessageKind kind{};
  std::string content;
  Descriptor descriptor{};  ///< that came with it
};

/// Sends a message. Returns false if the other end is closed.
bool send(int socket, MessageKind kind, std::string_view content, int descriptor = -1);

/// Puts messages together from what arrives.
class MessageInput {
 public:
  /// Reads what has arrived; blocks if nothing has and the socket does. Returns false at the end of
  /// the connection.
  bool receive(int socket);

  static constexpr std::uint64_t longest = std::uint64_t{1} << 30;  // [bytes]

  /// The next complete message. Throws std::runtime_error if it claims more than `most` bytes.
  std::optional<Message> next(std::uint64_t most = longest);

 private:
  std::string bytes_;
  Descriptor descriptor_;
};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitised = true;  ///< slow, with terabytes of addresses, and it opens files
#else
inline constexpr bool sanitised = false;
#endif

/// What a guarded process does with its file.
class Service {
 public:
  virtual ~Service() = default;
  /// The answer to a request, with the descriptor that came with it. What it throws goes back, too.
  virtual std::string answer(std::string_view request, int descriptor) = 0;
};

/// Makes the service of an open file. The path is for messages.
using OpenService = std::unique_ptr<Service> (*)(std::string path, Descriptor file,
                                                 Progress progress);

/// Answers a Process's requests until the connection ends; this process then ends, too. The first
/// message opens the file. From then on the process is limited, for good: it can have most of the
/// free memory and write as much to shared memory, leaves no core file, and can neither open files
/// nor start programs, nor reach others.
[[noreturn]] void serve(int connection, OpenService open);

/// What the processes do that a server forks.
struct Trade {
  void (*prepare)();  ///< in the server, for all that it forks later; see prepare_server
  OpenService open;
};

/// Starts the server by a fork, before the program has threads. It ends with the program. Does
/// nothing if one runs. Throws Error(failure).
void start_server(const Trade& trade);

/// Starts the server as a program of its own, which calls serve_as_program(). Any thread may do so.
void start_server(const std::filesystem::path& program);
[[noreturn]] void serve_as_program(const Trade& trade);

bool has_server();

/// Lets the server call Trade::prepare, for which processes that start later wait. Throws
/// Error(failure).
void prepare_server();

/// The ends of a new process that belong to this one.
struct ProcessEnds {
  Descriptor connection;  ///< messages to and from the process
  /// From the server: the process's id as a pid_t, once it runs, and its status as waitpid has it
  /// in an int, once it has ended. Closing it ends the process.
  Descriptor life;
};

/// Starts a process. May be called from several threads. Throws Error(failure).
ProcessEnds start_process();

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

/// One reader process, as the program sees it. It serves one file. All that it sends may be the
/// work of a hostile file.
class Process {
 public:
  /// Starts the process and hands it an open file. Throws Error(failure).
  Process(std::string path, int file, std::shared_ptr<Budget> budget);

  /// Waits until the process has limited itself. Returns whether the kernel restricts its calls.
  /// Throws Error(input) about what became of it.
  bool begin(std::string subject);

  /// Whether it can answer after ask() threw.
  bool is_intact() const { return intact_; }

  /// The answer to a request, with which a descriptor may go. `subject` begins messages. Throws
  /// Error: the reader's own, or Error(input) about what became of it. Passes on what `progress`
  /// throws.
  std::string ask(std::string_view request, int descriptor, std::string subject,
                  const Progress& progress);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void explain_end() const;
  Message next_message();
  double seconds() const;
  void count_time(double waited);
  pid_t process();

  std::string path_;
  std::shared_ptr<Budget> budget_;
  double counted_ = 0;  ///< of the processor's time [s]
  std::optional<bool> restricted_;
  bool intact_ = true;
  ProcessEnds ends_;
  MessageInput input_;
  pid_t process_ = 0;  ///< 0: not known yet
  std::string subject_;
};

}  // namespace psivox::guard
