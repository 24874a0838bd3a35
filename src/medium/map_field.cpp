#include "medium/map_field.h"

#include <tbb/parallel_for.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <unordered_set>

#include "base/text.h"
#include "field/field_index.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr std::size_t most_tiles = std::size_t{1} << 22;  // 128 MiB of them

void check_count(const Field& field, std::size_t tiles) {
  if (tiles > most_tiles)
    throw Error(ExitCode::memory,
                "grid " + in_quotes(field.name) +
                    ": the function gives 0 a meaning, and the domain is too large to be filled "
                    "with it; take --classification post, or a function that is 0 at 0");
}

/// Adds tiles of value 0 wherever a field's domain has neither leaf nor tile, so that a function of
/// the stored values applies to all values. Throws Error(memory) if that takes more than 2^22
/// tiles.
void fill_domain(Field& field) {
  const FieldIndex index(field);
  const Box domain = field.domain();
  std::vector<Tile> tiles;
  const auto fill = [&](const auto& self, const Box& box, std::size_t level) -> void {
    const int width = FieldIndex::widths[level];
    const int shift = std::countr_zero(unsigned(width));
    for_points({box.min >> shift, box.max >> shift}, [&](const glm::ivec3& cube) {
      const glm::ivec3 origin = cube << shift;
      if (index.is_one(int(level), origin)) return;
      const Box whole{origin, origin + (width - 1)}, inside = common(whole, domain);
      // Cubes of the greatest width that reach beyond a small domain lie mostly outside it, and an
      // atlas visits all of a tile's surface. So they are split.
      if ((level == 0 && inside != whole) || index.holds_any(int(level), origin))
        return self(self, inside, level + 1);
      tiles.push_back({origin, width, glm::vec3(0)});
      check_count(field, tiles.size());
    });
  };
  fill(fill, domain, 0);
  field.tiles.insert(field.tiles.end(), tiles.begin(), tiles.end());
}

/// Adds tiles of value 0 only in the blocks of 8^3 voxels next to leaves and tiles, whose values
/// trilinear interpolation mixes with stored ones.
void fill_surroundings(Field& field) {
  const FieldIndex index(field);
  std::unordered_set<glm::ivec3, VoxelHash> blocks;
  // Adds the shell of blocks around a cube.
  const auto surround = [&](const glm::ivec3& origin, int width) {
    for (int x = -8; x <= width; x += 8)
      for (int y = -8; y <= width; y += 8) {
        const bool side = x == -8 || x == width || y == -8 || y == width;
        for (int z = -8; z <= width; z += side ? 8 : width + 8) {
          const glm::ivec3 block = origin + glm::ivec3(x, y, z);
          if (!index.stores(block)) blocks.insert(block);
        }
      }
    check_count(field, blocks.size());
  };
  for (const Leaf& leaf : field.leaves) surround(leaf.origin, 8);
  for (const Tile& tile : field.tiles) surround(tile.origin, tile.width);
  for (const glm::ivec3& block : blocks) field.tiles.push_back({block, 8, glm::vec3(0)});
}

constexpr std::array<const char*, 4> vector_parts{"x", "y", "z", "length"};

}  // namespace

Field map_field(const Field& field, int channels, const VoxelMap& map) {
  check_in_memory(field);
  Field result = field;
  result.channels = channels;
  result.active_range.reset();
  result.stored_range.reset();
  fill_leaves(result, [&](std::size_t n, float* to) {
    const OrderedValues own(field, field.leaves[n]);
    const float* from = own.data();
    for (int i = 0; i < 512; ++i, from += field.channels, to += channels) {
      glm::vec3 value(0);
      for (int c = 0; c < field.channels; ++c) value[c] = from[c];
      value = map(value);
      for (int c = 0; c < channels; ++c) to[c] = value[c];
    }
  });
  for (Tile& tile : result.tiles) tile.value = map(tile.value);
  std::erase_if(result.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0); });
  if (channels == 1) result.stored_range = glm::vec2(stored_range(result));
  return result;
}

Field attenuation_of_voxels(const Field& field, const TransferFunction& function) {
  const auto map = [&](const glm::vec3& value) {
    if (std::isnan(value.x)) return value;  // absent
    const TransferPoint point = function.at(double(value.x));
    return glm::vec3(float(point.attenuation), 0, 0);
  };
  if (function.at(0).attenuation == 0) return map_field(field, 1, map);
  Field whole = field;
  fill_domain(whole);
  return map_field(whole, 1, map);
}

Field attenuation_of_voxels(const Field& field, const Field& gradient,
                            const TransferFunction& function) {
  Field whole = field;
  if (function.attenuation(0, 0) > 0) fill_domain(whole);
  whole = told_by_blocks(whole, gradient, true);
  const FieldIndex values(whole), gradients(gradient);

  // Places where values or gradients vary become leaves; the rest are tiles without gradients.
  Field result = whole;
  result.active_range.reset();
  result.stored_range.reset();
  result.tiles.clear();
  for (const Tile& tile : whole.tiles) {
    if (tile.width == 8 && gradients.stores(tile.origin)) {
      result.leaves.push_back({tile.origin, nullptr});
      continue;
    }
    const double v = double(tile.value.x);
    const auto attenuation = std::isnan(v) ? tile.value.x : float(function.attenuation(v, 0));
    if (attenuation != 0)
      result.tiles.push_back({tile.origin, tile.width, glm::vec3(attenuation, 0, 0)});
  }
  fill_leaves(result, [&](std::size_t n, float* attenuation) {
    const glm::ivec3& origin = result.leaves[n].origin;
    const FieldIndex::Block v = values.block(origin), g = gradients.block(origin);
    for (int i = 0; i < 512; ++i)
      attenuation[i] = std::isnan(v.value(i))
                           ? v.value(i)
                           : float(function.attenuation(double(v.value(i)), double(g.value(i))));
  });
  result.stored_range = glm::vec2(stored_range(result));
  return result;
}

Field color_of_voxels(const Field& field, const TransferFunction& function) {
  Field whole = field;
  if (function.at(0).attenuation > 0)
    fill_domain(whole);
  else if (function.at(0).color != glm::dvec3(0))
    fill_surroundings(whole);
  return map_field(whole, 3, [&](const glm::vec3& value) {
    return glm::vec3(function.at(double(value.x)).color);
  });
}

Field spread_colors(const Field& colors, const Field& active) {
  Field whole = colors;
  fill_surroundings(whole);
  const FieldIndex own(whole), mask(active);
  Field result = whole;
  result.tiles.clear();
  result.leaves.clear();
  for (const Tile& tile : whole.tiles)
    if (tile.width > 8)
      result.tiles.push_back(tile);
    else
      result.leaves.push_back({tile.origin, nullptr});
  result.leaves.insert(result.leaves.end(), whole.leaves.begin(), whole.leaves.end());
  result.channels = 3;
  fill_leaves(result, [&](std::size_t n, float* to) {
    for (int i = 0; i < 512; ++i, to += 3) {
      const glm::ivec3 voxel = result.leaves[n].origin + leaf_voxel(i);
      glm::dvec4 sum(0);
      const auto see = [&](const glm::ivec3& at) {
        if (mask.at(at).x > 0) sum += glm::dvec4(own.at(at), 1);
      };
      see(voxel);
      for (int k = 0; sum.w == 0 && k < 6; ++k) {
        glm::ivec3 beside = voxel;
        beside[k >> 1] += k & 1 ? 1 : -1;
        see(beside);
      }
      if (sum.w == 0)
        for (int k = 0; k < 27; ++k) see(voxel + glm::ivec3(k / 9, k / 3 % 3, k % 3) - 1);
      for (int c = 0; c < 3; ++c) to[c] = sum.w > 0 ? float(sum[c] / sum.w) : 0;
    }
  });
  std::ranges::sort(result.leaves, {}, [](const Leaf& leaf) { return tree_order(leaf.origin); });
  result.active_box = {colors.active_box.min - 1, colors.active_box.max + 1};
  return result;
}

VectorPart vector_part(const VolumeFile& file, const std::string& name) {
  const int channels = file.channels(name);
  if (channels == 3) return {name, "length"};
  const std::size_t colon = name.rfind(':');
  if (channels != 0 || colon == std::string::npos) return {name, ""};
  VectorPart named{name.substr(0, colon), name.substr(colon + 1)};
  const int of_grid = file.channels(named.grid);
  if (of_grid == 0) return {name, ""};
  if (named.active()) return named;
  if (of_grid == 1)
    throw Error(ExitCode::input, "grid " + in_quotes(named.grid) + " is scalar: it has no part " +
                                     in_quotes(named.part) + " but 'active'; give its name alone");
  if (std::ranges::find(vector_parts, named.part) == vector_parts.end())
    throw Error(ExitCode::input, "grid " + in_quotes(named.grid) + " has no part " +
                                     in_quotes(named.part) +
                                     "; a vector has x, y, z, length and active");
  return named;
}

Field part_of_vectors(const Field& vectors, const VectorPart& part) {
  const auto place = std::ranges::find(vector_parts, part.part) - vector_parts.begin();
  Field field = map_field(vectors, 1, [place](const glm::vec3& v) {
    if (place < 3) return glm::vec3(v[int(place)], 0, 0);
    // squares of float32 are beyond float32 from 1e20 on, and 0 below 1e-23
    constexpr double largest = std::numeric_limits<float>::max();
    return glm::vec3(float(std::min(glm::length(glm::dvec3(v)), largest)), 0, 0);
  });
  field.name += ":" + part.part;
  field.value_type = "float";
  field.of_vectors = true;
  field.active_range = glm::vec2(active_range(field));
  return field;
}

}  // namespace psivox
