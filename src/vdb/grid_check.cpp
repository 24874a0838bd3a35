#include "grid_check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/matrix.hpp>
#include <sstream>
#include <type_traits>

#include "grid_types.h"

namespace psivox::vdb {
namespace {

/// Coordinates below this limit keep differences, sums of two and a margin within an int.
constexpr std::int64_t kMaxExtent = std::int64_t{1} << 30;

template <typename ValueT>
openvdb::Vec3d to_vec3d(const ValueT& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec) {
    return {double(value[0]), double(value[1]), double(value[2])};
  } else {
    return openvdb::Vec3d(static_cast<double>(value));
  }
}

bool invertible(const openvdb::math::Transform& transform) {
  const glm::dmat4 m = world_from_index(transform);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(m[column][row])) return false;
    }
  }
  const double det = glm::determinant(m);
  return std::isfinite(det) && det != 0.0;
}

}  // namespace

GridSummary summarise(const openvdb::GridBase& grid) {
  GridSummary summary;
  summary.channels = channels_of(grid.type());
  if (summary.channels == 0) return summary;
  const openvdb::TreeBase& tree = grid.constBaseTree();
  summary.active_voxels = tree.activeVoxelCount();
  summary.leaves = tree.leafCount();
  summary.active_tiles = tree.activeTileCount();
  openvdb::CoordBBox box;
  with_typed_grid(grid, [&](const auto& typed) {
    summary.background = to_vec3d(typed.tree().background());
    // not the tree's evalActiveVoxelBoundingBox: to see whether the tree is empty, it divides the
    // differences of tiles and background, for some integers by 0
    typed.tree().root().evalActiveBoundingBox(box);
  });
  if (!box.empty()) {
    summary.active_box = {{box.min().x(), box.min().y(), box.min().z()},
                          {box.max().x(), box.max().y(), box.max().z()}};
  }
  return summary;
}

bool too_large(const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = box.min[axis], hi = box.max[axis];
    if (hi - lo + 1 >= kMaxExtent || std::abs(lo) >= kMaxExtent || std::abs(hi) >= kMaxExtent) {
      return true;
    }
  }
  return false;
}

bool has_background(const openvdb::GridBase& grid, const GridSummary& summary) {
  // A level set's background is its half width; the conversion to fog makes it 0.
  return summary.channels > 0 && !is_level_set(grid) && summary.background != openvdb::Vec3d(0.0);
}

std::string background_text(const GridSummary& summary) {
  std::ostringstream text;
  const openvdb::Vec3d& value = summary.background;
  if (summary.channels == 1)
    text << value[0];
  else
    text << '(' << value[0] << ", " << value[1] << ", " << value[2] << ')';
  return text.str();
}

std::string problem_of(const openvdb::GridBase& grid, const GridSummary& summary) {
  if (summary.channels == 0) return unsupported_type(grid.type());
  if (summary.active_voxels == 0) return "has no active voxel: nothing to render";
  if (too_large(summary.active_box)) {
    return "has active voxels 2^30 or more apart or from the origin; crop it";
  }
  if (grid.transform().isLinear() && !invertible(grid.transform())) {
    return "has a transform that is singular or not finite";
  }
  return {};
}

glm::dmat4 world_from_index(const openvdb::math::Transform& transform) {
  openvdb::Mat4d mat;
  try {
    mat = transform.baseMap()->getAffineMap()->getMat4();
  } catch (const openvdb::Exception&) {  // it also inverts the matrix
    return glm::dmat4(0.0);
  }
  // OpenVDB's vectors are rows: its row i is the image of axis i, which is glm's column i.
  glm::dmat4 result(1.0);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) result[i][j] = mat(i, j);
  }
  return result;
}

}  // namespace psivox::vdb
