#include "service.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <mutex>
#include <system_error>

#include "base/text.h"

namespace psivox::guard {
namespace {

int server = -1;  ///< a socket to it; -1: it was not started

constexpr std::string_view plain_request = "r", prepared_request = "p";

/// The descriptor of a server that was started as a program.
constexpr int requests_of_program = 3;

/// Leaves this process no descriptors but 0, 1 and 2, which lead nowhere, and the given ones, which
/// become 3 and 4; they are in ascending order.
void keep_only(int third, int fourth = -1) {
  dup2(third, 3);
  if (fourth >= 0) dup2(fourth, 4);
  const int nowhere = open("/dev/null", O_RDWR);
  for (int standard = 0; standard < 3; ++standard)
    if (standard < 2 || !sanitised) dup2(nowhere, standard);
  close_range(fourth >= 0 ? 5 : 4, ~0u, 0);
}

/// From now on the system kills this process when the other end of the socket closes.
void end_with(int socket) {
  fcntl(socket, F_SETOWN, getpid());
  fcntl(socket, F_SETSIG, SIGKILL);
  fcntl(socket, F_SETFL, O_ASYNC);
  pollfd before{socket, POLLIN, 0};
  if (poll(&before, 1, 0) != 0) _exit(0);
}

/// Only the program that reads decides when its readers end. A limit of memory is an error.
void ignore_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXFSZ})
    std::signal(number, SIG_IGN);
}

/// Returns once the program has ended. Preparing may start threads of libraries' own; a sanitizer's
/// allocator, unlike the system's, may be locked by one of them when this process forks.
void start_processes(int requests, const ServerWork& work) {
  std::signal(SIGCHLD, SIG_IGN);  // the system collects those that end
  while (std::optional<Message> request = receive(requests)) {
    if (request->descriptors.size() != 2) continue;
    if (request->bytes == prepared_request && !sanitised) work.prepare();
    if (fork() != 0) continue;
    keep_only(request->descriptors[0].get(), request->descriptors[1].get());
    end_with(4);
    serve(3, work.open);
  }
}

[[noreturn]] void run_server(int requests, const ServerWork& work) {
  try {
    prctl(PR_SET_NAME, "psivox-readers");
    keep_only(requests);
    ignore_signals();
    start_processes(3, work);
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

void start_server(const ServerWork& work) {
  if (server >= 0) return;
  auto [program, requests] = socket_pair();
  const pid_t process = fork();
  if (process < 0) throw Error(ExitCode::failure, "no process to read files in can be started");
  if (process == 0) run_server(requests.get(), work);
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

void serve_as_program(const ServerWork& work) { run_server(requests_of_program, work); }

}  // namespace psivox::guard
