#include "field/field_index.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/vector_relational.hpp>

#include "field/index_space.h"

namespace psivox {

const Leaf* FieldIndex::leaf(const glm::ivec3& origin) const {
  const std::int32_t number = numbers_.find(origin);
  if (number == BlockMap::none || std::size_t(number) >= field_->leaves.size()) return nullptr;
  return &field_->leaves[std::size_t(number)];
}

const Tile* FieldIndex::tile(int level, const glm::ivec3& origin) const {
  if (!has_width(level)) return nullptr;
  const std::int32_t number = numbers_.find(origin);
  const std::size_t leaves = field_->leaves.size();
  if (number == BlockMap::none || std::size_t(number) < leaves) return nullptr;
  const Tile& found = field_->tiles[std::size_t(number) - leaves];
  return found.width == widths[std::size_t(level)] ? &found : nullptr;
}

FieldIndex::FieldIndex(const Field& field)
    : field_(&field), numbers_(field.leaves.size() + field.tiles.size()) {
  check_in_memory(field);
  std::int32_t number = 0;
  std::array<glm::ivec3, 2> last{glm::ivec3(1), glm::ivec3(1)};  // no origin; most lie side by side
  const auto add = [&](const glm::ivec3& origin, int width) {
    numbers_.insert(origin, number++);
    for (std::size_t level = 0; level < widths.size(); ++level) {
      has_width_[level] = has_width_[level] || widths[level] == width;
      if (widths[level] <= width) continue;
      const glm::ivec3 cube = cube_of(origin, widths[level]);
      if (cube != last[level]) occupied_[level].insert(last[level] = cube);
    }
  };
  for (const Leaf& leaf : field.leaves) add(leaf.origin, 8);
  for (const Tile& tile : field.tiles) add(tile.origin, tile.width);
}

namespace {

constexpr std::array<float, 3> zeros{};
constexpr Strides of_one_value{0, 0, 0, 1};
constexpr FieldIndex::Block no_block{{zeros.data(), of_one_value}, false};

FieldIndex::Block block_of(const Tile& tile) {
  return {{glm::value_ptr(tile.value), of_one_value}, true};
}

}  // namespace

FieldIndex::Block FieldIndex::block(const glm::ivec3& origin) const {
  if (has_width(2))
    if (const Leaf* found = leaf(origin)) return {values_of(*field_, *found), true};
  for (int level = 0; level < int(widths.size()); ++level)
    if (const Tile* found = tile(level, cube_of(origin, widths[std::size_t(level)])))
      return block_of(*found);
  return no_block;
}

FieldIndex::Cube FieldIndex::cube(const glm::ivec3& voxel) const {
  for (std::size_t level = 0;; ++level) {
    const int width = widths[level];
    const glm::ivec3 origin = cube_of(voxel, width);
    const Box box{origin, origin + (width - 1)};
    if (width == 8) return {box, block(origin)};
    if (const Tile* found = tile(int(level), origin)) return {box, block_of(*found)};
    if (!holds_narrower(int(level), origin)) return {box, no_block};
  }
}

glm::dvec3 FieldIndex::at(const glm::ivec3& voxel) const {
  const LeafValues values = block(cube_of(voxel, 8)).values;
  const float* from = values.at(voxel & 7);
  glm::dvec3 value(0);
  for (int c = 0; c < field_->channels; ++c) value[c] = double(from[c * values.strides.channel]);
  return value;
}

glm::dvec3 FieldIndex::at(const glm::dvec3& point) const {
  const Box domain = field_->domain();
  if (glm::any(glm::lessThan(point, glm::dvec3(domain.min))) ||
      glm::any(glm::greaterThan(point, glm::dvec3(domain.max))))
    return glm::dvec3(0);
  const glm::dvec3 floor = glm::floor(point);
  const glm::dvec3 u = point - floor;
  glm::dvec3 sum(0);
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 corner = cube_corner(i);
    const glm::dvec3 weights = glm::mix(1.0 - u, u, glm::dvec3(corner));
    const double weight = weights.x * weights.y * weights.z;
    if (weight != 0) sum += weight * at(glm::ivec3(floor) + corner);
  }
  return sum;
}

bool FieldIndex::holds_any(int level, const glm::ivec3& origin) const {
  return is_one(level, origin) || holds_narrower(level, origin);
}

bool FieldIndex::holds_narrower(int level, const glm::ivec3& origin) const {
  return level < 2 && occupied_[std::size_t(level)].contains(origin);
}

bool FieldIndex::is_one(int level, const glm::ivec3& origin) const {
  return tile(level, origin) || (widths[std::size_t(level)] == 8 && leaf(origin));
}

std::size_t FieldIndex::empty_steps(const glm::dvec3& point, const glm::dvec3& step) const {
  const Cube cube = this->cube(nearest_voxel(point));
  if (cube.block.stored) return 0;
  const glm::dvec3 low = glm::dvec3(cube.voxels.min) - 0.5,
                   high = glm::dvec3(cube.voxels.max) + 0.5;
  const double left = interval_in(low, high, point, step).y;
  return std::size_t(std::max(1.0, std::ceil(left)));
}

}  // namespace psivox
