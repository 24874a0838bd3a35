#include "read_grid.h"

#include <glm/vector_relational.hpp>
#include <sstream>

#include "background.h"
#include "conform.h"
#include "grid_check.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "sanitise.h"
#include "tree_parts.h"

namespace psivox::vdb {
namespace {

/// Throws if the grid cannot be rendered.
void refuse(const openvdb::GridBase& grid, const GridSummary& summary, const std::string& subject) {
  const std::string problem = problem_of(grid, summary);
  if (!problem.empty()) throw Error(ExitCode::input, subject + problem);
}

/// Converts a level set to fog or, if the options say so, to distances. Adds a notice.
openvdb::GridBase::Ptr without_level_set(const openvdb::GridBase::Ptr& grid,
                                         const ReadOptions& options, Field& field,
                                         std::string& notice) {
  if (!options.distances) {
    notice = "level set converted to fog: 0 at its surface, 1 at the depth of its narrow band";
    return fog_from_level_set(grid);
  }
  field.half_width = summarise(*grid).background[0];
  std::ostringstream text;
  text << "level set kept as distances, which it has within " << field.half_width
       << " [world units] of its surface";
  notice = text.str();
  return distances_from_level_set(grid);
}

/// Sets leaves, tiles, storage and, under GridRole::data, the range. Returns what was replaced.
BadValues take_values(const openvdb::GridBase::Ptr& grid, const ReadOptions& options,
                      Field& field) {
  const GridRole role = options.role;
  const TreeParts parts = parts_of(grid);
  field.storage = parts.storage;
  field.leaves.reserve(parts.leaves.size());
  for (std::size_t n = 0; n < parts.leaves.size(); ++n)
    field.leaves.push_back({to_ivec3(parts.origins[n]), parts.leaves[n]});
  const Box domain = field.domain();
  for (const TilePart& part : parts.tiles) {
    const Tile& tile = part.tile;
    // A background has tiles without number outside the domain.
    const bool outside =
        options.background && (glm::any(glm::greaterThan(tile.origin, domain.max)) ||
                               glm::any(glm::lessThan(tile.origin + (tile.width - 1), domain.min)));
    if (tile.value != glm::vec3(0.0f) && !outside) field.tiles.push_back(tile);
  }
  const BadValues bad = sanitise(parts.leaves, field.tiles, field.channels, role);
  if (bad.any())
    std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  if (role == GridRole::data) field.active_range = active_range(parts);
  field.active_percentiles = active_percentiles(parts, options.percentiles);
  return bad;
}

std::string notice_of(const std::string& name, const std::string& text) {
  return "grid '" + name + "': " + text;
}

void add_class_notices(const openvdb::GridBase& grid, Field& field) {
  if (grid.getGridClass() == openvdb::GRID_STAGGERED)
    field.notices.push_back(notice_of(
        field.name,
        "its class is 'staggered', but its components are taken at voxels, not at their faces"));
  if (is_fog_of_wrong_class(grid))
    field.notices.push_back(
        notice_of(field.name, "its class is 'level set', but its background is 0: taken as fog"));
}

void set_place(const openvdb::GridBase& grid, const GridSummary& summary, Field& field) {
  field.active_box = summary.active_box;
  field.active_voxels = summary.active_voxels;
  field.world_from_index = world_from_index(grid.transform());
}

}  // namespace

Field field_of_head(const openvdb::GridBase& grid, const std::string& name,
                    const GridSummary& summary) {
  Field field;
  field.name = name;
  field.value_type = value_type_of(grid.type());
  field.channels = summary.channels;
  set_place(grid, summary, field);
  add_class_notices(grid, field);
  return field;
}

Field field_from_grid(openvdb::GridBase::Ptr grid, const std::string& name,
                      const std::string& subject, const ReadOptions& options) {
  complete_level_set(*grid);
  GridSummary summary = summarise(*grid);
  Field field;
  field.name = name;
  field.value_type = value_type_of(grid->type());
  field.channels = summary.channels;
  if (options.empty && summary.channels > 0 && summary.active_voxels == 0) {
    field.active_box = {glm::ivec3(0), glm::ivec3(0)};
    if (grid->transform().isLinear()) field.world_from_index = world_from_index(grid->transform());
    return field;
  }
  const auto notice = [&](const std::string& text) {
    field.notices.push_back(notice_of(name, text));
  };
  if (const auto background = other_background(*grid, summary, options, subject)) {
    try {
      take_background(*grid, summary, *background);
    } catch (const std::exception& e) {
      throw Error(ExitCode::input, subject + e.what());
    }
    notice(background_notice(summary, options));
    summary = summarise(*grid);
  }
  refuse(*grid, summary, subject);

  add_class_notices(*grid, field);
  if (is_level_set(*grid)) {
    std::string done;
    grid = without_level_set(grid, options, field, done);
    notice(done);
    summary = summarise(*grid);
    if (summary.active_voxels == 0) {
      throw Error(ExitCode::input, subject + "is a level set without an inside: nothing to render");
    }
  }
  if (!grid->transform().isLinear()) {
    if (options.strict) {
      throw Error(ExitCode::input, subject +
                                       "has a frustum transform, which strict reading does"
                                       " not resample; resample it where the file is made");
    }
    std::string done;
    try {
      grid = resample_to_linear(grid, done);
    } catch (const std::exception& e) {
      throw Error(ExitCode::input, subject + e.what());
    }
    notice(done);
    summary = summarise(*grid);
    refuse(*grid, summary, subject);
  }

  set_place(*grid, summary, field);
  const BadValues bad = take_values(grid, options, field);
  if (bad.any()) {
    if (options.strict) {
      throw Error(ExitCode::input, subject + "is refused by strict reading: " + bad.describe());
    }
    notice(bad.describe());
    field.replaced = bad;
  }
  return field;
}

}  // namespace psivox::vdb
