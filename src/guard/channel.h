#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// What goes between processes: short messages with descriptors, and memory that nobody can change
// once it has arrived.

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
std::pair<Descriptor, Descriptor> socket_pair();

struct Message {
  std::string bytes;
  std::vector<Descriptor> descriptors{};
};

inline constexpr std::size_t longest_message = 64 << 10;  // [bytes]
inline constexpr std::size_t most_descriptors = 250;      // Linux takes 253 at once

/// Sends a message of 1 to longest_message bytes, with descriptors. Returns false if it is longer,
/// or the other end is closed.
bool send(int socket, std::string_view bytes, std::span<const int> descriptors = {});

/// The next message, for which it waits. Nothing at the end of the connection, and if a message is
/// too long.
std::optional<Message> receive(int socket);

/// Memory with a copy of some bytes, one after another. Throws std::bad_alloc, or
/// std::runtime_error if a limit of file sizes is in the way.
Descriptor shared_copy(std::span<const std::string_view> all);
inline Descriptor shared_copy(std::string_view bytes) { return shared_copy({&bytes, 1}); }

/// Memory that another process has made. From now on nobody can change it or its size.
class SealedMemory {
 public:
  /// Throws std::runtime_error if another process can still write to it.
  explicit SealedMemory(Descriptor memory);
  std::size_t size() const { return size_; }
  /// Its bytes, which stay as long as this is held. Throws std::bad_alloc.
  std::shared_ptr<const char> map() const;
  /// A copy.
  std::string text() const;

 private:
  Descriptor memory_;
  std::size_t size_ = 0;
};

}  // namespace psivox::guard
