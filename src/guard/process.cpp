#include "service.h"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <utility>

#include "pack.h"
#include "psivox/error.h"

namespace psivox::guard {

Limits limits;

namespace {

constexpr int tick_ms = 50;

/// Processor time for a file of that size [s].
double most_seconds(std::int64_t file_size) {
  constexpr double slowness = sanitised ? 10 : 1;
  return slowness *
         (limits.seconds + limits.per_mebibyte * static_cast<double>(file_size) / (1 << 20));
}

/// In one line, whatever a reader sends.
std::string one_line(std::string text) {
  constexpr std::size_t longest = 4096;
  if (text.size() > longest) text.resize(longest);
  for (char& c : text)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
  return text;
}

template <typename T>
bool receive_whole(int socket, T& value) {
  return receive_with(socket, reinterpret_cast<char*>(&value), sizeof value) == sizeof value;
}

}  // namespace

/// Measures a process between two calls of exceeds(). Time in which this process does not run, as
/// on a machine that sleeps, does not count.
class Process::Watch {
 public:
  explicit Watch(pid_t process) {
    known_ = process > 0 && clock_getcpuclockid(process, &clock_) == 0;
    begin_ = last_ = seconds();
  }

  /// Called every tick or more often: the process has taken more time than that.
  bool exceeds(double limit) {
    const auto now = std::chrono::steady_clock::now();
    if (now - ticked_ < std::chrono::milliseconds(tick_ms)) return false;
    ticked_ = now;
    const double used = seconds();
    idle_ = used > last_ ? 0 : idle_ + 1e-3 * tick_ms;
    last_ = used;
    return used - begin_ > limit || idle_ > limits.idle;
  }

 private:
  double seconds() const {
    timespec time{};
    if (!known_ || clock_gettime(clock_, &time) != 0) return last_;
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

  clockid_t clock_{};
  bool known_ = false;
  double begin_ = 0, last_ = 0, idle_ = 0;  // [s]
  std::chrono::steady_clock::time_point ticked_ = std::chrono::steady_clock::now();
};

Process::Process(std::string path, int file, std::int64_t file_size)
    : path_(std::move(path)), most_seconds_(most_seconds(file_size)), ends_(start_process()) {
  send(ends_.connection.get(), MessageKind::open, path_, file);
}

void Process::fail(const std::string& what) const { throw Error(ExitCode::input, subject_ + what); }

pid_t Process::process() {
  if (process_ == 0 && !receive_whole(ends_.life.get(), process_)) process_ = -1;
  return process_;
}

void Process::explain_end() const {
  int status = 0;
  if (process_ < 0)
    throw Error(ExitCode::failure, path_ + ": no process to read it in could be started");
  if (!receive_whole(ends_.life.get(), status)) fail("cannot be read: its reader has ended");
  if (!WIFSIGNALED(status)) fail("cannot be read: its reader ended without an answer");
  const int signal = WTERMSIG(status);
  if (signal == SIGKILL)
    fail("cannot be read: the system has ended its reader, for lack of memory");
  fail("is damaged: reading it crashed (" + std::string(strsignal(signal)) + ")");
}

std::optional<std::string> Process::take_answer(const Progress& progress) {
  while (std::optional<Message> message = input_.next()) {
    if (message->kind == MessageKind::answer) return std::move(message->content);
    Unpacker unpack(message->content);
    if (message->kind == MessageKind::failure) {
      int code = 0;
      std::string text;
      unpack(code, text);
      const bool memory = code == static_cast<int>(ExitCode::memory);
      throw Error(memory ? ExitCode::memory : ExitCode::input, one_line(std::move(text)));
    }
    double fraction = 0;
    unpack(fraction);
    unpack.end();
    if (progress && fraction >= 0 && fraction <= 1) progress(fraction);
  }
  return {};
}

std::string Process::ask(std::string_view request, int descriptor, std::string subject,
                         const Progress& progress) {
  subject_ = std::move(subject);
  // if the reader has ended, receiving says why
  send(ends_.connection.get(), MessageKind::request, request, descriptor);
  Watch watch(process());
  for (;;) {
    pollfd wait{ends_.connection.get(), POLLIN, 0};
    const int ready = poll(&wait, 1, tick_ms);
    if (watch.exceeds(most_seconds_))
      fail(
          "reading it took longer than a good file of its size can take; if you trust it, --trust"
          " reads without limits");
    if (ready <= 0) continue;
    if (!input_.receive(ends_.connection.get())) explain_end();
    if (std::optional<std::string> answer = take_answer(progress)) return std::move(*answer);
  }
}

}  // namespace psivox::guard
