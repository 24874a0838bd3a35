#include "medium/map_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <memory>
#include <unordered_set>

#include "base/text.h"
#include "field/field_cursor.h"
#include "field/field_index.h"
#include "field/index_space.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr std::size_t most_blocks = std::size_t{1} << 24;

void check_blocks(const Field& field, std::size_t blocks) {
  if (blocks > most_blocks)
    throw Error(ExitCode::memory, "grid " + in_quotes(field.name) + " has gradients in more than " +
                                      std::to_string(most_blocks) +
                                      " blocks of 8^3 voxels; a coarser grid has fewer");
}

/// Origins of blocks in which neighbouring voxels may differ, sorted by coordinates: leaves, the
/// outermost blocks of tiles, and the blocks behind a face of either.
std::vector<glm::ivec3> candidate_blocks(const Field& field) {
  const Box domain = field.domain();
  const Box origins{domain.min & ~7, domain.max & ~7};
  std::unordered_set<glm::ivec3, VoxelHash> blocks;
  blocks.reserve(field.leaves.size() * 3 / 2);
  const auto add = [&](const glm::ivec3& origin) {
    if (!origins.contains(origin)) return;
    blocks.insert(origin);
    check_blocks(field, blocks.size());
  };
  // both sides of the faces of a cube
  const auto add_faces = [&](const glm::ivec3& origin, int width) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int at : {-8, 0, width - 8, width})
        for (int u = 0; u < width; u += 8)
          for (int v = 0; v < width; v += 8) {
            glm::ivec3 block = origin;
            block[axis] += at;
            block[(axis + 1) % 3] += u;
            block[(axis + 2) % 3] += v;
            add(block);
          }
  };
  for (const Leaf& leaf : field.leaves) add_faces(leaf.origin, 8);
  for (const Tile& tile : field.tiles) add_faces(tile.origin, tile.width);
  std::vector<glm::ivec3> sorted(blocks.begin(), blocks.end());
  std::ranges::sort(sorted, comes_before);
  return sorted;
}

/// Computes the 512 magnitudes of a block. Returns whether one is not 0. Beside `known` there is no
/// value, nor where a voxel is absent: differences there are one-sided.
bool compute_block(FieldCursor values, const glm::dmat3& normal, const glm::ivec3& origin,
                   const Box& known, float* to) {
  bool any = false;
  for (int i = 0; i < 512; ++i) {
    const glm::ivec3 voxel = origin + leaf_voxel(i);
    const double here = values.at(voxel);
    glm::dvec3 difference(0);
    for (int axis = 0; axis < 3 && known.contains(voxel) && !std::isnan(here); ++axis) {
      glm::ivec3 before = voxel, behind = voxel;
      --before[axis];
      ++behind[axis];
      const double low = values.at(before), high = values.at(behind);
      const bool has_low = voxel[axis] != known.min[axis] && !std::isnan(low),
                 has_high = voxel[axis] != known.max[axis] && !std::isnan(high);
      difference[axis] = (has_high ? high : here) - (has_low ? low : here);
      if (!has_low || !has_high) difference[axis] *= 2;
    }
    to[i] = float(0.5 * glm::length(normal * difference));
    any = any || to[i] != 0;
  }
  return any;
}

/// Splits a tile as `told_by_blocks` does and appends the parts.
void split_tile(const FieldIndex& gradient, const Box& domain, const Tile& tile, int level,
                std::vector<Tile>& parts) {
  const glm::ivec3 last = tile.origin + (tile.width - 1);
  if (glm::any(glm::greaterThan(tile.origin, domain.max)) ||
      glm::any(glm::lessThan(last, domain.min)))
    return;
  if (tile.width == 8 || !gradient.holds_any(level, tile.origin)) {
    parts.push_back(tile);
    return;
  }
  const int width = FieldIndex::widths[std::size_t(level) + 1];
  for_points({glm::ivec3(0), glm::ivec3(tile.width / width - 1)}, [&](const glm::ivec3& at) {
    split_tile(gradient, domain, {tile.origin + width * at, width, tile.value}, level + 1, parts);
  });
}

}  // namespace

Field gradient_of_voxels(const Field& field) {
  Field result;
  result.name = "gradient of " + field.name;
  result.value_type = "float";
  result.active_box = field.active_box;
  result.margin = field.margin;
  result.world_from_index = field.world_from_index;
  const FieldCursor cursor(field);
  const glm::dmat3 normal = glm::transpose(glm::inverse(glm::dmat3(field.world_from_index)));
  const std::vector<glm::ivec3> blocks = candidate_blocks(field);
  const Box known = field.margin == 0 ? field.domain() : everywhere;
  const auto values = std::make_shared_for_overwrite<float[]>(blocks.size() * 512);
  std::vector<char> any(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
    any[n] = compute_block(cursor, normal, blocks[n], known, values.get() + n * 512);
  });
  for (std::size_t n = 0; n < blocks.size(); ++n)
    if (any[n]) result.leaves.push_back({blocks[n], values.get() + n * 512});
  result.active_voxels = 512 * result.leaves.size();
  result.storage = values;
  return result;
}

Field told_by_blocks(const Field& field, const Field& gradient, bool with_zeros) {
  Field result = field;
  const FieldIndex index(field), gradients(gradient);
  result.tiles.clear();
  for (const Tile& tile : field.tiles) {
    int level = 0;
    while (FieldIndex::widths[std::size_t(level)] != tile.width) ++level;
    split_tile(gradients, field.domain(), tile, level, result.tiles);
    check_blocks(field, result.tiles.size());
  }
  for (const Leaf& leaf : gradient.leaves)
    if (with_zeros && !index.stores(leaf.origin))
      result.tiles.push_back({leaf.origin, 8, glm::vec3(0)});
  return result;
}

}  // namespace psivox
