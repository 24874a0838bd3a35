#include "medium/map_field.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstddef>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <vector>

#include "field/index_space.h"
#include "field/leaf_values.h"

namespace psivox {
namespace {

/// Origin of the coarse leaf that a leaf is an eighth of.
glm::ivec3 coarse_origin(const glm::ivec3& origin) { return (origin >> 4) * 8; }

/// Values of 2^3 voxels each of a leaf, into its eighth of a coarse leaf. Behind `last` the leaf
/// has no values; those beside stand for them.
void add_values(const glm::ivec3& origin, const float* values, int channels, CoarseValue what,
                const glm::ivec3& last, float* coarse) {
  const glm::ivec3 first = ((origin >> 3) & 1) * 4;
  const auto index = [channels](const glm::ivec3& at) {
    return std::size_t(((at.x * 8 + at.y) * 8 + at.z) * channels);
  };
  for_points({glm::ivec3(0), glm::ivec3(3)}, [&](const glm::ivec3& at) {
    for (int c = 0; c < channels; ++c) {
      const auto value = [&](int i) {
        return values[index(glm::min(2 * at + cube_corner(i), last)) + std::size_t(c)];
      };
      float& mean = coarse[index(first + at) + std::size_t(c)];
      if (what == CoarseValue::sample) {  // each of the eight as often
        mean = value((at.x + 2 * at.y + 4 * at.z + (at.x >> 1) + (at.y >> 1) + (at.z >> 1)) & 7);
        continue;
      }
      double sum = 0;
      int known = 0;
      for (int i = 0; i < 8; ++i)
        if (!std::isnan(value(i))) {
          sum += value(i);
          ++known;
        }
      mean = known > 0 ? float(sum / known) : value(0);
    }
  });
}

/// A tile that is wider than a coarse leaf, in the widths that tiles may have.
void add_tiles(const Tile& tile, std::vector<Tile>& coarse) {
  const int width = tile.width / 2 < 128 ? 8 : 128;
  const int count = tile.width / 2 / width;
  for_points({glm::ivec3(0), glm::ivec3(count - 1)}, [&](const glm::ivec3& at) {
    coarse.push_back({tile.origin / 2 + width * at, width, tile.value});
  });
}

Field halved(const Field& field, Centering centering, CoarseValue what) {
  const std::size_t floats = 512 * std::size_t(field.channels);
  Field coarse{FieldHead(field)};
  coarse.active_box = {field.active_box.min >> 1, field.active_box.max >> 1};
  coarse.active_voxels = (field.active_voxels + 7) / 8;
  // voxel i stands for voxels 2i and 2i + 1, and its middle is between theirs
  const glm::dvec3 middle(centering == Centering::node ? 0.5 : 0);
  coarse.world_from_index =
      glm::scale(glm::translate(field.world_from_index, middle), glm::dvec3(2));

  std::map<TreeOrder, std::size_t> numbers;  // of coarse leaves
  const auto key = [](const glm::ivec3& origin) { return tree_order(coarse_origin(origin)); };
  for (const Leaf& leaf : field.leaves) numbers.emplace(key(leaf.origin), 0);
  for (const Tile& tile : field.tiles) {
    if (tile.width > 8)
      add_tiles(tile, coarse.tiles);
    else
      numbers.emplace(key(tile.origin), 0);
  }
  const auto values = std::make_shared<float[]>(numbers.size() * floats);
  std::size_t count = 0;
  for (auto& [order, number] : numbers) number = count++;
  coarse.leaves.resize(count);
  const auto place = [&](const glm::ivec3& origin) {
    const std::size_t number = numbers.at(key(origin));
    coarse.leaves[number] = {coarse_origin(origin), values.get() + number * floats};
    return values.get() + number * floats;
  };
  const auto last_in = [&](const glm::ivec3& origin) {
    const glm::ivec3 end = field.margin > 0 ? glm::ivec3(7) : field.active_box.max - origin;
    return glm::clamp(end, 0, 7);
  };
  for (const Leaf& leaf : field.leaves) place(leaf.origin);
  std::vector<float> same(floats);
  for (const Tile& tile : field.tiles) {
    if (tile.width > 8) continue;
    for (std::size_t i = 0; i < floats; ++i) same[i] = tile.value[int(i) % field.channels];
    add_values(tile.origin, same.data(), field.channels, what, last_in(tile.origin),
               place(tile.origin));
  }
  visit_leaves(field, [&](std::span<const Leaf> leaves) {
    tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t i) {
      const OrderedValues own(field, leaves[i]);
      add_values(leaves[i].origin, own.data(), field.channels, what, last_in(leaves[i].origin),
                 values.get() + numbers.at(key(leaves[i].origin)) * floats);
    });
  });
  coarse.storage = values;
  return coarse;
}

}  // namespace

Field coarse_field(const Field& field, int times, Centering centering, CoarseValue value) {
  Field coarse = halved(field, centering, value);
  for (int i = 1; i < times; ++i) coarse = halved(coarse, centering, value);
  return coarse;
}

}  // namespace psivox
