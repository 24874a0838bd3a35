#pragma once

#include <cstdint>
#include <cstring>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace psivox::guard {

/// What is copied byte by byte.
template <typename T>
concept Plain =
    (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_same_v<T, glm::vec2> ||
    std::is_same_v<T, glm::vec3> || std::is_same_v<T, glm::ivec3> ||
    std::is_same_v<T, glm::dvec3> || std::is_same_v<T, glm::dmat4>;

/// Lists a struct's members once, for both directions, in the struct's namespace. A structured
/// binding names all of them, so that a new one does not compile until it is listed.
#define PSIVOX_PACK(Struct, ...)                               \
  inline void describe(guard::Codec& codec_, Struct& value_) { \
    auto& [__VA_ARGS__] = value_;                              \
    codec_(__VA_ARGS__);                                       \
  }

/// Writes values to a text of bytes, or reads them from it in the same order. Reading throws
/// std::runtime_error if the text cannot be that: it may come from a process that a file has taken
/// over.
class Codec {
 public:
  Codec() : writes_(true) {}
  explicit Codec(std::string_view text) : rest_(text) {}

  template <typename... T>
  void operator()(T&... values) {
    (code(values), ...);
  }
  const std::string& written() const { return written_; }
  void end() const { require(rest_.empty()); }

 private:
  static void require(bool holds) {
    if (!holds) throw std::runtime_error("a message is malformed");
  }
  void bytes(void* at, std::size_t size) {
    if (writes_) {
      written_.append(static_cast<const char*>(at), size);
    } else if (size > 0) {
      require(size <= rest_.size());
      std::memcpy(at, rest_.data(), size);
      rest_.remove_prefix(size);
    }
  }
  /// A number of items, each of which takes a byte or more.
  std::uint64_t count(std::uint64_t n) {
    bytes(&n, sizeof n);
    require(writes_ || n <= rest_.size());
    return n;
  }
  template <Plain T>
  void code(T& value) {
    bytes(&value, sizeof value);
  }
  template <typename T>
  requires std::is_enum_v<T>  // its last value is called `data`
  void code(T& value) {
    auto number = static_cast<std::underlying_type_t<T>>(value);
    code(number);
    require(number >= 0 && number <= static_cast<decltype(number)>(T::data));
    if (!writes_) value = static_cast<T>(number);
  }
  void code(bool& value) {
    char c = value;
    code(c);
    require(c == 0 || c == 1);
    if (!writes_) value = c == 1;
  }
  void code(std::string& value) {
    const std::uint64_t size = count(value.size());
    if (!writes_) value.resize(size);
    bytes(value.data(), size);
  }
  template <typename T>
  void code(std::optional<T>& value) {
    bool there = value.has_value();
    code(there);
    if (!writes_) value.reset();
    if (there) code(writes_ ? *value : value.emplace());
  }
  template <typename T>
  void code(std::vector<T>& values) {
    const std::uint64_t n = count(values.size());
    if constexpr (Plain<T>) {
      require(writes_ || n <= rest_.size() / sizeof(T));
      values.resize(n);
      bytes(values.data(), n * sizeof(T));
      return;
    }
    if (!writes_) values.clear();
    for (std::uint64_t i = 0; i < n; ++i) code(writes_ ? values[i] : values.emplace_back());
  }
  template <typename K, typename V>
  void code(std::map<K, V>& values) {
    std::uint64_t n = count(values.size());
    if (!writes_) values.clear();
    auto next = values.begin();
    for (; n > 0; --n) {
      K key = writes_ ? next->first : K{};
      code(key);
      code(writes_ ? (next++)->second : values[key]);
    }
  }
  template <typename T>
  requires requires(Codec& codec, T& value) { describe(codec, value); }
  void code(T& value) { describe(*this, value); }

  bool writes_ = false;
  std::string written_;
  std::string_view rest_;
};

/// The text of some values.
template <typename... T>
std::string packed(const T&... values) {
  Codec codec;
  codec(const_cast<T&>(values)...);  // which it does not change
  return codec.written();
}

/// Reads a whole text into values. Throws std::runtime_error if it cannot be theirs.
template <typename... T>
void unpack(std::string_view text, T&... values) {
  Codec codec(text);
  codec(values...);
  codec.end();
}

}  // namespace psivox::guard
