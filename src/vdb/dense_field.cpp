#include "psivox/dense_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "psivox/memory.h"
#include "psivox/text.h"

namespace psivox {
namespace {

constexpr int leaf_width = 8;

/// Voxels along an axis that make the active box empty.
constexpr int no_voxel = std::numeric_limits<int>::max();

void check_transform(const std::string& name, const glm::dmat4& m) {
  bool finite = true;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) finite &= std::isfinite(m[c][r]);
  if (!finite || glm::determinant(glm::dmat3(m)) == 0)
    throw Error(ExitCode::input, "grid " + in_quotes(name) + " has voxels without a volume");
}

}  // namespace

/// What 8^3 voxels hold.
struct DenseField::Block {
  std::uint64_t active = 0;  ///< voxels other than 0
  bool constant = true;      ///< of one value, and complete
  glm::vec3 value{0};        ///< of the first voxel
  glm::ivec3 min{no_voxel}, max{-1};
};

DenseField::DenseField(const std::string& name, const glm::ivec3& shape, int channels,
                       const glm::dmat4& world_from_index)
    : shape_(shape) {
  check_transform(name, world_from_index);
  field_.name = name;
  field_.value_type = channels == 3 ? "vec3s" : "float";
  field_.channels = channels;
  field_.world_from_index = world_from_index;
  field_.active_box = {glm::ivec3(no_voxel), glm::ivec3(-1)};
}

DenseField::Block DenseField::summarise(std::span<const float> slab, int planes, int y,
                                        int z) const {
  Block block;
  const int rows = std::min(leaf_width, shape_.y - y), columns = std::min(leaf_width, shape_.z - z);
  block.constant = planes == leaf_width && rows == leaf_width && columns == leaf_width;
  const auto first =
      (std::size_t(y) * std::size_t(shape_.z) + std::size_t(z)) * std::size_t(field_.channels);
  for (int c = 0; c < field_.channels; ++c) block.value[c] = slab[first + std::size_t(c)];
  for (int i = 0; i < planes; ++i)
    for (int j = 0; j < rows; ++j) {
      const float* value =
          slab.data() +
          ((std::size_t(i) * std::size_t(shape_.y) + std::size_t(y + j)) * std::size_t(shape_.z) +
           std::size_t(z)) *
              std::size_t(field_.channels);
      for (int k = 0; k < columns; ++k, value += field_.channels) {
        bool active = false;
        for (int c = 0; c < field_.channels; ++c) {
          active |= value[c] != 0;
          block.constant &= value[c] == block.value[c];
        }
        if (!active) continue;
        ++block.active;
        const glm::ivec3 voxel(next_plane_ + i, y + j, z + k);
        block.min = glm::min(block.min, voxel);
        block.max = glm::max(block.max, voxel);
      }
    }
  return block;
}

void DenseField::copy(std::span<const float> slab, int planes, int y, int z, float* leaf) const {
  const auto channels = std::size_t(field_.channels);
  std::fill_n(leaf, 512 * channels, 0.0f);
  const int rows = std::min(leaf_width, shape_.y - y), columns = std::min(leaf_width, shape_.z - z);
  for (int i = 0; i < planes; ++i)
    for (int j = 0; j < rows; ++j)
      std::memcpy(leaf + std::size_t(i * 64 + j * 8) * channels,
                  slab.data() + ((std::size_t(i) * std::size_t(shape_.y) + std::size_t(y + j)) *
                                     std::size_t(shape_.z) +
                                 std::size_t(z)) *
                                    channels,
                  std::size_t(columns) * channels * sizeof(float));
}

void DenseField::add(std::span<const float> slab) {
  const int planes = std::min(leaf_width, shape_.x - next_plane_);
  const int rows = (shape_.y + 7) / 8, columns = (shape_.z + 7) / 8;
  std::vector<Block> blocks(std::size_t(rows) * std::size_t(columns));
  const auto row_of = [&](std::size_t n) { return 8 * int(n / std::size_t(columns)); };
  const auto column_of = [&](std::size_t n) { return 8 * int(n % std::size_t(columns)); };
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
    blocks[n] = summarise(slab, planes, row_of(n), column_of(n));
  });
  std::vector<std::size_t> leaves;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const Block& block = blocks[n];
    if (block.active == 0) continue;
    field_.active_voxels += block.active;
    field_.active_box.min = glm::min(field_.active_box.min, block.min);
    field_.active_box.max = glm::max(field_.active_box.max, block.max);
    if (block.constant)
      field_.tiles.push_back({{next_plane_, row_of(n), column_of(n)}, leaf_width, block.value});
    else
      leaves.push_back(n);
  }
  const std::size_t floats = 512 * std::size_t(field_.channels);
  const std::uint64_t bytes = leaves.size() * floats * sizeof(float), free = available_memory();
  if (free > 0 && bytes > free)
    throw Error(ExitCode::memory,
                "grid " + in_quotes(field_.name) +
                    formatted(" of %dx%dx%d voxels", shape_.x, shape_.y, shape_.z) +
                    " takes more than the memory that is free");
  const auto values = std::make_shared_for_overwrite<float[]>(leaves.size() * floats);
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t i) {
    copy(slab, planes, row_of(leaves[i]), column_of(leaves[i]), values.get() + i * floats);
  });
  for (std::size_t i = 0; i < leaves.size(); ++i)
    field_.leaves.push_back(
        {{next_plane_, row_of(leaves[i]), column_of(leaves[i])}, values.get() + i * floats});
  storage_.push_back(values);
  next_plane_ += planes;
}

Field DenseField::finish() {
  const auto in_order = [](const auto& a, const auto& b) {
    return tree_order(a.origin) < tree_order(b.origin);
  };
  std::sort(field_.leaves.begin(), field_.leaves.end(), in_order);
  std::sort(field_.tiles.begin(), field_.tiles.end(), in_order);
  if (field_.active_voxels == 0) field_.active_box = {};
  field_.storage =
      std::make_shared<std::vector<std::shared_ptr<const float[]>>>(std::move(storage_));
  return std::move(field_);
}

}  // namespace psivox
