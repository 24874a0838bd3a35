#include "field_reader.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "grid_content.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "psivox/text.h"
#include "psivox/value_percentile.h"
#include "sanitise.h"

namespace psivox::vdb {
namespace {

std::string subject_of(const Field& field) { return "grid '" + field.name + "'"; }

/// Leaves with values that sanitise replaces, and the largest value of the others.
struct BadLeaves {
  std::vector<std::size_t> numbers;
  float largest_elsewhere = 0;
};

BadLeaves bad_leaves(const Field& field, GridRole role) {
  struct Found {
    bool good;
    float largest;
  };
  std::vector<Found> found(field.leaves.size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t n) {
    const OrderedValues values(field, field.leaves[n]);
    const bool good = all_good(values, role);
    found[n] = {good, good ? *std::ranges::max_element(values) : 0};
  });
  BadLeaves bad;
  for (std::size_t n = 0; n < found.size(); ++n) {
    if (found[n].good)
      bad.largest_elsewhere = std::max(bad.largest_elsewhere, found[n].largest);
    else
      bad.numbers.push_back(n);
  }
  return bad;
}

bool has_bad_tile(const Field& field, GridRole role) {
  return std::ranges::any_of(field.tiles, [&](const Tile& tile) {
    return !all_good({&tile.value.x, static_cast<std::size_t>(field.channels)}, role);
  });
}

/// Others may read the field's values: these leaves get copies.
std::vector<float*> with_own_values(const std::vector<std::size_t>& numbers, Field& field) {
  const std::size_t floats = kLeafVoxels * static_cast<std::size_t>(field.channels);
  const auto values = std::make_shared_for_overwrite<float[]>(numbers.size() * floats);
  std::vector<float*> leaves;
  for (const std::size_t n : numbers) {
    leaves.push_back(values.get() + leaves.size() * floats);
    copy_values(values_of(field, field.leaves[n]), field.channels, leaves.back());
    field.leaves[n].values = leaves.back();
  }
  field.storage = std::make_shared<std::array<std::shared_ptr<const void>, 2>>(
      std::array<std::shared_ptr<const void>, 2>{field.storage, values});
  return leaves;
}

/// Calls take(value, count) for the first channel of the active voxels of `stored`, as `field` has
/// them.
template <typename Take>
void visit_active(const Field& stored, const Field& field, const Take& take) {
  const int channels = stored.channels;
  for (std::size_t n = 0; n < stored.leaves.size(); ++n) {
    const OrderedValues before(stored, stored.leaves[n]), after(field, field.leaves[n]);
    const float *was = before.data(), *is = after.data();
    for (std::size_t i = 0; i < kLeafVoxels; ++i, was += channels, is += channels)
      if (std::any_of(was, was + channels, [](float value) { return value != 0; })) take(*is, 1);
  }
  for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
}

/// 1 where a voxel is not 0.
Field activity_of(const Field& field) {
  Field active = field;
  const auto channels = static_cast<std::size_t>(field.channels);
  const auto values = std::make_shared_for_overwrite<float[]>(field.leaves.size() * kLeafVoxels);
  for (std::size_t n = 0; n < field.leaves.size(); ++n) {
    const OrderedValues own(field, field.leaves[n]);
    float* const to = values.get() + n * kLeafVoxels;
    for (std::size_t i = 0; i < kLeafVoxels; ++i)
      to[i] = std::any_of(own.data() + i * channels, own.data() + (i + 1) * channels,
                          [](float value) { return value != 0; });
    active.leaves[n].values = to;
  }
  for (Tile& tile : active.tiles) tile.value = glm::vec3(1, 0, 0);
  active.name += ":active";
  active.value_type = "float";
  active.channels = 1;
  active.array.reset();
  active.storage = values;
  active.active_range = glm::vec2(1);
  active.stored_range.reset();
  return active;
}

}  // namespace

FileFacts FieldReader::facts() {
  FileFacts facts;
  facts.names = facts.base_names = {field_->name};
  facts.channels = {field_->channels};
  facts.value_types = {field_->value_type};
  facts.classes = {"unknown"};
  return facts;
}

std::vector<GridInfo> FieldReader::info(bool values) {
  GridInfo info;
  info.name = field_->name;
  info.value_type = field_->value_type;
  info.grid_class = "unknown";
  info.channels = field_->channels;
  info.active_voxels = field_->active_voxels;
  info.leaves = field_->leaves.size();
  info.active_tiles = field_->tiles.size();
  info.active_box = field_->active_box;
  info.world_from_index = field_->world_from_index;
  info.values_read = values;
  for (int axis = 0; axis < 3; ++axis)
    info.voxel_size[axis] = glm::length(glm::dvec3(field_->world_from_index[axis]));
  if (field_->active_voxels == 0) info.problem = "has no voxel other than 0";
  return {info};
}

GridContent FieldReader::content(const std::string& grid) {
  check_name(grid);
  return content_of(field_->active_voxels, field_->active_voxels > 0);
}

void FieldReader::check_name(const std::string& grid) const {
  if (grid == field_->name) return;
  throw Error(ExitCode::input,
              "there is no grid " + in_quotes(grid) + "; there is only " + in_quotes(field_->name));
}

Field FieldReader::read(const std::string& grid, const ReadOptions& options) {
  check_name(grid);
  Field field = *field_;
  if (field.active_voxels == 0) {
    if (!options.empty)
      throw Error(ExitCode::input, subject_of(field) + " has no voxel other than 0");
    field.active_box = {glm::ivec3(0), glm::ivec3(0)};
    return field;
  }
  if (options.active) {
    field = activity_of(field);
    for (const double percent : options.percentiles) field.active_percentiles[percent] = 1;
    return field;
  }
  const BadLeaves leaves = bad_leaves(field, options.role);
  if (!leaves.numbers.empty() || has_bad_tile(field, options.role)) {
    const BadValues bad = sanitise(with_own_values(leaves.numbers, field), field.tiles,
                                   field.channels, options.role, leaves.largest_elsewhere);
    if (options.strict)
      throw Error(ExitCode::input,
                  subject_of(field) + " is refused by strict reading: " + bad.describe());
    field.notices.push_back(subject_of(field) + ": " + bad.describe());
    field.replaced = bad;
  }
  if (options.role == GridRole::data) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    glm::vec2 range(infinity, -infinity);
    visit_active(*field_, field, [&](float value, std::uint64_t) {
      range = {std::min(range.x, value), std::max(range.y, value)};
    });
    field.active_range = range;
  }
  const std::vector<double> values = value_percentiles(
      [&](const auto& take) { visit_active(*field_, field, take); }, options.percentiles);
  for (std::size_t i = 0; i < values.size(); ++i)
    field.active_percentiles[options.percentiles[i]] = values[i];
  return field;
}

GatheredReader::GatheredReader(std::vector<NamedGrid> grids) : grids_(std::move(grids)) {
  for (std::size_t n = 0; n < grids_.size(); ++n)
    for (std::size_t m = 0; m < n; ++m)
      if (grids_[n].name == grids_[m].name)
        throw Error(ExitCode::usage, "two grids have the name " + in_quotes(grids_[n].name));
}

FileFacts GatheredReader::facts() {
  FileFacts facts;
  for (const NamedGrid& grid : grids_) {
    facts.names.push_back(grid.name);
    facts.channels.push_back(grid.file->channels(grid.grid));
    facts.value_types.push_back(grid.file->value_type(grid.grid));
    facts.classes.push_back(grid.file->grid_class(grid.grid));
    if (facts.z_up.empty()) facts.z_up = grid.file->z_up();
  }
  facts.base_names = facts.names;
  return facts;
}

std::vector<GridInfo> GatheredReader::info(bool values) {
  std::vector<GridInfo> rows;
  for (const NamedGrid& grid : grids_)
    for (GridInfo& row : grid.file->info(values)) {
      if (row.name != grid.grid) continue;
      row.name = grid.name;
      rows.push_back(std::move(row));
    }
  return rows;
}

GridContent GatheredReader::content(const std::string& grid) {
  const NamedGrid& named = find(grid);
  return named.file->content(named.grid);
}

Field GatheredReader::read(const std::string& grid, const ReadOptions& options) {
  const NamedGrid& named = find(grid);
  Field field = named.file->read(named.grid, options);
  field.name = named.name + (options.active ? ":active" : "");
  return field;
}

const NamedGrid& GatheredReader::find(const std::string& grid) const {
  std::vector<std::string> names;
  for (const NamedGrid& named : grids_) {
    names.push_back(named.name);
    if (named.name == grid) return named;
  }
  throw Error(ExitCode::input, "there is no grid " + in_quotes(grid) + suggestion(grid, names) +
                                   "; there are " + joined(names, ", "));
}

}  // namespace psivox::vdb
