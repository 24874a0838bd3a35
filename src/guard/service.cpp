#include "service.h"

#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <exception>
#include <new>
#include <thread>

#include "base/memory.h"
#include "base/text.h"
#include "pack.h"

namespace psivox::guard {

decltype(before_answer) before_answer;

namespace {

void limit(__rlimit_resource what, std::uint64_t most) {
  const rlimit values{most, most};
  setrlimit(what, &values);
}

/// Calls that need no look at their arguments: on open descriptors, memory, threads and time.
constexpr std::string_view allowed_calls =
    "read readv pread64 write lseek recvmsg sendmsg poll ppoll close dup fstat fadvise64 "
    "memfd_create pwrite64 brk munmap mremap madvise futex set_robust_list rseq sched_yield "
    "sched_getaffinity gettid getpid membarrier rt_sigaction rt_sigprocmask rt_sigreturn "
    "sigaltstack restart_syscall exit exit_group clock_gettime clock_nanosleep nanosleep "
    "gettimeofday getrandom";

/// Loads the filter. All other calls fail, as in a kernel that lacks them: then libraries do
/// without. Returns false if the kernel refuses it: limits of resources still hold.
bool restrict_calls() {
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(
      seccomp_init(SCMP_ACT_ERRNO(ENOSYS)), seccomp_release);
  if (!filter) return false;
  const auto allow = [&](int call, auto... arguments) {
    seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, sizeof...(arguments), arguments...);
  };
  for (const std::string& name : split(allowed_calls, ' '))
    allow(seccomp_syscall_resolve_name(name.c_str()));
  // threads, but no processes
  allow(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  // an abort sends a signal to the process itself
  allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));
  // no new code
  allow(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  allow(SCMP_SYS(mprotect), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  // limits can be asked for
  allow(SCMP_SYS(prlimit64), SCMP_A2(SCMP_CMP_EQ, 0));
  return seccomp_load(filter.get()) == 0;
}

/// What reading a file of that size may take [bytes]: most of the free memory, but no more than a
/// good file of its size can need. OpenVDB fills what a damaged length asks for, which takes time.
std::uint64_t memory_for(std::uint64_t file_size) {
  // bytes that deflate packs into one, each of which becomes a float; resampling a frustum
  constexpr std::uint64_t most_unpacked = 1032 * sizeof(float),
                          to_resample = std::uint64_t{1} << 30;
  const std::uint64_t needed = to_resample + most_unpacked * file_size;
  const std::uint64_t available = available_memory() / 5 * 4;
  return available == 0 ? needed : std::min(available, needed);
}

/// Limits this process to `memory` bytes of its own, before it starts threads.
/// Returns whether the kernel restricts its calls.
bool restrict_process(std::uint64_t memory) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, memory);
  if (sanitised) return false;
  // stacks, and what the allocator reserves for each thread
  constexpr std::uint64_t stack = 16 << 20, reserved = 128 << 20;
  const std::uint64_t threads = std::thread::hardware_concurrency() + 1;
  limit(RLIMIT_DATA, memory + threads * stack);
  limit(RLIMIT_AS, 2 * memory + threads * (stack + reserved) + (std::uint64_t{4} << 30));
  return restrict_calls();
}

int crash_socket = -1;

/// Tells the program of a crash; nothing else is safe in a signal's handler.
void tell_crash(int signal) {
  struct [[gnu::packed]] {
    MessageKind kind = MessageKind::crash;
    int number;
  } const message{.number = signal};
  [[maybe_unused]] const ssize_t sent = write(crash_socket, &message, sizeof message);
  _exit(1);
}

/// A sanitizer tells of crashes itself.
void tell_crashes(int socket) {
  if (sanitised) return;
  crash_socket = socket;
  static std::array<char, 1 << 14> room;  // where the stack has overflowed
  const stack_t stack{room.data(), 0, room.size()};
  sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_handler = tell_crash;
  action.sa_flags = SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL})
    sigaction(signal, &action, nullptr);
}

class Connection {
 public:
  Connection(int socket, OpenService open) : socket_(socket), open_(open) {}

  /// Returns when the connection ends.
  void serve() {
    std::optional<Message> message = receive(socket_);
    if (!message) return;
    std::vector<std::string> paths;
    unpack(message->bytes, paths);
    std::vector<OpenFile> files;
    std::uint64_t size = 0;
    for (std::size_t n = 0; n < paths.size(); ++n) {
      struct stat status {};
      if (fstat(message->descriptors.at(n).get(), &status) == 0)
        size += static_cast<std::uint64_t>(status.st_size);
      files.push_back({paths[n], std::move(message->descriptors[n])});
    }
    if (!paths.empty()) path_ = paths.front();
    const std::uint64_t memory = memory_for(size);
    service_ = open_(std::move(files), [this](double fraction) { report(fraction); });
    reply(MessageKind::begun, packed(getpid(), restrict_process(memory)));
    while ((message = receive(socket_))) answer(message->bytes);
  }

 private:
  void answer(const std::string& request) {
    try {
      if (before_answer) before_answer(path_, request, socket_);
      const Answer made = service_(request);
      const Descriptor text = shared_copy(made.text);
      std::vector<int> memory{text.get()};
      for (const Descriptor& block : made.blocks) memory.push_back(block.get());
      reply(MessageKind::data, "", memory);
    } catch (const Error& error) {
      fail(error.code(), error.what(), error.code() == ExitCode::input);
    } catch (const std::bad_alloc&) {
      fail(ExitCode::input, path_ + ": asks for more memory than there is");
    } catch (const std::exception& error) {
      fail(ExitCode::input, path_ + ": cannot be read: " + error.what());
    }
  }

  void fail(ExitCode code, std::string message, bool intact = false) {
    constexpr std::size_t longest = 4096;
    message.resize(std::min(message.size(), longest));
    reply(MessageKind::failure, packed(static_cast<int>(code), message, intact));
  }

  void reply(MessageKind kind, const std::string& content, std::span<const int> memory = {}) {
    if (!send(socket_, packed(kind) + content, memory)) _exit(0);
  }

  /// Not more than every few milliseconds, however fast the file is read.
  void report(double fraction) {
    constexpr std::chrono::milliseconds pause(20);
    const auto now = std::chrono::steady_clock::now();
    if (fraction < 1 && now - reported_ < pause) return;
    reported_ = now;
    reply(MessageKind::progress, packed(fraction));
  }

  int socket_;
  OpenService open_;
  std::string path_;
  Service service_;
  std::chrono::steady_clock::time_point reported_{};
};

}  // namespace

void serve(int connection, OpenService open) {
  try {
    tell_crashes(connection);
    Connection(connection, open).serve();
  } catch (const std::exception&) {
    _exit(1);
  }
  _exit(0);
}

}  // namespace psivox::guard
