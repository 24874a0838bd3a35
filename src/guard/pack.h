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
#include <utility>
#include <variant>
#include <vector>

namespace psivox::guard {

template <typename T>
concept Number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
template <typename T>
concept Tuple = std::is_same_v<T, glm::vec2> || std::is_same_v<T, glm::vec3> ||
    std::is_same_v<T, glm::ivec3> || std::is_same_v<T, glm::dvec3> || std::is_same_v<T, glm::dmat4>;
template <typename T, typename Struct>
concept Is = std::is_same_v<std::remove_const_t<T>, Struct>;

/// Lists a struct's members once, for both directions, in the struct's namespace. A structured
/// binding names all of them, so that a new one does not compile until it is listed.
#define PSIVOX_PACK(Struct, ...)                \
  template <typename Pack, guard::Is<Struct> T> \
  void describe(Pack& pack_, T& value_) {       \
    auto& [__VA_ARGS__] = value_;               \
    pack_(__VA_ARGS__);                         \
  }

/// Appends values to a text of bytes, for an Unpacker of the same program.
class Packer {
 public:
  template <typename... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  const std::string& text() const { return text_; }

 private:
  template <typename T>
  requires Number<T> || Tuple<T> || std::is_enum_v<T>
  void put(const T& value) { text_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void put(bool value) { put(static_cast<char>(value)); }
  void put(const std::string& value) {
    put(std::uint64_t{value.size()});
    text_ += value;
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t{values.size()});
    for (const T& value : values) put(value);
  }
  template <typename K, typename V>
  void put(const std::map<K, V>& values) {
    put(std::uint64_t{values.size()});
    for (const auto& [key, value] : values) (*this)(key, value);
  }
  template <typename... T>
  void put(const std::variant<T...>& value) {
    put(std::uint64_t{value.index()});
    std::visit([&](const auto& held) { put(held); }, value);
  }
  template <typename T>
  requires requires(Packer& p, const T& value) { describe(p, value); }
  void put(const T& value) { describe(*this, value); }

  std::string text_;
};

/// Takes values from what a Packer has written, in the same order. Throws std::runtime_error if the
/// text cannot be that: it may come from a process that a file has taken over.
class Unpacker {
 public:
  explicit Unpacker(std::string_view text) : text_(text) {}

  template <typename... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  void end() const { require(text_.empty()); }

 private:
  static void require(bool holds) {
    if (!holds) throw std::runtime_error("a message is malformed");
  }
  std::string_view bytes(std::uint64_t count) {
    require(count <= text_.size());
    const std::string_view taken = text_.substr(0, count);
    text_.remove_prefix(count);
    return taken;
  }
  /// A number of items, each of which takes a byte or more.
  std::uint64_t count() {
    std::uint64_t n = 0;
    get(n);
    require(n <= text_.size());
    return n;
  }
  template <typename T>
  requires Number<T> || Tuple<T>
  void get(T& value) { std::memcpy(&value, bytes(sizeof value).data(), sizeof value); }
  template <typename T>
  requires std::is_enum_v<T>  // its last value is called `data`
  void get(T& value) {
    std::underlying_type_t<T> number{};
    get(number);
    require(number >= 0 && number <= static_cast<std::underlying_type_t<T>>(T::data));
    value = static_cast<T>(number);
  }
  void get(bool& value) {
    char c = 0;
    get(c);
    require(c == 0 || c == 1);
    value = c == 1;
  }
  void get(std::string& value) { value = bytes(count()); }
  template <typename T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    value.reset();
    if (there) get(value.emplace());
  }
  template <typename T>
  void get(std::vector<T>& values) {
    values.clear();
    for (std::uint64_t n = count(); n > 0; --n) get(values.emplace_back());
  }
  template <typename K, typename V>
  void get(std::map<K, V>& values) {
    values.clear();
    for (std::uint64_t n = count(); n > 0; --n) {
      K key{};
      get(key);
      get(values[key]);
    }
  }
  template <typename... T>
  void get(std::variant<T...>& value) {
    std::uint64_t index = 0;
    get(index);
    require(index < sizeof...(T));
    std::uint64_t n = 0;
    ((n++ == index ? get(value.template emplace<T>()) : void()), ...);
  }
  template <typename T>
  requires requires(Unpacker& u, T& value) { describe(u, value); }
  void get(T& value) { describe(*this, value); }

  std::string_view text_;
};

}  // namespace psivox::guard
