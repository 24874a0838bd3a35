#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "reader.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

/// Active voxels of a grid in memory: those with data that is not 0.
LeafMask active_mask(const float* values, int channels) {
  LeafMask mask;
  for (std::size_t i = 0; i < kLeafVoxels; ++i, values += channels)
    if (std::any_of(values, values + channels, is_active)) mask.set_on(i);
  return mask;
}

using Copies = std::vector<std::shared_ptr<float[]>>;

/// Surveys the leaves. Others may read the field's values: a leaf with bad ones gets a copy, which
/// the field keeps.
ValueSurvey survey_leaves(Field& field, LeafSurvey& survey, GridRole role, Copies& copies) {
  std::vector<TileValue> tiles;
  for (const Tile& tile : field.tiles) tiles.push_back({tile.value.x, tile_voxels(tile)});
  copies.resize(field.leaves.size());
  const auto each = [&](const auto& look) {
    tbb::parallel_for(std::size_t{0}, copies.size(), [&](std::size_t n) {
      look(n, OrderedValues(field, field.leaves[n]).data());
    });
  };
  const auto take = [&](std::size_t n) {
    Leaf& leaf = field.leaves[n];
    const OrderedValues values(field, leaf);
    const LeafMask active = active_mask(values.data(), field.channels);
    if (all_good({values.begin(), values.end()}, role) && !survey.holds_fill(values.data()))
      return survey.look(values.data(), active);
    copies[n] = std::make_shared_for_overwrite<float[]>(values.size());
    std::ranges::copy(values, copies[n].get());
    leaf.values = copies[n].get();
    return survey.take(copies[n].get(), active);
  };
  return vdb::survey_leaves(survey, copies.size(), tiles, field.active_voxels, each, take);
}

/// Calls take(value, count) for the first channel of the active voxels of `stored`, as `field` has
/// them.
template <typename Take>
void visit_active(const Field& stored, const Field& field, const Take& take) {
  for (std::size_t n = 0; n < stored.leaves.size(); ++n) {
    const OrderedValues before(stored, stored.leaves[n]), after(field, field.leaves[n]);
    const LeafMask active = active_mask(before.data(), stored.channels);
    each_on(active, [&](std::size_t i) { take(after[i * std::size_t(stored.channels)], 1); });
  }
  for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
}

/// Statistics of the voxels other than 0.
std::optional<ValueStatistics> statistics_of(const Field& field) {
  std::vector<Statistics> leaves(field.leaves.size());
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t n) {
    const OrderedValues values(field, field.leaves[n]);
    leaves[n].add(values.data(), field.channels, active_mask(values.data(), field.channels));
  });
  Statistics found;
  for (const Statistics& leaf : leaves) found.add(leaf);
  for (const Tile& tile : field.tiles) found.add(&tile.value.x, field.channels, tile_voxels(tile));
  return found.all();
}

/// 1 where a voxel is not 0.
Field activity_of(const Field& field) {
  Field active = field;
  for (Tile& tile : active.tiles) tile.value = glm::vec3(1, 0, 0);
  active.name += ":active";
  active.value_type = "float";
  active.channels = 1;
  fill_leaves(active, [&](std::size_t n, float* to) {
    const LeafMask mask = active_mask(OrderedValues(field, field.leaves[n]).data(), field.channels);
    for (std::size_t i = 0; i < kLeafVoxels; ++i) to[i] = mask.is_on(i);
  });
  active.active_range = glm::vec2(1);
  active.stored_range.reset();
  return active;
}

class FieldReader final : public Reader {
 public:
  explicit FieldReader(FieldSource source) : source_(std::move(source)) {}

  FileFacts facts() override { return source_.facts; }

  GridInfo info(const std::string& grid, bool values) override {
    const GridFacts& facts = facts_of(grid);
    GridInfo info;
    info.name = facts.name;
    info.type = source_.type;
    info.value_type = facts.value_type;
    info.grid_class = facts.grid_class;
    info.channels = facts.channels;
    info.values_read = values;
    try {
      const auto field = this->field(facts);
      info.active_voxels = field->active_voxels;
      info.leaves = field->leaves.size();
      info.active_tiles = field->tiles.size();
      info.active_box = field->active_box;
      info.transform = "AffineMap";
      set_linear(field->world_from_index, info);
      if (values) info.values = statistics_of(*field);
      if (field->active_voxels == 0) info.problem = "has no data other than 0";
    } catch (const Error& error) {
      info.problem = without_subject(error.what(), source_.path, facts.name);
    }
    return info;
  }

  GridContent content(const std::string& grid) override {
    const auto field = this->field(facts_of(grid));
    return content_of(field->active_voxels, field->active_voxels > 0);
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    const auto stored = field(facts_of(grid));
    Field field = *stored;
    const std::string about =
        source_.path.empty() ? "grid '" + field.name + "' " : subject(source_.path, field.name);
    if (field.active_voxels == 0) {
      if (!options.empty) throw Error(ExitCode::input, about + "has no data other than 0");
      field.active_box = {glm::ivec3(0), glm::ivec3(0)};
      return field;
    }
    if (options.active) {
      field = activity_of(field);
      for (const double percent : options.percentiles) field.active_percentiles[percent] = 1;
      return field;
    }
    if (options.role == GridRole::data && field.array_box) {
      field.active_box = *field.array_box;
      field.margin = 0;
    }
    LeafSurvey survey(options, field.channels);
    const auto copies = std::make_shared<Copies>();
    ValueSurvey found = survey_leaves(field, survey, options.role, *copies);
    if (std::ranges::any_of(*copies, [](const auto& copy) { return copy != nullptr; }))
      field.storage =
          std::make_shared<std::pair<Storage, std::shared_ptr<const void>>>(field.storage, copies);
    found = found + survey_tiles(field, survey, /*keep_zeros=*/true);
    for (const Tile& tile : field.tiles) found.active.add(tile.value.x);
    const float largest = settle(field, found, options, about);
    for (const auto& copy : *copies)
      if (copy) replace_infinite(copy.get(), kLeafVoxels * std::size_t(field.channels), largest);
    set_percentiles(field, options.percentiles,
                    [&](const auto& take) { visit_active(*stored, field, take); });
    return field;
  }

 private:
  const GridFacts& facts_of(const std::string& grid) const {
    return named(source_.facts.grids, grid, source_.path);
  }

  std::shared_ptr<const Field> field(const GridFacts& facts) {
    const std::lock_guard lock(mutex_);
    if (last_grid_ != &facts) {
      last_.reset();  // before another takes memory
      last_grid_ = nullptr;
      last_ = source_.make(std::size_t(&facts - source_.facts.grids.data()));
      last_grid_ = &facts;
    }
    return last_;
  }

  FieldSource source_;
  std::mutex mutex_;  ///< of what follows
  std::shared_ptr<const Field> last_;
  const GridFacts* last_grid_ = nullptr;  ///< whose field that is
};

/// Reads grids of other files.
class GatheredReader final : public Reader {
 public:
  explicit GatheredReader(std::vector<NamedGrid> grids) : grids_(std::move(grids)) {
    for (std::size_t n = 0; n < grids_.size(); ++n)
      for (std::size_t m = 0; m < n; ++m)
        if (grids_[n].name == grids_[m].name)
          throw Error(ExitCode::usage, "two grids have the name " + in_quotes(grids_[n].name));
  }

  FileFacts facts() override {
    FileFacts facts;
    for (const NamedGrid& grid : grids_) {
      facts.grids.push_back({grid.name, grid.name, grid.file->channels(grid.grid),
                             grid.file->value_type(grid.grid), grid.file->grid_class(grid.grid)});
      if (facts.z_up.empty()) facts.z_up = grid.file->z_up();
    }
    return facts;
  }

  GridInfo info(const std::string& grid, bool values) override {
    const NamedGrid& own = named(grids_, grid, "");
    const std::vector<GridInfo> rows = own.file->info(values);
    GridInfo row = named(rows, own.grid, "");
    row.name = grid;
    return row;
  }

  GridContent content(const std::string& grid) override {
    const NamedGrid& own = named(grids_, grid, "");
    return own.file->content(own.grid);
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    const NamedGrid& own = named(grids_, grid, "");
    Field field = own.file->read(own.grid, options);
    field.name = own.name + (options.active ? ":active" : "");
    return field;
  }

 private:
  std::vector<NamedGrid> grids_;
};

}  // namespace

std::unique_ptr<Reader> field_reader(FieldSource source) {
  return std::make_unique<FieldReader>(std::move(source));
}

std::unique_ptr<Reader> gathered_reader(std::vector<NamedGrid> grids) {
  return std::make_unique<GatheredReader>(std::move(grids));
}

}  // namespace psivox::vdb
