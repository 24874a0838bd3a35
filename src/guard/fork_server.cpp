#include "service.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <mutex>
#include <system_error>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"

namespace psivox::guard {
namespace {

int server = -1;  ///< a socket to it; -1: it was not started

constexpr std::string_view plain_request = "r", prepared_request = "p";

/// The descriptor of a server that was started as a program.
constexpr int requests_of_program = 3;

void send_number(int socket, int number) {
  send(socket, {reinterpret_cast<const char*>(&number), sizeof number});
}

struct RunningProcess {
  pid_t process;
  Descriptor life;
};

/// Leaves the process no descriptor but 0, 1 and 2, which lead nowhere, and the given one, which
/// becomes 3.
void keep_only(int descriptor) {
  dup2(descriptor, 3);
  const int nowhere = open("/dev/null", O_RDWR);
  for (int standard = 0; standard < 3; ++standard)
    if (standard < 2 || !sanitised) dup2(nowhere, standard);
  close_range(4, ~0u, 0);
}

/// Only the program that reads decides when its readers end. A limit of memory is an error.
void ignore_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXFSZ})
    std::signal(number, SIG_IGN);
}

class ForkServer {
 public:
  ForkServer(int requests, const Trade& trade) : requests_(requests), trade_(trade) {
    sigset_t children;
    sigemptyset(&children);
    sigaddset(&children, SIGCHLD);
    sigprocmask(SIG_BLOCK, &children, nullptr);
    ends_ = Descriptor(signalfd(-1, &children, SFD_CLOEXEC));
  }

  /// Returns once the program has ended.
  void run() {
    for (;;) {
      std::vector<pollfd> waits{{requests_, POLLIN, 0}, {ends_.get(), POLLIN, 0}};
      // a reader's socket is readable only when the program has closed its end
      for (const RunningProcess& running : running_)
        waits.push_back({running.life.get(), POLLIN, 0});
      if (poll(waits.data(), waits.size(), -1) < 0) continue;
      for (std::size_t n = 2; n < waits.size(); ++n)
        if (waits[n].revents != 0) end(running_[n - 2]);
      if (waits[1].revents != 0) collect();
      if (waits[0].revents != 0 && !start()) break;
    }
    for (RunningProcess& running : running_) end(running);
  }

 private:
  static void end(RunningProcess& running) {
    kill(running.process, SIGKILL);
    running.life = Descriptor();
  }

  bool start() {
    std::optional<Message> request = receive(requests_);
    if (!request) return false;
    if (request->descriptors.size() != 2) return true;
    if (request->bytes == prepared_request) trade_.prepare();
    const Descriptor connection = std::move(request->descriptors[0]);
    Descriptor life = std::move(request->descriptors[1]);
    const pid_t process = fork();
    if (process == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      keep_only(connection.get());
      serve(3, trade_.open);
    }
    if (process < 0) return true;  // both ends close, which tells the program
    send_number(life.get(), process);
    running_.push_back({process, std::move(life)});
    return true;
  }

  void collect() {
    signalfd_siginfo ignored;
    [[maybe_unused]] const ssize_t got = read(ends_.get(), &ignored, sizeof ignored);
    int status = 0;
    pid_t process;
    while ((process = waitpid(-1, &status, WNOHANG)) > 0) {
      std::erase_if(running_, [&](const RunningProcess& running) {
        if (running.process != process) return false;
        if (running.life) send_number(running.life.get(), status);
        return true;
      });
    }
  }

  int requests_;
  Trade trade_;
  Descriptor ends_;
  std::vector<RunningProcess> running_;
};

[[noreturn]] void run_server(int requests, const Trade& trade) {
  try {
    prctl(PR_SET_NAME, "psivox-readers");
    keep_only(requests);
    ignore_signals();
    ForkServer(3, trade).run();
  } catch (const std::exception&) {  // the program notices the end
  }
  _exit(0);
}

}  // namespace

bool has_server() { return server >= 0; }

ProcessEnds start_process(bool prepared) {
  auto [connection, its_connection] = socket_pair();
  auto [life, its_life] = socket_pair();
  const int its[] = {its_connection.get(), its_life.get()};
  if (!send(server, prepared ? prepared_request : plain_request, its))
    throw Error(ExitCode::failure, "the process that starts readers of files has ended");
  return {std::move(connection), std::move(life)};
}

void start_server(const Trade& trade) {
  if (server >= 0) return;
  auto [program, requests] = socket_pair();
  const pid_t process = fork();
  if (process < 0) throw Error(ExitCode::failure, "no process to read files in can be started");
  if (process == 0) run_server(requests.get(), trade);
  server = fcntl(program.get(), F_DUPFD_CLOEXEC, 3);  // 0, 1 and 2 may be closed
}

void start_server(const std::filesystem::path& program) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  if (server >= 0) return;
  auto [here, requests] = socket_pair();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, requests.get(), requests_of_program);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // Ctrl-C in a terminal is for the process that reads
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  std::string name = program.string();
  char* arguments[] = {name.data(), nullptr};
  pid_t process = 0;
  const int failed = posix_spawn(&process, name.c_str(), &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed)
    throw Error(ExitCode::failure, in_quotes(name) + ", which reads files, cannot be started: " +
                                       std::generic_category().message(failed));
  server = fcntl(here.get(), F_DUPFD_CLOEXEC, 3);
}

void serve_as_program(const Trade& trade) { run_server(requests_of_program, trade); }

}  // namespace psivox::guard
