#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "atlas/atlas_plan.h"
#include "base/memory.h"
#include "field/lane_range.h"

namespace psivox {
namespace {

using atlas::BrickSource;
using atlas::make_plan;
using atlas::Plan;

/// Raises maxima to |v - 2 w + x| of the values `step` before them, at them and `step` behind them.
void raise(float* maxima, const float* at, std::size_t step, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float difference = std::abs(at[i - step] - 2 * at[i] + at[i + step]);
    maxima[i] = maxima[i] < difference ? difference : maxima[i];
  }
}

/// Plane by plane, so that compilers vectorise it: 2.7 times as fast as value by value.
BrickStats measure(const float* values, int channels, bool absent) {
  constexpr std::size_t n = brick_values, plane = n * n;
  const auto stride = std::size_t(channels);
  std::array<float, brick_texels> first;
  if (stride > 1) {
    for (std::size_t i = 0; i < first.size(); ++i) first[i] = values[i * stride];
    values = first.data();
  }
  LaneRange<plane> range;
  std::array<float, plane> across{}, along_z{};
  for (std::size_t x = 0; x < n; ++x) {
    const float* const at = values + x * plane;
    range.include(at);
    if (x > 0 && x < n - 1) raise(across.data(), at, plane, plane);
    raise(across.data() + n, at + n, n, plane - 2 * n);
    raise(along_z.data() + 1, at + 1, 1, plane - 2);
  }
  BrickStats stats{range.least(), range.greatest(), 0};
  for (std::size_t row = 0; row < plane; row += n)  // beside their ends stand other rows' values
    along_z[row] = along_z[row + n - 1] = 0;
  for (std::size_t i = 0; i < plane; ++i)
    stats.second_difference = std::max({stats.second_difference, across[i], along_z[i]});
  if (absent) {
    const float* const end = values + brick_texels;
    stats.absent = std::any_of(values, end, [](float value) { return std::isnan(value); });
    if (stats.absent) stats.second_difference = std::numeric_limits<float>::infinity();
  }
  return stats;
}

/// A bit for each octant of a brick without a visible cell.
std::uint32_t hidden_octants(const float* values, const Visibility& visible) {
  constexpr int half = brick_cells / 2;
  std::uint32_t hidden = 0;
  for (int i = 0; i < 8; i += 2) {
    const int first_x = half * (i >> 2), first_y = half * (i >> 1 & 1);
    LaneRange<(half + 1) * brick_values> planes;  // of two octants, one behind the other along z
    for (int x = first_x; x <= first_x + half; ++x)
      planes.include(values + (x * brick_values + first_y) * brick_values);
    LaneRange<brick_values> rows;
    for (std::size_t at = 0; at < planes.low.size(); at += brick_values)
      rows.include(&planes.low[at], &planes.high[at]);
    for (int k = 0; k < 2; ++k) {
      const auto first = std::size_t(k) * half;
      const ValueRange range{rows.least(first, half + 1), rows.greatest(first, half + 1)};
      if (!sees(visible, range)) hidden |= 1u << (i + k);
    }
  }
  return hidden;
}

/// Marks hidden octants in the page table, where its payloads have the room.
void mark_octants(const AtlasOptions& options, BrickAtlas& result) {
  if (!options.mark_octants || options.companion || !options.walked.empty() ||
      (options.keeps_absent && result.absent) || result.channels > 1 || !result.texels ||
      result.bricks.size() >> entry_slot_bits)
    return;
  const Visibility visible = options.visible ? options.visible : is_not_zero;
  std::vector<std::uint32_t> hidden(result.bricks.size());
  tbb::parallel_for(std::size_t{0}, hidden.size(), [&](std::size_t slot) {
    hidden[slot] = hidden_octants(result.texels.get() + slot * brick_texels, visible);
  });
  result.pages.octants = true;
  for (std::uint32_t& entry : result.pages.entries)
    if (entry_kind(entry) == EntryKind::brick)
      entry |= hidden[entry_payload(entry)] << entry_slot_bits;
}

/// Makes texels and statistics of the bricks at result.places. If the field's storage is given,
/// each of its blocks goes as soon as no later brick needs it.
void fill(const BrickSource& source, const Field& field, Storage* storage, BrickAtlas& result) {
  const std::size_t count = result.places.size();
  const std::size_t per_brick = brick_texels * std::size_t(result.channels);
  result.bricks.resize(count);
  result.texels = page_array<float>(count * per_brick);
  const std::size_t at_once = storage ? 1024 : std::max<std::size_t>(count, 1);  // 3 MiB of scalars
  // the least leaf that some bricks or those behind them need
  std::vector<std::size_t> needed((count + at_once - 1) / at_once + 1, field.leaves.size());
  if (storage) {
    tbb::parallel_for(std::size_t{0}, needed.size() - 1, [&](std::size_t n) {
      for (std::size_t slot = n * at_once; slot < std::min((n + 1) * at_once, count); ++slot)
        needed[n] = std::min(needed[n], source.first_leaf(result.places[slot]));
    });
    for (std::size_t n = needed.size(); n-- > 1;)
      needed[n - 1] = std::min(needed[n - 1], needed[n]);
  }
  for (std::size_t n = 0; n + 1 < needed.size(); ++n) {
    const std::size_t first = n * at_once, end = std::min(first + at_once, count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(first, end, 64), [&](const auto& range) {
      for (std::size_t slot = range.begin(); slot != range.end(); ++slot) {
        float* to = result.texels.get() + slot * per_brick;
        source.gather(source.neighbours(result.places[slot]), to);
        result.bricks[slot] = measure(to, result.channels, result.absent);
      }
    });
    if (storage) storage->drop_before(needed[n + 1]);
  }
}

}  // namespace

AtlasSize predict_atlas(const Field& field, const AtlasOptions& options,
                        std::vector<glm::ivec3>* textured) {
  Plan plan = make_plan(field, options);
  if (textured) *textured = std::move(plan.atlas.places);
  return plan.atlas.size;
}

BrickAtlas build_atlas(const Field& field, const AtlasOptions& options, Storage* storage) {
  Plan plan = make_plan(field, options);
  plan.atlas.absent = field.absent;
  fill(plan.source, field, storage, plan.atlas);
  mark_octants(options, plan.atlas);
  return std::move(plan.atlas);
}

BrickAtlas build_beside(const Field& field, const BrickAtlas& layout, Storage* storage) {
  BrickAtlas result;
  result.channels = field.channels;
  result.domain = layout.domain;
  result.pages = layout.pages;
  result.places = layout.places;
  result.own_texels = true;
  const auto channels = std::uint64_t(field.channels);
  result.constants.assign(layout.constants.size() * channels, 0.0f);
  result.size = layout.size;
  result.size.constant_bytes = result.constants.size() * sizeof(float);
  result.size.texel_bytes = atlas::texel_bytes(result.places.size(), field.channels);
  fill(BrickSource(field), field, storage, result);
  return result;
}

}  // namespace psivox
