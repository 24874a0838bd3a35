#include "field_reader.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/text.h"
#include "field/value_percentile.h"
#include "grid_info.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

/// Active voxels of a grid in memory: those that are not 0.
LeafMask active_mask(const float* values, int channels) {
  LeafMask mask;
  for (openvdb::Index i = 0; i < kLeafVoxels; ++i, values += channels)
    if (std::any_of(values, values + channels, [](float value) { return value != 0; }))
      mask.setOn(i);
  return mask;
}

/// Surveys the leaves. Others may read the field's values: a leaf with bad ones gets a copy, which
/// is returned.
std::vector<float*> survey_leaves(Field& field, const LeafSurvey& survey, GridRole role,
                                  ValueSurvey& found) {
  const std::size_t floats = kLeafVoxels * static_cast<std::size_t>(field.channels);
  std::vector<char> bad(field.leaves.size());
  SurveySum sum;
  tbb::parallel_for(std::size_t{0}, bad.size(), [&](std::size_t n) {
    const OrderedValues values(field, field.leaves[n]);
    bad[n] = !all_good(values, role);
    if (!bad[n])
      sum.add(survey.look(field.leaves[n].origin, values.data(),
                          active_mask(values.data(), field.channels)));
  });
  std::vector<float*> copies;
  const auto count = static_cast<std::size_t>(std::ranges::count(bad, 1));
  const auto storage = std::make_shared_for_overwrite<float[]>(count * floats);
  for (std::size_t n = 0; n < bad.size(); ++n) {
    if (!bad[n]) continue;
    float* const copy = storage.get() + copies.size() * floats;
    copies.push_back(copy);
    copy_values(values_of(field, field.leaves[n]), field.channels, copy);
    field.leaves[n].values = copy;
    sum.add(survey.take(field.leaves[n].origin, copy, active_mask(copy, field.channels)));
  }
  if (count > 0)
    field.storage = std::make_shared<std::array<std::shared_ptr<const void>, 2>>(
        std::array<std::shared_ptr<const void>, 2>{field.storage, storage});
  found = sum.total();
  return copies;
}

/// Calls take(value, count) for the first channel of the active voxels of `stored`, as `field` has
/// them.
template <typename Take>
void visit_active(const Field& stored, const Field& field, const Take& take) {
  for (std::size_t n = 0; n < stored.leaves.size(); ++n) {
    const OrderedValues before(stored, stored.leaves[n]), after(field, field.leaves[n]);
    const LeafMask active = active_mask(before.data(), stored.channels);
    for (auto on = active.beginOn(); on; ++on)
      take(after[on.pos() * std::size_t(stored.channels)], 1);
  }
  for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
}

/// Statistics of the voxels other than 0; of lengths, if there are vectors.
std::optional<ValueStatistics> statistics_of(const Field& field) {
  const auto magnitude = [&](const float* v) {
    return field.channels == 1 ? double(*v) : std::hypot(double(v[0]), double(v[1]), double(v[2]));
  };
  std::vector<Statistics> leaves(field.leaves.size());
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t n) {
    const OrderedValues values(field, field.leaves[n]);
    const LeafMask active = active_mask(values.data(), field.channels);
    for (auto on = active.beginOn(); on; ++on)
      leaves[n].add(magnitude(values.data() + on.pos() * std::size_t(field.channels)), 1);
  });
  Statistics found;
  for (const Statistics& leaf : leaves) found.add(leaf);
  for (const Tile& tile : field.tiles) found.add(magnitude(&tile.value.x), tile_voxels(tile));
  return found.all();
}

/// 1 where a voxel is not 0.
Field activity_of(const Field& field) {
  Field active = field;
  const auto values = std::make_shared_for_overwrite<float[]>(field.leaves.size() * kLeafVoxels);
  for (std::size_t n = 0; n < field.leaves.size(); ++n) {
    const LeafMask mask = active_mask(OrderedValues(field, field.leaves[n]).data(), field.channels);
    float* const to = values.get() + n * kLeafVoxels;
    for (std::size_t i = 0; i < kLeafVoxels; ++i) to[i] = mask.isOn(openvdb::Index(i));
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

FieldReader::FieldReader(const std::shared_ptr<const Field>& field) {
  source_.facts.grids = {{field->name, field->name, field->channels, field->value_type, "unknown"}};
  source_.make = [field](std::size_t) { return field; };
}

std::size_t FieldReader::find(const std::string& grid) const {
  const std::vector<GridFacts>& all = source_.facts.grids;
  for (const auto name : {&GridFacts::name, &GridFacts::base_name}) {
    const auto found = std::ranges::find(all, grid, name);
    if (found != all.end()) return std::size_t(found - all.begin());
  }
  const std::string first = in_quotes(all.front().name);
  throw Error(ExitCode::input,
              (source_.path.empty() ? "" : subject(source_.path)) + "there is no grid " +
                  in_quotes(grid) +
                  (all.size() == 1 ? "; there is only " + first
                                   : "; there are " + first + " to " + in_quotes(all.back().name)));
}

std::shared_ptr<const Field> FieldReader::field(std::size_t number) {
  const std::lock_guard lock(mutex_);
  if (!last_ || last_number_ != number) {
    last_.reset();  // before another takes memory
    last_ = source_.make(number);
    last_number_ = number;
  }
  return last_;
}

GridInfo FieldReader::row(std::size_t number, bool values) {
  const GridFacts& facts = source_.facts.grids[number];
  GridInfo info;
  info.name = facts.name;
  info.type = source_.type;
  info.value_type = facts.value_type;
  info.grid_class = facts.grid_class;
  info.channels = facts.channels;
  info.values_read = values;
  try {
    const auto field = this->field(number);
    info.active_voxels = field->active_voxels;
    info.leaves = field->leaves.size();
    info.active_tiles = field->tiles.size();
    info.active_box = field->active_box;
    info.world_from_index = field->world_from_index;
    info.transform = "AffineMap";
    set_world_box(info);
    for (int axis = 0; axis < 3; ++axis)
      info.voxel_size[axis] = glm::length(glm::dvec3(field->world_from_index[axis]));
    if (values) info.values = statistics_of(*field);
    if (field->active_voxels == 0) info.problem = "has no voxel other than 0";
  } catch (const Error& error) {
    info.problem = without_subject(error.what(), source_.path, facts.name);
  }
  return info;
}

std::vector<GridInfo> FieldReader::info(const std::string& grid, bool values) {
  if (!grid.empty()) return {row(find(grid), values)};
  std::vector<GridInfo> rows;
  for (std::size_t n = 0; n < source_.facts.grids.size(); ++n) rows.push_back(row(n, values));
  return rows;
}

GridContent FieldReader::content(const std::string& grid) {
  const auto field = this->field(find(grid));
  return content_of(field->active_voxels, field->active_voxels > 0);
}

Field FieldReader::read(const std::string& grid, const ReadOptions& options) {
  const std::size_t number = find(grid);
  const auto stored = this->field(number);
  Field field = *stored;
  const std::string about =
      source_.path.empty() ? "grid '" + field.name + "' " : subject(source_.path, field.name);
  if (field.name != grid)
    field.notices.push_back("grid '" + grid + "': " + std::to_string(source_.facts.grids.size()) +
                            " grids have this name; took '" + field.name + "'");
  if (field.active_voxels == 0) {
    if (!options.empty) throw Error(ExitCode::input, about + "has no voxel other than 0");
    field.active_box = {glm::ivec3(0), glm::ivec3(0)};
    return field;
  }
  if (options.active) {
    field = activity_of(field);
    for (const double percent : options.percentiles) field.active_percentiles[percent] = 1;
    return field;
  }
  const LeafSurvey survey(options.role, field.channels, options.role == GridRole::data,
                          field.active_box);
  ValueSurvey found;
  const std::vector<float*> copies = survey_leaves(field, survey, options.role, found);
  found = found + survey_tiles(field, options.role, /*keep_zeros=*/true);
  const float largest = settle(field, found, options, about);
  for (float* const copy : copies)
    replace_infinite(copy, kLeafVoxels * static_cast<std::size_t>(field.channels), largest);
  for (const Tile& tile : field.tiles) found.active.add(tile.value.x);
  if (options.role == GridRole::data) field.active_range = found.active.range(largest);
  set_percentiles(field, options.percentiles,
                  [&](const auto& take) { visit_active(*stored, field, take); });
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
    facts.grids.push_back({grid.name, grid.name, grid.file->channels(grid.grid),
                           grid.file->value_type(grid.grid), grid.file->grid_class(grid.grid)});
    if (facts.z_up.empty()) facts.z_up = grid.file->z_up();
  }
  return facts;
}

std::vector<GridInfo> GatheredReader::info(const std::string&, bool values) {
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
