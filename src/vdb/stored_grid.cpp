#include "stored_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "background.h"
#include "file_leaves.h"
#include "grid_types.h"
#include "psivox/error.h"
#include "psivox/text.h"
#include "psivox/value_percentile.h"
#include "read_grid.h"
#include "sanitise.h"
#include "subject.h"
#include "topology.h"

namespace psivox::vdb {
namespace {

constexpr std::uint64_t most_kept = 32 << 20;  // of the file's bytes
/// A leaf is two masks and a byte in the file at least, so that its values take no more than this
/// times its bytes, for each channel.
constexpr std::uint64_t most_growth = kLeafVoxels * sizeof(float) / 129 + 1;

/// Sanitised values of the active voxels, for percentiles.
template <typename Take>
void each_active(const FileLeaves& leaves, int channels, float smallest, float largest,
                 const Take& take) {
  leaves.visit([&](LeafBatch& batch) {
    const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
    for (std::size_t n = 0; n < batch.count; ++n) {
      float* values = batch.values.data() + n * length;
      sanitise_leaf(values, channels, smallest);
      for (auto on = batch.active[n].beginOn(); on; ++on)
        take(std::min(values[on.pos() * static_cast<std::size_t>(channels)], largest), 1);
    }
  });
  for (const TileValue& tile : leaves.active_tiles()) take(tile.value, tile.voxels);
}

/// Sets tiles, and what is found in them. +Inf stays.
void take_tiles(const Topology& topology, GridRole role, Field& field) {
  ValueSurvey& survey = field.survey.emplace();
  for (const TilePart& part : topology.tiles) {
    if (part.tile.value != glm::vec3(0.0f)) field.tiles.push_back(part.tile);
    if (part.active && std::isfinite(part.tile.value.x)) survey.active.add(part.tile.value.x);
    for (int c = 0; c < field.channels; ++c)
      if (const float value = part.tile.value[c]; std::isfinite(value))
        survey.largest = std::max(survey.largest, value);
  }
  survey.bad = sanitise({}, field.tiles, field.channels, role,
                        /*elsewhere=*/std::numeric_limits<float>::infinity());
  std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  for (const Tile& tile : field.tiles) {
    survey.all.add(tile.value.x);
    survey.in_box.add(tile.value.x);
  }
}

/// Why a grid must be converted whole; empty if it need not be.
std::string why_whole(const openvdb::GridBase& grid, const GridEntry& entry,
                      const std::optional<double>& background, bool active) {
  if (active || is_mask(entry.descriptor.gridType()))
    return "active voxels are marked in the whole";
  if (is_points(entry.descriptor.gridType())) return "points are counted in the whole";
  if (is_level_set(grid)) return "a level set is converted whole";
  if (!grid.transform().isLinear()) return "a frustum transform is resampled whole";
  if (background.value_or(0) != 0) return "a background is replaced in the whole grid";
  return {};
}

}  // namespace

std::optional<Field> stored_field(Archive& archive, const GridEntry& entry,
                                  const std::shared_ptr<FileBlocks>& file,
                                  const ReadOptions& options) {
  const std::int64_t begin = entry.descriptor.getGridPos(), end = entry.descriptor.getEndPos();
  if (begin < 0 || end < begin) return {};  // to read the grid whole says what is wrong
  const auto in_file = std::uint64_t(end - begin);
  const auto channels = std::uint64_t(channels_of(entry.descriptor.gridType()));
  const bool must = options.in_file;
  if (!must && (options.memory == 0 || in_file * most_growth * channels <= options.memory))
    return {};
  std::string delayed_load;
  const openvdb::GridBase::Ptr grid = archive.begin_tree(entry, &delayed_load);
  if (!grid) return {};
  Topology topology;
  archive.guarded(entry, [&] { topology = read_topology(*grid, archive.stream()); });
  const GridSummary& summary = topology.summary;
  const std::uint64_t bytes = summary.leaves * kLeafVoxels * sizeof(float) * channels;
  if ((!must && bytes <= options.memory) || summary.active_voxels == 0) return {};
  const std::string subject = vdb::subject(archive.path(), entry.name);
  const auto background = other_background(*grid, summary, options, subject);
  if (const std::string why = why_whole(*grid, entry, background, options.active); !why.empty()) {
    if (must || bytes <= 2 * options.memory) return {};
    throw Error(ExitCode::memory, subject + "has values of " + mebibytes(bytes) +
                                      ", more than the memory limit leaves room for, and " + why);
  }
  if (const std::string problem = problem_of(*grid, summary); !problem.empty())
    throw Error(ExitCode::input, subject + problem);

  if (options.memory) file->keep_at_most(std::int64_t(std::min(most_kept, options.memory / 8)));
  Field field = field_of_head(*grid, entry.name, summary);
  if (background)
    field.notices.push_back("grid '" + field.name + "': " + background_notice(summary, options));
  take_tiles(topology, options.role, field);
  const float smallest = smallest_good(options.role);
  const openvdb::io::StreamMetadata settings(archive.stream());
  const auto leaves = std::make_shared<FileLeaves>(
      LeafDecoder(file, grid, settings, background.has_value()), subject, smallest);
  std::vector<TileValue> active_tiles;
  for (const TilePart& part : topology.tiles)
    if (part.active) active_tiles.push_back({part.tile.value.x, tile_voxels(part.tile)});
  leaves->set_active_tiles(std::move(active_tiles));
  archive.guarded(entry, [&] {
    if (options.unsurveyed)
      return leaves->find(topology, delayed_load, archive.stream(), archive.buffer(), end);
    ValueSurvey survey;
    leaves->find(topology.leaves.size(), archive.stream(), archive.buffer(), [&](LeafBatch& batch) {
      survey = survey + survey_values(batch.active, batch.values.data(), summary.channels, smallest,
                                      summary.active_box, [&](std::size_t n) {
                                        return topology.leaves[batch.first + n];
                                      });
    });
    const float largest = take_survey(field, survey, options, subject);
    leaves->replace_infinite(largest);
    const std::vector<double> values = value_percentiles(
        [&](const auto& take) { each_active(*leaves, summary.channels, smallest, largest, take); },
        options.percentiles);
    for (std::size_t i = 0; i < values.size(); ++i)
      field.active_percentiles[options.percentiles[i]] = values[i];
  });
  field.leaves.reserve(topology.leaves.size());
  for (const glm::ivec3& origin : topology.leaves) field.leaves.push_back({origin, nullptr});
  field.reader = leaves;
  return field;
}

}  // namespace psivox::vdb
