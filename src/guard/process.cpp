#include "service.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "pack.h"
#include "psivox/error.h"

namespace psivox::guard {
namespace {

struct Header {
  std::uint64_t length;
  MessageKind kind;
  std::uint32_t zero;  // no byte is uninitialised
};

/// Room for a message's descriptors.
struct alignas(cmsghdr) Control {
  char bytes[CMSG_SPACE(2 * sizeof(int))];
};

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

std::pair<Descriptor, Descriptor> socket_pair(int type) {
  int ends[2];
  if (socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends) != 0)
    throw Error(ExitCode::failure, "no connection to the process that reads files: " +
                                       std::generic_category().message(errno));
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

bool send_with(int socket, std::string_view bytes, int first, int second) {
  Control control{};
  while (!bytes.empty()) {
    iovec part{const_cast<char*>(bytes.data()), bytes.size()};
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    const std::array<int, 2> numbers{first, second};
    const std::size_t count = first < 0 ? 0 : second < 0 ? 1 : 2;
    if (count > 0) {
      header.msg_control = control.bytes;
      header.msg_controllen = CMSG_SPACE(count * sizeof(int));
      cmsghdr* const attached = CMSG_FIRSTHDR(&header);
      attached->cmsg_level = SOL_SOCKET;
      attached->cmsg_type = SCM_RIGHTS;
      attached->cmsg_len = CMSG_LEN(count * sizeof(int));
      std::memcpy(CMSG_DATA(attached), numbers.data(), count * sizeof(int));
    }
    const ssize_t sent = sendmsg(socket, &header, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
    first = second = -1;
  }
  return true;
}

std::int64_t receive_with(int socket, char* bytes, std::size_t size, Descriptor* first,
                          Descriptor* second) {
  Control control{};
  iovec part{bytes, size};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes;
  header.msg_controllen = sizeof control.bytes;
  ssize_t got;
  do got = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  if (got < 0) return errno == EAGAIN ? -1 : 0;
  for (cmsghdr* some = CMSG_FIRSTHDR(&header); some; some = CMSG_NXTHDR(&header, some)) {
    if (some->cmsg_level != SOL_SOCKET || some->cmsg_type != SCM_RIGHTS) continue;
    std::vector<int> numbers((some->cmsg_len - CMSG_LEN(0)) / sizeof(int));
    std::memcpy(numbers.data(), CMSG_DATA(some), numbers.size() * sizeof(int));
    for (const int number : numbers) {
      Descriptor descriptor(number);
      if (first && !*first)
        *first = std::move(descriptor);
      else if (second && !*second)
        *second = std::move(descriptor);
    }
  }
  return got;
}

bool send(int socket, MessageKind kind, std::string_view content, int descriptor) {
  const Header header{content.size(), kind, 0};
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes += content;
  return send_with(socket, bytes, descriptor);
}

bool MessageInput::receive(int socket) {
  static thread_local std::array<char, 64 << 10> bytes;  // more than some threads have as a stack
  const std::int64_t got = receive_with(socket, bytes.data(), bytes.size(), &descriptor_);
  if (got == 0) return false;
  if (got > 0) bytes_.append(bytes.data(), static_cast<std::size_t>(got));
  return true;
}

std::optional<Message> MessageInput::next(std::uint64_t most) {
  Header header;
  if (bytes_.size() < sizeof header) return {};
  std::memcpy(&header, bytes_.data(), sizeof header);
  if (header.length > most) throw std::runtime_error("a message is too long");
  if (bytes_.size() - sizeof header < header.length) return {};
  Message message{header.kind, bytes_.substr(sizeof header, header.length), std::move(descriptor_)};
  bytes_.erase(0, sizeof header + header.length);
  return message;
}

Limits limits;
std::atomic<bool> demands_restriction = false;

namespace {

constexpr int tick_ms = 50;
constexpr double mebibyte = 1 << 20;
constexpr double slowness = sanitised ? 10 : 1;

constexpr std::size_t longest_error = 4096;

template <typename T>
bool receive_whole(int socket, T& value) {
  return receive_with(socket, reinterpret_cast<char*>(&value), sizeof value) == sizeof value;
}

}  // namespace

Budget::Budget(std::int64_t file_size)
    : file_size_(file_size),
      most_(slowness *
            (limits.seconds + limits.per_mebibyte * static_cast<double>(file_size) / mebibyte)) {}

void Budget::claim(std::uint64_t bytes) {
  constexpr double most_packed = 1032;  // bytes that deflate packs into one
  const double holds = most_packed * static_cast<double>(file_size_);
  deliver(static_cast<std::uint64_t>(std::min(static_cast<double>(bytes), holds)));
}

void Budget::deliver(std::uint64_t bytes) {
  most_ += slowness * limits.per_unpacked_mebibyte * static_cast<double>(bytes) / mebibyte;
}

bool Budget::spend(double processor, double idle) {
  const double used = processor_ += processor, waited = idle_ += idle;
  return used <= most_ && waited <= limits.idle + limits.idle_per_second * used;
}

Process::Process(std::string path, int file, std::shared_ptr<Budget> budget)
    : path_(std::move(path)), budget_(std::move(budget)), ends_(start_process()) {
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
  constexpr std::uint64_t scarce = 256 << 20;  // a library may not look whether it was given memory
  if (const std::uint64_t left = available_memory(); left > 0 && left < scarce)
    throw Error(ExitCode::memory, path_ + ": cannot be read: its reader ended where " +
                                      mebibytes(left) + " of memory are left");
  const int signal = WTERMSIG(status);
  if (signal == SIGKILL)
    fail("cannot be read: the system has ended its reader, for lack of memory");
  fail("is damaged: reading it crashed (" + std::string(strsignal(signal)) + ")");
}

double Process::seconds() const {
  clockid_t clock{};
  timespec time{};
  if (process_ <= 0 || clock_getcpuclockid(process_, &clock) != 0 ||
      clock_gettime(clock, &time) != 0)
    return counted_;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Process::count_time(double waited) {
  const double now = seconds(), used = now - counted_;
  counted_ = now;
  if (!budget_->spend(used, std::max(0.0, waited - used)))
    fail(
        "reading it took longer than a good file of its size can take; if you trust it, --trust"
        " reads without limits");
}

/// Time in which this process does not run, as on a machine that sleeps, does not count.
Message Process::next_message() {
  using Clock = std::chrono::steady_clock;
  constexpr std::uint64_t small = 64 << 20, per_byte = 64;
  const std::uint64_t most = std::min(
      MessageInput::longest, small + per_byte * static_cast<std::uint64_t>(budget_->file_size()));
  for (;;) {
    if (std::optional<Message> message = input_.next(most)) return std::move(*message);
    pollfd wait{ends_.connection.get(), POLLIN, 0};
    const Clock::time_point begin = Clock::now();
    const int ready = poll(&wait, 1, tick_ms);
    const std::chrono::duration<double> waited = Clock::now() - begin;
    count_time(std::min(waited.count(), 2e-3 * tick_ms));
    if (ready > 0 && !input_.receive(ends_.connection.get())) explain_end();
  }
}

bool Process::begin(std::string subject) {
  subject_ = std::move(subject);
  process();
  while (!restricted_) {
    const Message message = next_message();
    if (message.kind != MessageKind::begun) throw std::runtime_error("it answers unasked");
    unpack(message.content, restricted_.emplace());
  }
  return *restricted_;
}

std::string Process::ask(std::string_view request, int descriptor, std::string subject,
                         const Progress& progress) {
  if (!begin(std::move(subject)) && demands_restriction)
    fail(
        "is not read: the kernel does not restrict its reader's calls, as --trust=no demands; "
        "--trust=if-needed reads it under limits of time and memory");
  // if the reader has ended, receiving says why
  send(ends_.connection.get(), MessageKind::request, request, descriptor);
  intact_ = false;
  for (;;) {
    Message message = next_message();
    if (message.kind == MessageKind::answer) {
      intact_ = true;
      return std::move(message.content);
    }
    if (message.kind == MessageKind::failure) {
      int code = 0;
      std::string text;
      unpack(message.content, code, text, intact_);
      const bool memory = code == static_cast<int>(ExitCode::memory);
      throw Error(memory ? ExitCode::memory : ExitCode::input,
                  printable(text.substr(0, longest_error)));
    }
    double fraction = 0;
    unpack(message.content, fraction);
    if (progress && fraction >= 0 && fraction <= 1) progress(fraction);
  }
}

}  // namespace psivox::guard
