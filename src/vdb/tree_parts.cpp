#include "tree_parts.h"

#include "psivox/value_percentile.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <type_traits>

#include "grid_types.h"
#include "leaf_floats.h"
#include "tree_nodes.h"

namespace psivox::vdb {
namespace {

/// Types whose values are floats in memory; their leaves need no copy.
template <typename ValueT>
constexpr bool is_float = std::is_same_v<ValueT, float> || std::is_same_v<ValueT, openvdb::Vec3f>;

/// Points parts.leaves to the values in place.
template <typename LeafT>
void take_in_place(const std::vector<LeafT*>& nodes, TreeParts& parts) {
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if constexpr (is_vec<typename LeafT::ValueType>)
      parts.leaves[n] = nodes[n]->buffer().data()->asPointer();
    else
      parts.leaves[n] = nodes[n]->buffer().data();
  }
}

/// Points parts.leaves to new floats; convert(n, values) writes those of leaf n.
void take_converted(const std::function<void(std::size_t, float*)>& convert, TreeParts& parts) {
  const std::size_t length = kLeafVoxels * static_cast<std::size_t>(parts.channels);
  const auto values = std::make_shared_for_overwrite<float[]>(parts.leaves.size() * length);
  parts.storage = values;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, parts.leaves.size(), 64),
                    [&](const auto& range) {
                      for (std::size_t n = range.begin(); n != range.end(); ++n) {
                        parts.leaves[n] = values.get() + n * length;
                        convert(n, parts.leaves[n]);
                      }
                    });
}

/// All but the values of leaves. `active`: active tiles alone, of value 1.
template <typename GridT>
void take_places(GridT& grid, bool active, TreeParts& parts) {
  const TreeNodes<typename GridT::TreeType> nodes(grid.tree());
  const auto background = grid.background();
  nodes.for_each_with_tiles([&](const auto& node, int width) {
    for (auto it = node.cbeginValueAll(); it; ++it) {
      const auto value = it.getValue();
      if (it.isValueOn() || (!active && value != background))
        parts.tiles.push_back(
            {{to_ivec3(it.getCoord()), width, active ? glm::vec3(1, 0, 0) : to_vec3(value)},
             it.isValueOn()});
    }
  });
  parts.origins.reserve(nodes.leaves.size());
  parts.active.reserve(nodes.leaves.size());
  for (const auto* leaf : nodes.leaves) {
    parts.origins.push_back(leaf->origin());
    parts.active.push_back(&leaf->getValueMask());
  }
  parts.channels = is_vec<typename GridT::ValueType> && !active ? 3 : 1;
  parts.leaves.resize(nodes.leaves.size());
}

template <typename GridT>
void take_parts(GridT& grid, TreeParts& parts) {
  using ValueT = typename GridT::ValueType;
  take_places(grid, false, parts);
  const TreeNodes<typename GridT::TreeType> nodes(grid.tree());
  if constexpr (is_float<ValueT>)
    take_in_place(nodes.leaves, parts);
  else
    take_converted([&](std::size_t n, float* to) { convert_leaf(*nodes.leaves[n], to); }, parts);
}

}  // namespace

TreeParts parts_of(const openvdb::GridBase::Ptr& grid) {
  TreeParts parts;
  parts.storage = grid;
  grid->apply<SupportedGrids>([&](auto& typed) { take_parts(typed, parts); });
  return parts;
}

TreeParts active_parts_of(const openvdb::GridBase::Ptr& grid) {
  TreeParts parts;
  grid->apply<SupportedGrids>([&](auto& typed) { take_places(typed, true, parts); });
  take_converted(
      [&](std::size_t n, float* to) {
        for (openvdb::Index i = 0; i < kLeafVoxels; ++i) to[i] = parts.active[n]->isOn(i) ? 1 : 0;
      },
      parts);
  return parts;
}

glm::vec2 active_range(const TreeParts& parts) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto include = [](glm::vec2 range, float value) {
    return glm::vec2(std::min(range.x, value), std::max(range.y, value));
  };
  const auto channels = static_cast<openvdb::Index>(parts.channels);
  glm::vec2 range = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, parts.leaves.size(), 64), glm::vec2(infinity, -infinity),
      [&](const tbb::blocked_range<std::size_t>& part, glm::vec2 sub_range) {
        for (std::size_t n = part.begin(); n != part.end(); ++n) {
          for (auto on = parts.active[n]->beginOn(); on; ++on)
            sub_range = include(sub_range, parts.leaves[n][on.pos() * channels]);
        }
        return sub_range;
      },
      [](glm::vec2 a, glm::vec2 b) { return glm::vec2(std::min(a.x, b.x), std::max(a.y, b.y)); });
  for (const TilePart& part : parts.tiles) {
    const float value = part.tile.value.x;
    if (part.active && std::isfinite(value)) range = include(range, value);
  }
  return range;
}

std::map<double, double> active_percentiles(const TreeParts& parts,
                                            std::span<const double> percents) {
  const auto channels = static_cast<openvdb::Index>(parts.channels);
  const std::vector<double> values = value_percentiles(
      [&](const auto& take) {
        for (std::size_t n = 0; n < parts.leaves.size(); ++n)
          for (auto on = parts.active[n]->beginOn(); on; ++on)
            take(parts.leaves[n][on.pos() * channels], 1);
        for (const TilePart& part : parts.tiles)
          if (part.active) take(part.tile.value.x, tile_voxels(part.tile));
      },
      percents);
  std::map<double, double> found;
  for (std::size_t i = 0; i < values.size(); ++i) found[percents[i]] = values[i];
  return found;
}

}  // namespace psivox::vdb
