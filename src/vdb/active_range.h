#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>
#include <limits>
#include <vector>

#include "grid_types.h"

namespace psivox::vdb {

/// Least and greatest of the first channel of a grid's active voxels and tiles. `leaves` are the
/// leaves' values as floats, in the tree's order, without NaN and Inf; tiles of such are left out.
template <typename GridT>
glm::vec2 active_range(const GridT& grid, const std::vector<float*>& leaves, int channels) {
  using ValueT = typename GridT::ValueType;
  using LeafT = typename GridT::TreeType::LeafNodeType;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto include = [](glm::vec2 range, float value) {
    return glm::vec2(std::min(range.x, value), std::max(range.y, value));
  };

  std::vector<const LeafT*> nodes;
  grid.tree().getNodes(nodes);
  glm::vec2 range = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, nodes.size(), 64), glm::vec2(infinity, -infinity),
      [&](const tbb::blocked_range<std::size_t>& part, glm::vec2 sub_range) {
        for (std::size_t n = part.begin(); n != part.end(); ++n) {
          for (auto on = nodes[n]->getValueMask().beginOn(); on; ++on)
            sub_range =
                include(sub_range, leaves[n][on.pos() * static_cast<openvdb::Index>(channels)]);
        }
        return sub_range;
      },
      [](glm::vec2 a, glm::vec2 b) { return glm::vec2(std::min(a.x, b.x), std::max(a.y, b.y)); });
  auto tile = grid.tree().cbeginValueOn();
  tile.setMaxDepth(GridT::TreeType::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    float value = 0;
    if constexpr (openvdb::VecTraits<ValueT>::IsVec)
      value = static_cast<float>(tile.getValue()[0]);
    else
      value = static_cast<float>(tile.getValue());
    if (std::isfinite(value)) range = include(range, value);
  }
  return range;
}

}  // namespace psivox::vdb
