#pragma once

#include <Imath/half.h>

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <type_traits>

// The types of grids that become a Field, and their values as files have them.

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

/// Calls op.operator()<ValueT>() with the values of that number, which is in the table.
template <typename Op>
decltype(auto) with_value_type(int number, Op&& op) {
  switch (number) {
    case 1:
      return op.template operator()<double>();
    case 2:
      return op.template operator()<Imath::half>();
    case 3:
      return op.template operator()<std::int32_t>();
    case 4:
      return op.template operator()<std::int64_t>();
    case 5:
      return op.template operator()<std::uint8_t>();
    case 6:
      return op.template operator()<glm::vec3>();
    case 7:
      return op.template operator()<glm::dvec3>();
    case 8:
      return op.template operator()<glm::ivec3>();
    default:
      return op.template operator()<float>();
  }
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

}  // namespace psivox::vdb
