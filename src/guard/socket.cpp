#include "service.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <vector>

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
  std::array<char, 64 << 10> bytes;
  const std::int64_t got = receive_with(socket, bytes.data(), bytes.size(), &descriptor_);
  if (got == 0) return false;
  if (got > 0) bytes_.append(bytes.data(), static_cast<std::size_t>(got));
  return true;
}

std::optional<Message> MessageInput::next() {
  Header header;
  if (bytes_.size() < sizeof header) return {};
  std::memcpy(&header, bytes_.data(), sizeof header);
  if (header.length > longest) throw std::runtime_error("a message is too long");
  if (bytes_.size() - sizeof header < header.length) return {};
  Message message{header.kind, bytes_.substr(sizeof header, header.length), std::move(descriptor_)};
  bytes_.erase(0, sizeof header + header.length);
  return message;
}

}  // namespace psivox::guard
