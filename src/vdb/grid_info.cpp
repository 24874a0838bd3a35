#include "grid_info.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "file_metadata.h"
#include "grid_check.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "psivox/text.h"
#include "subject.h"

namespace psivox::vdb {
namespace {

glm::dvec3 column_lengths(const glm::dmat4& m) {
  const auto length = [&](int i) { return openvdb::Vec3d(m[i][0], m[i][1], m[i][2]).length(); };
  return {length(0), length(1), length(2)};
}

template <typename ValueT>
double magnitude(const ValueT& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return std::hypot(double(value[0]), double(value[1]), double(value[2]));
  else
    return static_cast<double>(value);
}

std::optional<ValueStatistics> statistics_of(const openvdb::GridBase& grid) {
  ValueStatistics found{std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity()};
  double voxels = 0;
  with_typed_grid(grid, [&](const auto& typed) {
    for (auto it = typed.cbeginValueOn(); it; ++it) {
      const double value = magnitude(*it);
      const auto count = it.getVoxelCount();
      if (!std::isfinite(value)) {
        found.not_finite += count;
        continue;
      }
      found.least = std::min(found.least, value);
      found.greatest = std::max(found.greatest, value);
      voxels += static_cast<double>(count);
      found.mean += (value - found.mean) * static_cast<double>(count) / voxels;
    }
  });
  if (voxels == 0) return std::nullopt;
  return found;
}

/// Bounds of the centres of the box's voxels.
void set_world_box(const openvdb::math::Transform& transform, GridInfo& info) {
  const Box& box = info.active_box;
  info.world_min = glm::dvec3(std::numeric_limits<double>::infinity());
  info.world_max = -info.world_min;
  for (unsigned i = 0; i < 8; ++i) {
    const openvdb::Vec3d p = transform.indexToWorld(openvdb::Vec3d(i & 1 ? box.max.x : box.min.x,
                                                                   i & 2 ? box.max.y : box.min.y,
                                                                   i & 4 ? box.max.z : box.min.z));
    info.world_min = glm::min(info.world_min, glm::dvec3(p[0], p[1], p[2]));
    info.world_max = glm::max(info.world_max, glm::dvec3(p[0], p[1], p[2]));
  }
}

/// Without OpenVDB's own statistics of the file and what other rows tell.
MetadataText other_metadata(const openvdb::GridBase& grid) {
  MetadataText text = text_of(grid);
  for (const char* known :
       {"name", "class", "is_saved_as_half_float", "file_bbox_min", "file_bbox_max",
        "file_mem_bytes", "file_voxel_count", "file_compression", "file_delayed_load"})
    text.erase(known);
  return text;
}

}  // namespace

GridInfo grid_info(Archive& archive, const GridEntry& entry, bool values) {
  GridInfo info;
  info.name = entry.name;
  info.type = printable(entry.descriptor.gridType());
  info.value_type = value_type_of(info.type);
  info.channels = channels_of(info.type);
  info.saved_as_half = entry.descriptor.saveFloatAsHalf();
  info.problem = entry.problem;
  if (!entry.problem.empty()) return info;

  openvdb::GridBase::Ptr grid;
  try {
    grid = values ? archive.read(entry) : archive.read_topology(entry);
  } catch (const Error& e) {
    // The row names the grid already.
    info.problem = without_subject(e.what(), archive.path(), entry.name);
    return info;
  }
  const GridSummary summary = summarise(*grid);
  info.grid_class = openvdb::GridBase::gridClassToString(grid->getGridClass());
  info.active_voxels = summary.active_voxels;
  info.leaves = summary.leaves;
  info.active_tiles = summary.active_tiles;
  info.active_box = summary.active_box;
  info.background = summary.background[0];
  const openvdb::math::Transform& transform = grid->transform();
  info.transform = transform.mapType();
  if (transform.isLinear()) {
    info.world_from_index = world_from_index(transform);
    info.voxel_size = column_lengths(info.world_from_index);
  } else {
    const openvdb::Vec3d size = transform.voxelSize();
    info.voxel_size = {size[0], size[1], size[2]};
  }
  info.values_read = values;
  if (values) info.values = statistics_of(*grid);
  if (!info.active_box.empty()) set_world_box(transform, info);
  info.metadata = other_metadata(*grid);
  info.problem = problem_of(*grid, summary);
  return info;
}

}  // namespace psivox::vdb
