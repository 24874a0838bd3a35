#include "read_grid.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "base/text.h"
#include "field/value_percentile.h"
#include "grid_types.h"
#include "psivox/error.h"

namespace psivox::vdb {
namespace {

glm::dvec3 column_lengths(const glm::dmat4& m) {
  const auto length = [&](int i) { return openvdb::Vec3d(m[i][0], m[i][1], m[i][2]).length(); };
  return {length(0), length(1), length(2)};
}

/// Statistics of the active values in their own type.
std::optional<ValueStatistics> statistics_of(FileGrid& grid) {
  const int channels = grid.channels();
  std::vector<Statistics> leaves(grid.topology().leaves.size());
  grid.each_leaf([&](std::size_t n, const DecodedLeaf& leaf) {
    std::array<double, 3 * kLeafVoxels> values;
    leaf.copy_to(values.data());
    leaves[n].add(values.data(), channels, leaf.active());
  });
  Statistics found;
  for (const Statistics& leaf : leaves) found.add(leaf);
  for (const TilePart& part : grid.topology().tiles)
    if (part.active) found.add(&part.value.x, channels, tile_voxels(part.tile()));
  return found.all();
}

/// Bounds of the centres of the box's voxels, by a function from index to world.
template <typename ToWorld>
void set_world_box(GridInfo& info, const ToWorld& to_world) {
  const Box& box = info.active_box;
  info.world_min = glm::dvec3(std::numeric_limits<double>::infinity());
  info.world_max = -info.world_min;
  for (unsigned i = 0; i < 8; ++i) {
    const glm::dvec3 p = to_world(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                  i & 4 ? box.max.z : box.min.z);
    info.world_min = glm::min(info.world_min, p);
    info.world_max = glm::max(info.world_max, p);
  }
}

void set_transform(const openvdb::math::Transform& transform, GridInfo& info) {
  info.transform = transform.mapType();
  if (transform.isLinear()) {
    info.world_from_index = world_from_index(transform);
    info.voxel_size = column_lengths(info.world_from_index);
  } else {
    const openvdb::Vec3d size = transform.voxelSize();
    info.voxel_size = {size[0], size[1], size[2]};
  }
  if (!info.active_box.empty())
    set_world_box(info, [&](double x, double y, double z) {
      const openvdb::Vec3d p = transform.indexToWorld(openvdb::Vec3d(x, y, z));
      return glm::dvec3(p[0], p[1], p[2]);
    });
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

/// NaN counts as 0.
bool is_value(double value) { return value < 0 || value > 0; }

bool has_value(const DecodedLeaf& leaf, int channels) {
  std::array<float, 3 * kLeafVoxels> values;
  leaf.copy_to(values.data());
  for (auto on = leaf.active().beginOn(); on; ++on)
    if (std::any_of(values.data() + on.pos() * unsigned(channels),
                    values.data() + (on.pos() + 1) * unsigned(channels), is_value))
      return true;
  return false;
}

bool has_value(FileGrid& grid) {
  for (const TilePart& part : grid.topology().tiles) {
    const glm::vec3 value = part.tile().value;
    if (part.active && (is_value(value.x) || is_value(value.y) || is_value(value.z))) return true;
  }
  std::atomic<bool> found = false;
  grid.each_leaf(
      [&](std::size_t, const DecodedLeaf& leaf) {
        if (!found && has_value(leaf, grid.channels())) found = true;
      },
      [&] { return found.load(); });
  return found;
}

}  // namespace

void Statistics::add(double value, std::uint64_t count) {
  if (!std::isfinite(value)) {
    not_finite += count;
    return;
  }
  least = std::min(least, value);
  greatest = std::max(greatest, value);
  voxels += static_cast<double>(count);
  mean += (value - mean) * static_cast<double>(count) / voxels;
}

void Statistics::add(const Statistics& other) {
  not_finite += other.not_finite;
  if (other.voxels == 0) return;
  least = std::min(least, other.least);
  greatest = std::max(greatest, other.greatest);
  voxels += other.voxels;
  mean += (other.mean - mean) * other.voxels / voxels;
}

std::optional<ValueStatistics> Statistics::all() const {
  if (voxels == 0) return std::nullopt;
  return ValueStatistics{least, greatest, mean, not_finite};
}

void set_world_box(GridInfo& info) {
  if (info.active_box.empty()) return;
  set_world_box(info, [&](double x, double y, double z) {
    return glm::dvec3(info.world_from_index * glm::dvec4(x, y, z, 1));
  });
}

GridContent content_of(std::uint64_t active_voxels, bool has_value) {
  return {active_voxels, has_value            ? ""
                         : active_voxels == 0 ? "has no active voxel"
                                              : "is 0 everywhere"};
}

GridContent content_of(GridFile& file, const GridEntry& entry) {
  const auto grid = file.open(entry);
  const std::uint64_t voxels = grid->summary().active_voxels;
  return content_of(voxels, voxels > 0 && has_value(*grid));
}

GridInfo grid_info(GridFile& file, const GridEntry& entry, bool values) {
  GridInfo info;
  info.name = entry.name;
  info.type = printable(entry.descriptor.gridType());
  info.value_type = value_type_of(info.type);
  info.channels = channels_of(info.type);
  info.saved_as_half = entry.descriptor.saveFloatAsHalf();
  info.problem = entry.problem;
  if (!entry.problem.empty()) return info;

  try {
    const auto grid = file.open(entry);
    if (values) info.values = statistics_of(*grid);
    info.values_read = values;
    const GridSummary& summary = grid->summary();
    const openvdb::GridBase& head = grid->head();
    info.grid_class = openvdb::GridBase::gridClassToString(head.getGridClass());
    info.active_voxels = summary.active_voxels;
    info.leaves = summary.leaves;
    info.active_tiles = summary.active_tiles;
    info.active_box = summary.active_box;
    info.background = summary.background[0];
    set_transform(head.transform(), info);
    info.metadata = other_metadata(head);
    info.problem = problem_of(head, summary);
  } catch (const Error& e) {
    info.problem = without_subject(e.what(), file.path(), entry.name);  // the row names the grid
  }
  return info;
}

}  // namespace psivox::vdb
