#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <utility>

#include "base/memory.h"
#include "base/text.h"
#include "pack.h"
#include "psivox/error.h"
#include "service.h"

namespace psivox::guard {

Limits limits;
std::atomic<bool> demands_restriction = false;

namespace {

constexpr int tick_ms = 50;
constexpr double mebibyte = 1 << 20;
constexpr double slowness = sanitised ? 10 : 1;

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

Process::Process(const std::vector<SharedFile>& files, std::shared_ptr<Budget> budget,
                 bool prepared)
    : budget_(std::move(budget)), ends_(start_process(prepared)) {
  std::vector<std::string> paths;
  std::vector<int> descriptors;
  for (const SharedFile& file : files) {
    paths.push_back(file.path);
    descriptors.push_back(file.descriptor);
  }
  if (!files.empty()) path_ = paths.front();
  send(ends_.connection.get(), packed(paths), descriptors);
}

void Process::fail(const std::string& what) const { throw Error(ExitCode::input, subject_ + what); }

void Process::explain_end(int signal) const {
  constexpr std::uint64_t scarce = 256 << 20;  // a library may not look whether it was given memory
  if (const std::uint64_t left = available_memory(); left > 0 && left < scarce)
    throw Error(ExitCode::memory, path_ + ": cannot be read: its reader ended where " +
                                      mebibytes(left) + " of memory are left");
  if (process_ == 0 && signal == 0)
    throw Error(ExitCode::failure, path_ + ": no process to read it in could be started");
  if (signal != 0) fail("is damaged: reading it crashed (" + std::string(strsignal(signal)) + ")");
  fail(
      "cannot be read: its reader ended without an answer; the system may have ended it for lack of"
      " memory");
}

double Process::seconds() const {
  clockid_t clock{};
  timespec time{};
  if (process_ == 0 || clock_getcpuclockid(process_, &clock) != 0 ||
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
  for (;;) {
    pollfd wait{ends_.connection.get(), POLLIN, 0};
    const Clock::time_point begin = Clock::now();
    const int ready = poll(&wait, 1, tick_ms);
    const std::chrono::duration<double> waited = Clock::now() - begin;
    count_time(std::min(waited.count(), 2e-3 * tick_ms));
    if (ready <= 0) continue;
    std::optional<Message> message = receive(ends_.connection.get());
    if (!message) explain_end(0);
    if (static_cast<MessageKind>(message->bytes.front()) != MessageKind::crash)
      return std::move(*message);
    int signal = 0;
    unpack(std::string_view(message->bytes).substr(1), signal);
    explain_end(signal);
  }
}

bool Process::begin(std::string subject) {
  subject_ = std::move(subject);
  if (process_ == 0) {
    MessageKind kind;
    unpack(next_message().bytes, kind, process_, restricted_);
    if (kind != MessageKind::begun) throw std::runtime_error("it answers unasked");
  }
  return restricted_;
}

SealedAnswer Process::sealed(Message message) const {
  constexpr std::uint64_t small = 64 << 20, per_byte = 64;  // [bytes]
  const std::uint64_t most = small + per_byte * static_cast<std::uint64_t>(budget_->file_size());
  std::vector<SealedMemory> memory;
  for (Descriptor& descriptor : message.descriptors) memory.emplace_back(std::move(descriptor));
  if (memory.empty()) throw std::runtime_error("an answer without memory");
  if (memory.front().size() > most) throw std::runtime_error("a message is too long");
  std::string text = memory.front().text();
  memory.erase(memory.begin());
  return {std::move(text), std::move(memory)};
}

SealedAnswer Process::ask(std::string_view request, std::string subject, const Progress& progress) {
  if (!begin(std::move(subject)) && demands_restriction)
    fail(
        "is not read: the kernel does not restrict its reader's calls, as --trust=no demands; "
        "--trust=if-needed reads it under limits of time and memory");
  if (request.size() > longest_message) fail("has a name that is too long");
  send(ends_.connection.get(), request);  // if the reader has ended, receiving says why
  intact_ = false;
  for (;;) {
    Message message = next_message();
    const std::string_view content = std::string_view(message.bytes).substr(1);
    switch (static_cast<MessageKind>(message.bytes.front())) {
      case MessageKind::data: {
        SealedAnswer answer = sealed(std::move(message));
        intact_ = true;
        return answer;
      }
      case MessageKind::failure: {
        int code = 0;
        std::string text;
        unpack(content, code, text, intact_);
        const bool memory = code == static_cast<int>(ExitCode::memory);
        throw Error(memory ? ExitCode::memory : ExitCode::input, printable(text));
      }
      default: {
        double fraction = 0;
        unpack(content, fraction);
        if (progress && fraction >= 0 && fraction <= 1) progress(fraction);
      }
    }
  }
}

}  // namespace psivox::guard
