#include "vdb/joined_vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string_view>
#include <unordered_set>

#include "base/text.h"
#include "field/field_index.h"
#include "field/index_space.h"

namespace psivox::vdb {
namespace {

/// Where all three are stored, as tiles or in blocks of 8^3 voxels.
struct Places {
  std::vector<Tile> tiles{};
  std::unordered_set<glm::ivec3, VoxelHash> blocks{};
};

/// Blocks of tiles that are not the same cubes in all three.
constexpr std::size_t most_blocks = std::size_t{1} << 20;

using Indices = std::array<FieldIndex, 3>;

Places places_of(const std::array<Field, 3>& components, const Indices& indices,
                 const std::string& name) {
  Places places;
  for (const Field& field : components) {
    for (const Leaf& leaf : field.leaves) places.blocks.insert(leaf.origin);
    for (const Tile& tile : field.tiles) {
      const Box box{tile.origin, tile.origin + (tile.width - 1)};
      bool same = true;
      glm::vec3 value;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto [voxels, block] = indices[c].cube(tile.origin);
        same = same && block.stored && block.is_constant() && voxels == box;
        value[int(c)] = block.values.channel(0);
      }
      if (same && &field == components.data())
        places.tiles.push_back({tile.origin, tile.width, value});
      if (same) continue;
      for_points({box.min >> 3, box.max >> 3},
                 [&](const glm::ivec3& block) { places.blocks.insert(8 * block); });
      if (places.blocks.size() > most_blocks)
        throw Error(ExitCode::memory, "grid " + in_quotes(name) +
                                          ": its components have too many tiles of their own; "
                                          "draw one of them");
    }
  }
  return places;
}

/// Sets the lattice of the components.
void place(const std::array<Field, 3>& components, Field& joined) {
  glm::dvec4 middle(0);
  bool shifted = false;
  for (const Field& field : components) {
    const glm::dmat4 to_first =
        glm::inverse(components[0].world_from_index) * field.world_from_index;
    constexpr double rounding = 1e-6;
    const glm::dvec3 shift(to_first[3]);
    for (int c = 0; c < 3; ++c) {
      glm::dvec3 axis(0);
      axis[c] = 1;
      if (!(glm::length(glm::dvec3(to_first[c]) - axis) < rounding) || !(glm::length(shift) < 1))
        throw Error(ExitCode::input, "grid " + in_quotes(joined.name) +
                                         ": its components lie on different lattices; draw one of "
                                         "them");
    }
    shifted |= glm::length(shift) > rounding;
    middle += field.world_from_index[3] / 3.0;
  }
  joined.world_from_index = components[0].world_from_index;
  joined.world_from_index[3] = middle;
  if (shifted)
    joined.notices.push_back("grid " + in_quotes(joined.name) +
                             ": its components are staggered; they are drawn in their middle");
}

/// The name of the vector that `vel.x` is a component of: `vel`.
std::string without_component(std::string_view name) {
  std::string_view base = name.substr(0, name.size() - 1);
  while (!base.empty() && std::string_view("._:- ").find(base.back()) != base.npos)
    base.remove_suffix(1);
  return std::string(base);
}

}  // namespace

std::map<std::string, Components> vectors_of(const std::vector<GridFacts>& grids) {
  const auto is_scalar = [&](const std::string& name) {
    const auto found = std::ranges::find(grids, name, &GridFacts::name);
    return found != grids.end() && found->channels == 1;
  };
  std::map<std::string, Components> vectors;
  for (const GridFacts& grid : grids) {
    if (grid.name.size() < 2 || (grid.name.back() != 'x' && grid.name.back() != 'X')) continue;
    Components names;
    for (std::size_t c = 0; c < 3; ++c) {
      names[c] = grid.name;
      names[c].back() = char(grid.name.back() + int(c));
    }
    const std::string vector = without_component(grid.name);
    if (vector.empty() || std::ranges::count(grids, vector, &GridFacts::name) > 0) continue;
    if (std::ranges::all_of(names, is_scalar)) vectors[vector] = names;
  }
  return vectors;
}

Field joined_vectors(const std::string& name, const std::array<Field, 3>& components) {
  Field joined;
  joined.name = name;
  joined.value_type = "vec3s";
  joined.channels = 3;
  for (const Field& field : components) {
    joined.active_voxels = std::max(joined.active_voxels, field.active_voxels);
    joined.replaced = joined.replaced + field.replaced;
    joined.notices.insert(joined.notices.end(), field.notices.begin(), field.notices.end());
    if (field.active_voxels == 0) continue;
    const Box& box = field.active_box;
    joined.active_box = joined.active_box.empty() ? box
                                                  : Box{glm::min(joined.active_box.min, box.min),
                                                        glm::max(joined.active_box.max, box.max)};
  }
  place(components, joined);
  const Indices indices{FieldIndex(components[0]), FieldIndex(components[1]),
                        FieldIndex(components[2])};
  Places places = places_of(components, indices, name);
  joined.tiles = std::move(places.tiles);
  for (const glm::ivec3& origin : places.blocks) joined.leaves.push_back({origin, nullptr});
  std::ranges::sort(joined.leaves, comes_before, &Leaf::origin);
  fill_leaves(joined, [&](std::size_t n, float* to) {
    for (std::size_t c = 0; c < 3; ++c) {
      const FieldIndex::Block block = indices[c].block(joined.leaves[n].origin);
      for (int i = 0; i < 512; ++i) to[3 * std::size_t(i) + c] = block.value(i);
    }
  });
  return joined;
}

}  // namespace psivox::vdb
