#pragma once

#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <type_traits>

// Values of any grid, of OpenVDB's types and of NanoVDB's, as floats and doubles.

namespace psivox::vdb {

template <typename ValueT>
constexpr int channels_of_value = requires(const ValueT& v) {
  v[0];
}
? 3 : 1;

/// A number of a value, as float or double; `channel` is 0, or up to 2 of a vector.
template <typename To, typename ValueT>
To component_of(const ValueT& value, int channel) {
  if constexpr (channels_of_value<ValueT> == 3)
    return static_cast<To>(value[channel]);
  else if constexpr (std::is_arithmetic_v<ValueT>)
    return static_cast<To>(value);
  else if constexpr (std::is_same_v<ValueT, openvdb::math::half>)
    return static_cast<To>(static_cast<float>(value));
  else
    return static_cast<To>(static_cast<openvdb::Index32>(value));  // points
}

template <typename ValueT>
glm::dvec3 to_dvec3(const ValueT& value) {
  glm::dvec3 all(0);
  for (int c = 0; c < channels_of_value<ValueT>; ++c) all[c] = component_of<double>(value, c);
  return all;
}

/// Whether values are equal; NaN is the same as NaN.
template <typename ValueT>
bool same_values(const ValueT& a, const ValueT& b) {
  return a == b || (!(a == a) && !(b == b));
}

/// What a value consists of.
template <typename ValueT>
auto number_of(const ValueT& value) {
  if constexpr (channels_of_value<ValueT> == 3)
    return value[0];
  else if constexpr (std::is_same_v<ValueT, openvdb::math::half>)
    return static_cast<float>(value);
  else if constexpr (std::is_arithmetic_v<ValueT>)
    return value;
  else
    return std::int32_t{};  // points
}

/// The value whose numbers are all this one.
template <typename ValueT>
ValueT value_from(double number) {
  return ValueT(static_cast<decltype(number_of(ValueT()))>(number));
}

/// Whether a value can consist of this number.
template <typename ValueT>
bool value_can_be(double number) {
  using Limits = std::numeric_limits<decltype(number_of(ValueT()))>;
  // 2^63 is no int64, but the nearest double of the greatest.
  const bool within = number >= double(Limits::lowest()) && number < double(Limits::max()) + 1;
  return within && (!Limits::is_integer || number == std::trunc(number));
}

}  // namespace psivox::vdb
