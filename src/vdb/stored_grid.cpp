#include "stored_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <utility>

#include "grid_types.h"
#include "leaf_decoder.h"
#include "psivox/error.h"
#include "psivox/text.h"
#include "psivox/value_percentile.h"
#include "read_grid.h"
#include "sanitise.h"
#include "topology.h"

namespace psivox::vdb {
namespace {

constexpr std::uint64_t most_kept = 32 << 20;  // of the file's bytes
constexpr std::size_t batch_leaves = 2048;     // 4 MiB of values
/// A leaf is two masks and a byte in the file at least, so that its values take no more than this
/// times its bytes, for each channel.
constexpr std::uint64_t most_growth = kLeafVoxels * sizeof(float) / 129 + 1;

/// Least and greatest of some values; +Inf, whose replacement is found last, is only noted.
struct Extent {
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();
  bool infinite = false;

  void add(float value) {
    if (std::isinf(value)) {
      infinite = true;
      return;
    }
    min = std::min(min, value);
    max = std::max(max, value);
  }
  glm::vec2 range(float largest) const {
    if (!infinite) return {min, max};
    return {std::min(min, largest), std::max(max, largest)};
  }
  Extent operator+(const Extent& other) const {
    return {std::min(min, other.min), std::max(max, other.max), infinite || other.infinite};
  }
};

/// What one pass over the values finds out.
struct ValueFacts {
  BadValues bad;
  float largest = 0;  ///< finite value of any channel
  Extent all;         ///< first channel
  Extent active;      ///< of active voxels
  Extent in_box;      ///< of voxels in the box of active ones

  ValueFacts operator+(const ValueFacts& other) const {
    return {bad + other.bad, std::max(largest, other.largest), all + other.all,
            active + other.active, in_box + other.in_box};
  }
};

bool in_box(const Box& box, const glm::ivec3& voxel) {
  return glm::clamp(voxel, box.min, box.max) == voxel;
}

/// Counts a leaf's values, which become sanitised.
void add_leaf(const glm::ivec3& origin, float* values, const LeafMask& active, int channels,
              float smallest, const Box& box, ValueFacts& facts) {
  facts.bad = facts.bad + sanitise_leaf(values, channels, smallest);
  const auto stride = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < kLeafVoxels * stride; ++i)
    if (std::isfinite(values[i])) facts.largest = std::max(facts.largest, values[i]);
  const bool inside = in_box(box, origin) && in_box(box, origin + 7);
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const float value = values[i * stride];
    const int n = static_cast<int>(i);
    facts.all.add(value);
    if (active.isOn(static_cast<openvdb::Index>(n))) facts.active.add(value);
    if (inside || in_box(box, origin + glm::ivec3(n >> 6, n >> 3 & 7, n & 7)))
      facts.in_box.add(value);
  }
}

/// Some leaves with their values.
struct Batch {
  std::size_t first = 0, count = 0;
  std::vector<float> values;
  std::vector<LeafMask> active;
};

class FileLeaves final : public LeafReader {
 public:
  FileLeaves(std::shared_ptr<FileBlocks> file, openvdb::GridBase::Ptr empty,
             const openvdb::io::StreamMetadata& settings, std::string subject, float smallest)
      : decoder_(std::move(file), std::move(empty), settings),
        subject_(std::move(subject)),
        smallest_(smallest) {}

  /// Finds the leaves' places, and visits their values on the way.
  void find(std::size_t leaves, std::istream& stream, FileBuffer& buffer,
            const std::function<void(Batch&)>& visit) {
    places_.reserve(leaves);
    for_batches(leaves, visit, [&](std::size_t end) {
      while (places_.size() < end) {
        places_.push_back(stream.tellg());
        decoder_.skip(stream);
      }
      buffer.read_to(stream.tellg());
    });
  }

  /// Visits all values, as the file has them.
  void visit(const std::function<void(Batch&)>& visit) const {
    for_batches(places_.size(), visit, [](std::size_t) {});
  }

  void replace_infinite(float largest) { largest_ = largest; }

  void read(std::span<const std::uint32_t> leaves, float* values) const override {
    std::vector<std::int64_t> places;
    places.reserve(leaves.size());
    for (const std::uint32_t leaf : leaves) places.push_back(places_[leaf]);
    try {
      decoder_.decode(places, values, nullptr);
    } catch (const std::exception& e) {
      throw Error(ExitCode::input, subject_ + "cannot be read again: " + e.what());
    }
    const int channels = decoder_.channels();
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t n) {
      const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
      float* const leaf = values + n * length;
      if (sanitise_leaf(leaf, channels, smallest_).positive_infinite == 0) return;
      for (std::size_t i = 0; i < length; ++i) leaf[i] = std::min(leaf[i], largest_);
    });
  }

 private:
  void for_batches(std::size_t leaves, const std::function<void(Batch&)>& visit,
                   const std::function<void(std::size_t end)>& prepare) const {
    Batch batch;
    const std::size_t length = kLeafVoxels * static_cast<std::size_t>(decoder_.channels());
    for (; batch.first < leaves; batch.first += batch.count) {
      batch.count = std::min(batch_leaves, leaves - batch.first);
      batch.values.resize(batch.count * length);
      batch.active.resize(batch.count);
      prepare(batch.first + batch.count);
      decoder_.decode(std::span(places_).subspan(batch.first, batch.count), batch.values.data(),
                      batch.active.data());
      visit(batch);
    }
  }

  LeafDecoder decoder_;
  std::string subject_;
  float smallest_, largest_ = 1;
  std::vector<std::int64_t> places_;
};

/// Sanitised values of the active voxels, for percentiles.
template <typename Take>
void each_active(const FileLeaves& leaves, const Topology& topology, float smallest, float largest,
                 const Take& take) {
  const int channels = topology.summary.channels;
  leaves.visit([&](Batch& batch) {
    const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
    for (std::size_t n = 0; n < batch.count; ++n) {
      float* values = batch.values.data() + n * length;
      sanitise_leaf(values, channels, smallest);
      for (auto on = batch.active[n].beginOn(); on; ++on)
        take(std::min(values[on.pos() * static_cast<std::size_t>(channels)], largest), 1);
    }
  });
  for (const TilePart& part : topology.tiles)
    if (part.active) take(part.tile.value.x, tile_voxels(part.tile));
}

ValueFacts facts_of(const Batch& batch, float* values, const Topology& topology, float smallest) {
  const int channels = topology.summary.channels;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, batch.count, 64), ValueFacts(),
      [&](const auto& some, ValueFacts facts) {
        for (std::size_t n = some.begin(); n != some.end(); ++n)
          add_leaf(topology.leaves[batch.first + n],
                   values + n * kLeafVoxels * static_cast<std::size_t>(channels), batch.active[n],
                   channels, smallest, topology.summary.active_box, facts);
        return facts;
      },
      std::plus<>());
}

/// Sets tiles, ranges and percentiles, and reports bad values.
void take_facts(ValueFacts facts, const Topology& topology, const ReadOptions& options,
                FileLeaves& leaves, const std::string& subject, Field& field) {
  for (const TilePart& part : topology.tiles) {
    if (part.tile.value != glm::vec3(0.0f)) field.tiles.push_back(part.tile);
    if (part.active && std::isfinite(part.tile.value.x)) facts.active.add(part.tile.value.x);
    for (int c = 0; c < field.channels; ++c)
      if (const float value = part.tile.value[c]; std::isfinite(value))
        facts.largest = std::max(facts.largest, value);
  }
  const BadValues of_tiles = sanitise({}, field.tiles, field.channels, options.role, facts.largest);
  facts.bad = facts.bad + of_tiles;
  facts.bad.largest = facts.largest > 0 ? facts.largest : 1;
  std::erase_if(field.tiles, [](const Tile& tile) { return tile.value == glm::vec3(0.0f); });
  leaves.replace_infinite(facts.bad.largest);
  if (facts.bad.any()) {
    if (options.strict)
      throw Error(ExitCode::input,
                  subject + "is refused by strict reading: " + facts.bad.describe());
    field.notices.push_back("grid '" + field.name + "': " + facts.bad.describe());
  }
  facts.all.add(0);
  for (const Tile& tile : field.tiles) {
    facts.all.add(tile.value.x);
    facts.in_box.add(tile.value.x);
  }
  const float largest = facts.bad.largest;
  field.stored_range = facts.all.range(largest);
  field.active_range =
      (options.role == GridRole::data ? facts.active : facts.in_box).range(largest);
  const float smallest = smallest_good(options.role);
  for (const double percent : options.percentiles)
    field.active_percentiles[percent] = value_percentile(
        [&](const auto& take) { each_active(leaves, topology, smallest, largest, take); }, percent);
}

/// Why a grid must be converted whole; empty if it need not be.
std::string why_whole(const openvdb::GridBase& grid, const GridSummary& summary) {
  if (is_level_set(grid)) return "a level set is converted whole";
  if (!grid.transform().isLinear()) return "a frustum transform is resampled whole";
  if (has_background(grid, summary)) return "a background is replaced in the whole grid";
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
  const openvdb::GridBase::Ptr grid = archive.begin_tree(entry);
  if (!grid) return {};
  Topology topology;
  archive.guarded(entry, [&] { topology = read_topology(*grid, archive.stream()); });
  const GridSummary& summary = topology.summary;
  const std::uint64_t bytes = summary.leaves * kLeafVoxels * sizeof(float) * channels;
  if ((!must && bytes <= options.memory) || summary.active_voxels == 0) return {};
  const std::string subject = archive.subject(entry.name);
  if (const std::string why = why_whole(*grid, summary); !why.empty()) {
    if (must || bytes <= 2 * options.memory ||
        (has_background(*grid, summary) && !options.background))
      return {};
    throw Error(ExitCode::memory, subject + "has values of " + mebibytes(bytes) +
                                      ", more than the memory limit leaves room for, and " + why);
  }
  if (const std::string problem = problem_of(*grid, summary); !problem.empty())
    throw Error(ExitCode::input, subject + problem);

  if (options.memory) file->keep_at_most(std::int64_t(std::min(most_kept, options.memory / 8)));
  Field field = field_of_head(*grid, entry.name, summary);
  const float smallest = smallest_good(options.role);
  const auto leaves = std::make_shared<FileLeaves>(
      file, grid, openvdb::io::StreamMetadata(archive.stream()), subject, smallest);
  ValueFacts facts;
  archive.guarded(entry, [&] {
    leaves->find(topology.leaves.size(), archive.stream(), archive.buffer(), [&](Batch& batch) {
      facts = facts + facts_of(batch, batch.values.data(), topology, smallest);
    });
    take_facts(facts, topology, options, *leaves, subject, field);
  });
  field.leaves.reserve(topology.leaves.size());
  for (const glm::ivec3& origin : topology.leaves) field.leaves.push_back({origin, nullptr});
  field.reader = leaves;
  return field;
}

}  // namespace psivox::vdb
