#include "channel.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "psivox/error.h"

namespace psivox::guard {
namespace {

/// Room for a message's descriptors.
struct alignas(cmsghdr) Control {
  char bytes[CMSG_SPACE(most_descriptors * sizeof(int))];
};

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

std::pair<Descriptor, Descriptor> socket_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw Error(ExitCode::failure, "no connection to the process that reads files: " +
                                       std::generic_category().message(errno));
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

bool send(int socket, std::string_view bytes, std::span<const int> descriptors) {
  if (bytes.size() > longest_message || descriptors.size() > most_descriptors) return false;
  Control control{};
  iovec part{const_cast<char*>(bytes.data()), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  if (!descriptors.empty()) {
    header.msg_control = control.bytes;
    header.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* const attached = CMSG_FIRSTHDR(&header);
    attached->cmsg_level = SOL_SOCKET;
    attached->cmsg_type = SCM_RIGHTS;
    attached->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(attached), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent;
  do sent = sendmsg(socket, &header, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent >= 0;
}

std::optional<Message> receive(int socket) {
  // more than some threads have as a stack
  static thread_local std::array<char, longest_message> bytes;
  Control control{};
  iovec part{bytes.data(), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes;
  header.msg_controllen = sizeof control.bytes;
  ssize_t got;
  do got = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  Message message{{bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0))}};
  for (cmsghdr* some = got < 0 ? nullptr : CMSG_FIRSTHDR(&header); some;
       some = CMSG_NXTHDR(&header, some)) {
    if (some->cmsg_level != SOL_SOCKET || some->cmsg_type != SCM_RIGHTS) continue;
    std::vector<int> numbers((some->cmsg_len - CMSG_LEN(0)) / sizeof(int));
    std::memcpy(numbers.data(), CMSG_DATA(some), numbers.size() * sizeof(int));
    for (const int number : numbers) message.descriptors.emplace_back(number);
  }
  if (got <= 0 || header.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) return {};
  return message;
}

Descriptor shared_copy(std::span<const std::string_view> all) {
  Descriptor memory(memfd_create("psivox answer", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory) throw std::bad_alloc();
  // faster than through a mapping, which the system fills page by page
  off_t end = 0;
  for (std::string_view bytes : all)
    while (!bytes.empty()) {
      const ssize_t written = pwrite(memory.get(), bytes.data(), bytes.size(), end);
      if (written < 0 && errno == EFBIG)
        throw std::runtime_error("its values are larger than the limit of file sizes (ulimit -f)");
      if (written < 0 && errno != EINTR) throw std::bad_alloc();
      end += std::max<ssize_t>(written, 0);
      bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
  return memory;
}

SealedMemory::SealedMemory(Descriptor memory) : memory_(std::move(memory)) {
  // Without the first two seals the size could change, without the third the bytes. The kernel
  // itself may hold pages for a moment, as when it looks for some to reclaim.
  int tries = 10;
  while (fcntl(memory_.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0) {
    if (errno != EBUSY || --tries == 0)
      throw std::runtime_error("shared memory is still written to");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  struct stat status {};
  if (fstat(memory_.get(), &status) != 0) throw std::runtime_error("shared memory has no size");
  size_ = static_cast<std::size_t>(status.st_size);
}

std::shared_ptr<const char> SealedMemory::map() const {
  void* const first = mmap(nullptr, size_, PROT_READ, MAP_SHARED | MAP_POPULATE, memory_.get(), 0);
  if (first == MAP_FAILED) throw std::bad_alloc();
  return {static_cast<const char*>(first),
          [size = size_](const char* map) { munmap(const_cast<char*>(map), size); }};
}

std::string SealedMemory::text() const {
  std::string text(size_, '\0');
  for (std::size_t at = 0; at < size_;) {
    const ssize_t got = pread(memory_.get(), text.data() + at, size_ - at, static_cast<off_t>(at));
    if (got <= 0) throw std::runtime_error("shared memory cannot be read");
    at += static_cast<std::size_t>(got);
  }
  return text;
}

}  // namespace psivox::guard
