#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

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
  request,  ///< whatever a Service takes; with a descriptor or none
  progress,
  answer,
  failure,  ///< an Error
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

  /// The next complete message. Throws std::runtime_error if it claims more than `longest` bytes.
  std::optional<Message> next();

  static constexpr std::uint64_t longest = std::uint64_t{1} << 30;  // [bytes]

 private:
  std::string bytes_;
  Descriptor descriptor_;
};

}  // namespace psivox::guard
