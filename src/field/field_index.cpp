#include "field/field_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/vector_relational.hpp>

#include "field/index_space.h"

namespace psivox {
std::size_t VoxelHash::operator()(const glm::ivec3& v) const {
  std::uint64_t h = 0;
  for (int axis = 0; axis < 3; ++axis) h = (h ^ std::uint32_t(v[axis])) * 0x9E3779B97F4A7C15ull;
  return std::size_t(h ^ (h >> 32));
}

std::size_t FieldIndex::slot_of(const glm::ivec3& origin) const {
  const std::vector<Leaf>& leaves = field_->leaves;
  const auto is_other = [&](std::size_t n) {
    return (n < leaves.size() ? leaves[n].origin : field_->tiles[n - leaves.size()].origin) !=
           origin;
  };
  std::size_t slot = VoxelHash()(origin) & (slots_.size() - 1);
  while (slots_[slot] != 0 && is_other(slots_[slot] - 1)) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

const Leaf* FieldIndex::leaf(const glm::ivec3& origin) const {
  const std::size_t number = slots_[slot_of(origin)];
  return number == 0 || number > field_->leaves.size() ? nullptr : &field_->leaves[number - 1];
}

const Tile* FieldIndex::tile(int level, const glm::ivec3& origin) const {
  if (!has_width(level)) return nullptr;
  const std::size_t number = slots_[slot_of(origin)], leaves = field_->leaves.size();
  if (number <= leaves) return nullptr;
  const Tile& found = field_->tiles[number - leaves - 1];
  return found.width == widths[std::size_t(level)] ? &found : nullptr;
}

FieldIndex::FieldIndex(const Field& field) : field_(&field) {
  check_in_memory(field);
  slots_.resize(std::bit_ceil(2 * (field.leaves.size() + field.tiles.size()) + 1));
  std::uint32_t number = 0;
  std::array<glm::ivec3, 2> last{glm::ivec3(1), glm::ivec3(1)};  // no origin; most lie side by side
  const auto add = [&](const glm::ivec3& origin, int width) {
    std::uint32_t& slot = slots_[slot_of(origin)];
    ++number;
    if (slot == 0) slot = number;
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

FieldIndex::Block FieldIndex::block(const glm::ivec3& origin) const {
  static constexpr std::array<float, 3> zeros{};
  constexpr Strides of_one_value{0, 0, 0, 1};
  if (has_width(2))
    if (const Leaf* found = leaf(origin)) return {values_of(*field_, *found), true};
  for (int level = 0; level < int(widths.size()); ++level)
    if (const Tile* found = tile(level, cube_of(origin, widths[std::size_t(level)])))
      return {{glm::value_ptr(found->value), of_one_value}, true};
  return {{zeros.data(), of_one_value}, false};
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

std::optional<Box> FieldIndex::empty_cube(const glm::ivec3& voxel) const {
  for (std::size_t level = 0; level < widths.size(); ++level) {
    const glm::ivec3 origin = cube_of(voxel, widths[level]);
    if (!holds_any(int(level), origin)) return Box{origin, origin + (widths[level] - 1)};
  }
  return {};
}

std::size_t FieldIndex::empty_steps(const glm::dvec3& point, const glm::dvec3& step) const {
  const std::optional<Box> cube = empty_cube(nearest_voxel(point));
  if (!cube) return 0;
  const glm::dvec3 low = glm::dvec3(cube->min) - 0.5, high = glm::dvec3(cube->max) + 0.5;
  const double left = interval_in(low, high, point, step).y;
  return std::size_t(std::max(1.0, std::ceil(left)));
}

bool FieldIndex::stores(const glm::ivec3& voxel) const {
  for (std::size_t level = 0; level < widths.size(); ++level)
    if (is_one(int(level), cube_of(voxel, widths[level]))) return true;
  return false;
}

}  // namespace psivox
