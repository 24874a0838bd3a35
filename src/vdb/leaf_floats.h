#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <type_traits>

#include "sanitise.h"

namespace psivox::vdb {

template <typename ValueT>
constexpr bool is_vec = openvdb::VecTraits<ValueT>::IsVec;

template <typename ValueT>
glm::vec3 to_vec3(const ValueT& value) {
  if constexpr (is_vec<ValueT>) {
    return {static_cast<float>(value[0]), static_cast<float>(value[1]),
            static_cast<float>(value[2])};
  } else {
    return {static_cast<float>(value), 0.0f, 0.0f};
  }
}

/// Copies a leaf's 512 values, as floats; vectors interleaved.
template <typename LeafT>
void convert_leaf(const LeafT& leaf, float* values) {
  using ValueT = typename LeafT::ValueType;
  if constexpr (std::is_same_v<ValueT, bool>) {
    for (openvdb::Index i = 0; i < kLeafVoxels; ++i) values[i] = leaf.getValue(i) ? 1.0f : 0.0f;
  } else if constexpr (is_vec<ValueT>) {
    const ValueT* from = leaf.buffer().data();
    for (std::size_t i = 0; i < kLeafVoxels; ++i) {
      for (int c = 0; c < 3; ++c) *values++ = static_cast<float>(from[i][c]);
    }
  } else {
    const ValueT* from = leaf.buffer().data();
    for (std::size_t i = 0; i < kLeafVoxels; ++i) values[i] = static_cast<float>(from[i]);
  }
}

}  // namespace psivox::vdb
