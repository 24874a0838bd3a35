#pragma once

#include <Imath/half.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <ios>
#include <istream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

// The types of grids that become a Field, and how files store their values: nodes of a .vdb as
// OpenVDB's io/Compression.h writes them since format 222.

namespace psivox::vdb {

/// What a value consists of. A bool is a byte, because a file's can have any value.
template <typename ValueT>
struct ValueTraits {
  using Number = ValueT;
  static constexpr int channels = 1;
};
template <typename NumberT>
struct ValueTraits<glm::vec<3, NumberT>> {
  using Number = NumberT;
  static constexpr int channels = 3;
};

template <typename ValueT>
constexpr bool is_bool = std::is_same_v<ValueT, std::uint8_t>;
/// Values that files can have in 16 bits a number.
template <typename ValueT>
constexpr bool is_real = std::is_floating_point_v<typename ValueTraits<ValueT>::Number>;

/// A number of a value, as float or double; `channel` is 0, or up to 2 of a vector.
template <typename To, typename ValueT>
To component_of(const ValueT& value, int channel = 0) {
  if constexpr (ValueTraits<ValueT>::channels == 3)
    return static_cast<To>(value[channel]);
  else if constexpr (is_bool<ValueT>)
    return value != 0;
  else
    return static_cast<To>(value);
}

template <typename ValueT>
glm::dvec3 to_dvec3(const ValueT& value) {
  glm::dvec3 all(0);
  for (int c = 0; c < ValueTraits<ValueT>::channels; ++c) all[c] = component_of<double>(value, c);
  return all;
}

/// The value whose numbers are all this one.
template <typename ValueT>
ValueT value_from(double number) {
  using Number = typename ValueTraits<ValueT>::Number;
  if constexpr (std::is_same_v<Number, Imath::half>)
    return Imath::half(static_cast<float>(number));
  else
    return ValueT(static_cast<Number>(number));
}

/// Whether values are equal; NaN is the same as NaN.
template <typename ValueT>
bool same_values(const ValueT& a, const ValueT& b) {
  return a == b || (!(a == a) && !(b == b));
}

/// Place of the values of a grid's type in a table; -1 if they are not supported. `grid_type` is
/// OpenVDB's, such as `Tree_float_5_4_3`. Points and masks are not in the table.
int value_type_number(std::string_view grid_type);

template <typename... ValueT>
struct ValueTypes {};

/// The types of the table, in its order.
using TableTypes = ValueTypes<float, double, Imath::half, std::int32_t, std::int64_t, std::uint8_t,
                              glm::vec3, glm::dvec3, glm::ivec3>;

/// Calls op.operator()<ValueT>() with the values of that number, which is in the table.
template <typename Op, typename First, typename... Rest>
decltype(auto) with_value_type(int number, const Op& op, ValueTypes<First, Rest...>) {
  if constexpr (sizeof...(Rest) > 0)
    if (number > 0) return with_value_type(number - 1, op, ValueTypes<Rest...>());
  return op.template operator()<First>();
}
template <typename Op>
decltype(auto) with_value_type(int number, const Op& op) {
  return with_value_type(number, op, TableTypes());
}

/// OpenVDB's type of grids with such values: float, vec3s, ...
std::string grid_type_of(std::string_view value_type);

/// Grids of points, whose voxels become the numbers of points in them; and of active voxels without
/// values, which become 1.
bool is_points(std::string_view grid_type);
bool is_mask(std::string_view grid_type);

/// The type whose topology is stored byte for byte as that of `grid_type`: int32 for points, bool
/// for masks. Other types are stored as themselves.
std::string stored_like(const std::string& grid_type);

/// Channels of a grid type: 1, 3, or 0 if it is not supported.
int channels_of(std::string_view grid_type);

/// GridInfo::value_type; empty if it is not supported.
std::string value_type_of(std::string_view grid_type);

/// Why a grid of an unsupported type cannot be rendered, as the rest of a sentence.
std::string unsupported_type(const std::string& grid_type);

/// Takes a value from a stream that has it as it is in memory.
template <typename T>
T take(std::istream& stream) {
  T value;
  stream.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

/// How a grid's nodes store their values.
struct ValueCoding {
  static constexpr std::uint32_t zip = 1, active_mask = 2, blosc = 4;

  std::uint32_t compression = 0;  ///< these flags
  bool half = false;              ///< 16 bits for each real number

  bool has_lengths() const { return compression & (zip | blosc); }
};

/// What a node stores beside its active values, by the byte that stands before them.
struct StoredKind {
  static constexpr int all_values = 6;

  int inactive = 0;       ///< how many inactive values
  bool mask = false;      ///< which inactive voxels have which
  bool all = false;       ///< all voxels' values in place of the active ones'
  bool opposite = false;  ///< the first inactive value, unless it is stored: the background's
                          ///< opposite in place of the background

  explicit StoredKind(int kind)
      : inactive(kind == 5                ? 2
                 : kind == 2 || kind == 4 ? 1
                                          : 0),
        mask(kind >= 3 && kind <= 5),
        all(kind == all_values),
        opposite(kind != 0) {}
};

/// Decompresses what Blosc or zlib has made of `size` bytes. Throws std::runtime_error if it is not
/// that.
void expand_blosc(std::string_view stored, char* to, std::size_t size);
void expand_zip(std::string_view stored, char* to, std::size_t size);

/// Reads a block of `size` bytes, which may be compressed. Throws if it cannot hold as many.
void read_block(std::istream& stream, char* to, std::int64_t size, const ValueCoding& coding);
/// Moves the stream behind it in place of reading.
void skip_block(std::istream& stream, std::int64_t size, const ValueCoding& coding);

/// Bytes of so many values of a block that is not compressed.
template <typename ValueT>
std::int64_t bytes_of_values(std::size_t count, const ValueCoding& coding) {
  const bool half = coding.half && is_real<ValueT>;
  return static_cast<std::int64_t>(
      count *
      (half ? 2 * static_cast<std::size_t>(ValueTraits<ValueT>::channels) : sizeof(ValueT)));
}

/// Whether a block of so many values is not even there.
template <typename ValueT>
bool leaves_out(std::size_t count, const ValueCoding& coding) {
  return count == 0 && coding.half && is_real<ValueT>;
}

template <typename ValueT>
void read_numbers(std::istream& stream, ValueT* to, std::size_t count, const ValueCoding& coding) {
  if (leaves_out<ValueT>(count, coding)) return;
  const std::int64_t bytes = bytes_of_values<ValueT>(count, coding);
  if constexpr (is_real<ValueT>) {
    if (coding.half) {
      constexpr auto channels = static_cast<std::size_t>(ValueTraits<ValueT>::channels);
      const auto halves = std::make_unique_for_overwrite<Imath::half[]>(count * channels);
      read_block(stream, reinterpret_cast<char*>(halves.get()), bytes, coding);
      auto* number = reinterpret_cast<typename ValueTraits<ValueT>::Number*>(to);
      for (std::size_t i = 0; i < count * channels; ++i) number[i] = float(halves[i]);
      return;
    }
  }
  read_block(stream, reinterpret_cast<char*>(to), bytes, coding);
}

/// -value without overflow; a bool becomes the other.
template <typename ValueT>
ValueT opposite(const ValueT& value) {
  using Number = typename ValueTraits<ValueT>::Number;
  if constexpr (is_bool<ValueT>)
    return value == 0;
  else if constexpr (std::is_integral_v<Number> && ValueTraits<ValueT>::channels == 1)
    return ValueT(0 - std::make_unsigned_t<Number>(value));
  else if constexpr (std::is_integral_v<Number>)
    return ValueT(glm::uvec3(0) - glm::uvec3(value));
  else
    return -value;
}

/// Reads the values of a node. `active` is its mask of active values, `to` takes as many as that
/// has bits. Throws if a length is impossible or the stream ends.
template <typename ValueT, typename MaskT>
void read_values(std::istream& stream, const MaskT& active, const ValueT& background,
                 const ValueCoding& coding, ValueT* to) {
  const StoredKind kind(stream.get());
  std::array<ValueT, 2> inactive{kind.opposite ? opposite(background) : background, background};
  for (int n = 0; n < kind.inactive; ++n) inactive[std::size_t(n)] = take<ValueT>(stream);
  MaskT has_second;
  if (kind.mask) has_second.load(stream);
  const bool all = kind.all || !(coding.compression & ValueCoding::active_mask);
  std::size_t stored = all ? MaskT::SIZE : active.countOn();
  read_numbers(stream, to, stored, coding);
  if (stored == MaskT::SIZE) return;
  // spreads the active values from the last on, in place
  for (unsigned n = MaskT::SIZE; n-- > 0;)
    to[n] = active.isOn(n) ? to[--stored] : inactive[has_second.isOn(n)];
}

/// Moves the stream behind them in place of reading. `active`: how many there are.
template <typename ValueT, typename MaskT>
void skip_values(std::istream& stream, std::size_t active, const ValueCoding& coding) {
  const StoredKind kind(stream.get());
  const auto before = kind.inactive * static_cast<std::int64_t>(sizeof(ValueT)) +
                      (kind.mask ? static_cast<std::int64_t>(sizeof(MaskT)) : 0);
  if (before > 0) stream.seekg(before, std::ios_base::cur);
  const bool all = kind.all || !(coding.compression & ValueCoding::active_mask);
  const std::size_t count = all ? MaskT::SIZE : active;
  if (!leaves_out<ValueT>(count, coding))
    skip_block(stream, bytes_of_values<ValueT>(count, coding), coding);
}

}  // namespace psivox::vdb
