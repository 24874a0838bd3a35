#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "psivox/progress.h"
#include "socket.h"

namespace psivox::guard {

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
  void (*prepare)();  ///< once for all of them, in the server
  OpenService open;
};

/// Starts the server by a fork, before the program has threads. It ends with the program. Does
/// nothing if one runs. Throws Error(failure).
void start_server(const Trade& trade);

/// Starts the server as a program of its own, which calls serve_as_program(). Any thread may do so.
void start_server(const std::filesystem::path& program);
[[noreturn]] void serve_as_program(const Trade& trade);

bool has_server();

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

/// Whether the kernel can restrict a process's system calls.
bool has_seccomp();

}  // namespace psivox::guard
