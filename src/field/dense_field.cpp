#include "psivox/field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vector_relational.hpp>
#include <limits>

#include "base/memory.h"
#include "base/text.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr int leaf_width = 8;

/// Voxels along an axis that make the active box empty.
constexpr int no_voxel = std::numeric_limits<int>::max();

}  // namespace

/// What 8^3 voxels hold.
struct DenseField::Block {
  std::uint64_t active = 0;  ///< voxels with data other than 0
  bool empty = true;         ///< all are 0
  bool constant = true;      ///< of one value, and complete
  bool below_0 = false;
  int on_faces = 0;    ///< active voxels on the array's faces
  glm::vec3 value{0};  ///< of the first voxel
  glm::ivec3 min{no_voxel}, max{-1};
};

DenseField::DenseField(const std::string& name, const glm::ivec3& shape, int channels,
                       const glm::dmat4& world_from_index)
    : shape_(shape) {
  if (glm::any(glm::lessThan(shape, glm::ivec3(1))) || (channels != 1 && channels != 3))
    throw Error(ExitCode::input,
                "grid " + in_quotes(name) +
                    formatted(" of %dx%dx%d voxels and %d channels: expected at least one voxel, "
                              "and 1 or 3 channels",
                              shape.x, shape.y, shape.z, channels));
  if (!has_volume(world_from_index))
    throw Error(ExitCode::input, "grid " + in_quotes(name) +
                                     " has a transform that is singular, not finite or beyond "
                                     "1e75");
  field_.name = name;
  field_.value_type = channels == 3 ? "vec3s" : "float";
  field_.channels = channels;
  field_.world_from_index = world_from_index;
  field_.active_box = {glm::ivec3(no_voxel), glm::ivec3(-1)};
}

glm::ivec3 DenseField::size_of_block(const glm::ivec3& origin) const {
  return glm::min(shape_ - origin, glm::ivec3(leaf_width));
}

DenseField::Block DenseField::summarise(const LeafValues& values, const glm::ivec3& origin) const {
  const glm::ivec3 size = size_of_block(origin);
  const std::ptrdiff_t next = values.strides.channel;
  Block block;
  block.constant = size == glm::ivec3(leaf_width);
  for (int c = 0; c < field_.channels; ++c) block.value[c] = values.channel(c);
  for_points({glm::ivec3(0), size - 1}, [&](const glm::ivec3& at) {
    const float* value = values.at(at);
    bool active = false;
    for (int c = 0; c < field_.channels; ++c) {
      const float v = value[c * next], first = block.value[c];
      active |= is_active(v);
      block.empty &= v == 0;
      block.constant &= v == first || (std::isnan(v) && std::isnan(first));
    }
    if (!active) return;
    ++block.active;
    block.below_0 |= *value < 0;
    const glm::ivec3 place = origin + at;
    block.on_faces +=
        glm::any(glm::equal(place, glm::ivec3(0))) || glm::any(glm::equal(place, shape_ - 1));
    block.min = glm::min(block.min, origin + at);
    block.max = glm::max(block.max, origin + at);
  });
  return block;
}

void DenseField::copy(const LeafValues& values, const glm::ivec3& origin, float* leaf) const {
  const glm::ivec3 size = size_of_block(origin);
  if (size != glm::ivec3(leaf_width)) std::fill_n(leaf, 512 * field_.channels, 0.0f);
  copy_values(values, field_.channels, leaf, size);
}

void DenseField::add(const ArrayValues& slab, int axis, bool in_place) {
  if (next_plane_ >= shape_[axis]) refuse_planes(axis);
  axis_ = axis;
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const int rows = (shape_[u] + 7) / 8, columns = (shape_[v] + 7) / 8;
  std::vector<Block> blocks(std::size_t(rows) * std::size_t(columns));
  const auto origin_of = [&](std::size_t n) {
    glm::ivec3 origin(next_plane_);
    origin[u] = 8 * int(n / std::size_t(columns));
    origin[v] = 8 * int(n % std::size_t(columns));
    return origin;
  };
  const auto values_at = [&](glm::ivec3 origin) {
    const LeafValues from{slab.first, slab.strides};
    origin[axis] = 0;
    return LeafValues{from.at(origin), slab.strides};
  };
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
    blocks[n] = summarise(values_at(origin_of(n)), origin_of(n));
  });
  std::vector<glm::ivec3> copied;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const Block& block = blocks[n];
    const glm::ivec3 origin = origin_of(n);
    if (block.empty) continue;
    field_.active_voxels += block.active;
    below_0_ |= block.below_0;
    on_faces_ += block.on_faces;
    field_.active_box.min = glm::min(field_.active_box.min, block.min);
    field_.active_box.max = glm::max(field_.active_box.max, block.max);
    if (block.constant)
      field_.tiles.push_back({origin, leaf_width, block.value});
    else if (in_place && size_of_block(origin) == glm::ivec3(leaf_width))
      field_.leaves.push_back({origin, nullptr});
    else
      copied.push_back(origin);
  }
  next_plane_ += leaf_width;
  if (copied.empty()) return;
  const std::size_t floats = 512 * std::size_t(field_.channels);
  const std::uint64_t bytes = copied.size() * floats * sizeof(float), free = available_memory();
  if (free > 0 && bytes > free)
    throw Error(ExitCode::memory,
                "grid " + in_quotes(field_.name) +
                    formatted(" of %dx%dx%d voxels", shape_.x, shape_.y, shape_.z) +
                    " takes more than the memory that is free");
  const auto values = std::make_shared_for_overwrite<float[]>(copied.size() * floats);
  tbb::parallel_for(std::size_t{0}, copied.size(), [&](std::size_t i) {
    copy(values_at(copied[i]), copied[i], values.get() + i * floats);
  });
  for (std::size_t i = 0; i < copied.size(); ++i)
    field_.leaves.push_back({copied[i], values.get() + i * floats});
  storage_.push_back(values);
}

void DenseField::add(std::span<const float> slab) {
  const std::ptrdiff_t z = field_.channels, y = shape_.z * z, x = shape_.y * y;
  if (std::ptrdiff_t(slab.size()) != std::min(leaf_width, shape_.x - next_plane_) * x)
    refuse_planes(0);
  add({slab.data(), {x, y, z, 1}}, 0);
}

void DenseField::hold(const ArrayValues& array, std::shared_ptr<const void> owner) {
  field_.array = array;
  storage_.push_back(std::move(owner));
  for (ArrayValues slab = array; next_plane_ < shape_.x; slab.first += leaf_width * slab.strides.x)
    add(slab, 0, true);
}

void DenseField::refuse_planes(int axis) const {
  throw Error(ExitCode::input,
              "grid " + in_quotes(field_.name) +
                  formatted(" of %dx%dx%d voxels: the slabs are not its %d planes, 8 at a time",
                            shape_.x, shape_.y, shape_.z, shape_[axis]));
}

Field DenseField::finish() {
  if (next_plane_ < shape_[axis_]) refuse_planes(axis_);
  const auto in_order = [](const auto& a, const auto& b) {
    return tree_order(a.origin) < tree_order(b.origin);
  };
  std::sort(field_.leaves.begin(), field_.leaves.end(), in_order);
  std::sort(field_.tiles.begin(), field_.tiles.end(), in_order);
  if (field_.active_voxels == 0) field_.active_box = {};
  const Box array{glm::ivec3(0), shape_ - 1};
  const double faces = double(count_of(array)) - double(count_of({array.min + 1, array.max - 1}));
  // an array of one plane has no inside
  if ((below_0_ || 2 * double(on_faces_) > faces) && field_.channels == 1 &&
      glm::all(glm::greaterThan(shape_, glm::ivec3(1))))
    field_.array_box = array;
  field_.storage = std::make_shared<std::vector<std::shared_ptr<const void>>>(std::move(storage_));
  return std::move(field_);
}

void write_dense(const Field& field, const Box& box, float* out) {
  const glm::ivec3 size = box.max - box.min + 1;
  const auto channels = std::size_t(field.channels);
  const auto index = [&](const glm::ivec3& at) {
    return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
           std::size_t(at.z);
  };
  std::fill_n(out, (index(size - 1) + 1) * channels, 0.0f);
  const auto fill = [&](const glm::ivec3& origin, int width, const auto& value) {
    for_points(common({origin, origin + (width - 1)}, box), [&](const glm::ivec3& at) {
      std::copy_n(value(at - origin), channels, out + index(at - box.min) * channels);
    });
  };
  for (const Tile& tile : field.tiles)
    fill(tile.origin, tile.width, [&](const glm::ivec3&) { return &tile.value.x; });
  for (const Leaf& leaf : field.leaves) {
    const OrderedValues values(field, leaf);
    fill(leaf.origin, 8, [&](const glm::ivec3& at) {
      return values.data() + std::size_t((at.x * 8 + at.y) * 8 + at.z) * channels;
    });
  }
}

}  // namespace psivox
