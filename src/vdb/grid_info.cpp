#include "grid_info.h"

#include "grid_check.h"
#include "grid_types.h"
#include "psivox/error.h"

namespace psivox::vdb {
namespace {

glm::dvec3 column_lengths(const glm::dmat4& m) {
  const auto length = [&](int i) { return openvdb::Vec3d(m[i][0], m[i][1], m[i][2]).length(); };
  return {length(0), length(1), length(2)};
}

}  // namespace

GridInfo grid_info(Archive& archive, const GridEntry& entry) {
  GridInfo info;
  info.name = entry.name;
  info.type = entry.descriptor.gridType();
  info.value_type = value_type_of(info.type);
  info.channels = channels_of(info.type);
  info.saved_as_half = entry.descriptor.saveFloatAsHalf();
  info.problem = entry.problem;
  if (!entry.problem.empty()) return info;

  openvdb::GridBase::Ptr grid;
  try {
    grid = archive.read(entry);
  } catch (const Error& e) {
    // The row names the grid already.
    info.problem = std::string(e.what()).substr(archive.subject(entry.name).size());
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
  info.problem = problem_of(*grid, summary);
  return info;
}

}  // namespace psivox::vdb
