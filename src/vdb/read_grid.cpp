#include "read_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <functional>
#include <memory>
#include <sstream>
#include <type_traits>
#include <utility>

#include "active_range.h"
#include "conform.h"
#include "grid_check.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "sanitise.h"

namespace psivox::vdb {
namespace {

template <typename ValueT>
constexpr bool is_vec = openvdb::VecTraits<ValueT>::IsVec;

/// Values that are floats in memory already: their leaves need no copy.
template <typename ValueT>
constexpr bool is_float = std::is_same_v<ValueT, float> || std::is_same_v<ValueT, openvdb::Vec3f>;

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

glm::ivec3 to_ivec3(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

/// Fills field.leaves and field.storage; returns the same leaves for sanitise to change.
template <typename GridT>
std::vector<float*> extract_leaves(const std::shared_ptr<GridT>& grid, Field& field) {
  using ValueT = typename GridT::ValueType;
  using LeafT = typename GridT::TreeType::LeafNodeType;
  std::vector<LeafT*> nodes;
  grid->tree().getNodes(nodes);
  const std::size_t leaf_floats = kLeafVoxels * static_cast<std::size_t>(field.channels);

  std::shared_ptr<float[]> converted;
  if constexpr (is_float<ValueT>) {
    field.storage = grid;
  } else {
    converted = std::make_shared_for_overwrite<float[]>(nodes.size() * leaf_floats);
    field.storage = converted;
  }
  field.leaves.resize(nodes.size());
  std::vector<float*> leaves(nodes.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, nodes.size(), 64), [&](const auto& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      if constexpr (std::is_same_v<ValueT, float>) {
        leaves[n] = nodes[n]->buffer().data();
      } else if constexpr (is_float<ValueT>) {
        leaves[n] = nodes[n]->buffer().data()->asPointer();
      } else {
        leaves[n] = converted.get() + n * leaf_floats;
        convert_leaf(*nodes[n], leaves[n]);
      }
      field.leaves[n] = {to_ivec3(nodes[n]->origin()), leaves[n]};
    }
  });
  return leaves;
}

/// Appends the tiles of a node (values of it that are no child) that are not 0, active or not.
template <typename NodeT>
void append_tiles(const NodeT& node, int width, std::vector<Tile>& tiles) {
  for (auto it = node.cbeginValueAll(); it; ++it) {
    const glm::vec3 value = to_vec3(it.getValue());
    if (value != glm::vec3(0.0f)) tiles.push_back({to_ivec3(it.getCoord()), width, value});
  }
}

template <typename TreeT>
std::vector<Tile> extract_tiles(const TreeT& tree) {
  using RootT = typename TreeT::RootNodeType;
  using UpperT = typename RootT::ChildNodeType;
  using LowerT = typename UpperT::ChildNodeType;
  std::vector<Tile> tiles;
  append_tiles(tree.root(), UpperT::DIM, tiles);
  std::vector<const UpperT*> upper;
  tree.getNodes(upper);
  for (const UpperT* node : upper) append_tiles(*node, LowerT::DIM, tiles);
  std::vector<const LowerT*> lower;
  tree.getNodes(lower);
  for (const LowerT* node : lower) append_tiles(*node, TreeT::LeafNodeType::DIM, tiles);
  return tiles;
}

/// Throws if the grid cannot be rendered.
GridSummary checked(const openvdb::GridBase& grid, const std::string& subject) {
  GridSummary summary = summarise(grid);
  const std::string problem = problem_of(grid, summary);
  if (!problem.empty()) throw Error(ExitCode::input, subject + problem);
  return summary;
}

}  // namespace

Field field_from_grid(openvdb::GridBase::Ptr grid, const std::string& name,
                      const std::string& subject, const ReadOptions& options) {
  GridSummary summary = checked(*grid, subject);
  Field field;
  field.name = name;
  field.value_type = value_type_of(grid->type());
  field.channels = summary.channels;
  const auto notice = [&](const std::string& text) {
    field.notices.push_back("grid '" + name + "': " + text);
  };

  if (is_level_set(*grid)) {
    if (options.distances) {
      field.half_width = summary.background[0];
      grid = distances_from_level_set(grid);
      std::ostringstream text;
      text << "level set kept as distances, which it has within " << field.half_width
           << " [world units] of its surface";
      notice(text.str());
    } else {
      grid = fog_from_level_set(grid);
      notice("level set converted to fog: 0 at its surface, 1 at the depth of its narrow band");
    }
    summary = summarise(*grid);
    if (summary.active_voxels == 0) {
      throw Error(ExitCode::input, subject + "is a level set without an inside: nothing to render");
    }
  }
  if (!grid->transform().isLinear()) {
    if (options.strict) {
      throw Error(ExitCode::input, subject +
                                       "has a frustum transform, which strict reading does"
                                       " not resample; resample it where the file is made");
    }
    std::string done;
    try {
      grid = resample_to_linear(grid, done);
    } catch (const std::exception& e) {
      throw Error(ExitCode::input, subject + e.what());
    }
    notice(done);
    summary = checked(*grid, subject);
  }

  field.active_box = summary.active_box;
  field.active_voxels = summary.active_voxels;
  field.world_from_index = world_from_index(grid->transform());
  std::vector<float*> leaves;
  std::function<glm::vec2()> range;
  const openvdb::GridBase::Ptr base = std::move(grid);
  with_typed_grid(*base, [&](const auto& typed) {
    using GridT = std::decay_t<decltype(typed)>;
    field.tiles = extract_tiles(typed.tree());
    leaves = extract_leaves(openvdb::gridPtrCast<GridT>(base), field);
    range = [&] { return active_range(typed, leaves, field.channels); };
  });

  const BadValues bad = sanitise(leaves, field.tiles, field.channels, options.role);
  if (bad.any()) {
    if (options.strict) {
      throw Error(ExitCode::input, subject + "is refused by strict reading: " + bad.describe());
    }
    notice(bad.describe());
    std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  }
  if (options.role == GridRole::data) field.active_range = range();
  return field;
}

}  // namespace psivox::vdb
