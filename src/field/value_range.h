#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "field/leaf_values.h"
#include "psivox/field.h"

namespace psivox {

inline std::uint64_t tile_voxels(const Tile& tile) {
  const auto width = std::uint64_t(tile.width);
  return width * width * width;
}

/// For each of some percentages, the smallest value that at least so many of the values do not
/// exceed; 0 if there are none. NaN and Inf do not count. The values are visited once or twice and
/// not stored: `each(take)` calls `take(value, count)` for each value.
template <typename Each>
std::vector<double> value_percentiles(const Each& each, std::span<const double> percents) {
  if (percents.empty()) return {};
  // The bits of a float in the order of the numbers.
  const auto key_of = [](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
  };
  using Counts = std::vector<std::uint64_t>;
  constexpr std::size_t bins = 65536;
  const auto find = [](const Counts& counts, std::uint64_t& place) {  // which becomes the bin's own
    std::uint32_t bin = 0;
    for (; bin < bins - 1 && place > counts[bin]; ++bin) place -= counts[bin];
    return bin;
  };
  Counts counts(bins);
  std::uint32_t low_bits = 0;
  each([&](float value, std::uint64_t count) {
    if (!std::isfinite(value)) return;
    const std::uint32_t key = key_of(value);
    counts[key >> 16] += count;
    low_bits |= key & 0xffffu;
  });
  const bool whole_bins = low_bits == 0;  // as of bytes: each bin is of one value
  const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (all == 0) return std::vector<double>(percents.size(), 0);
  std::vector<std::uint32_t> high;
  std::vector<std::uint64_t> places;
  for (const double percent : percents) {
    const double wanted = std::ceil(percent / 100 * double(all));
    places.push_back(std::min(wanted < 1 ? 1 : std::uint64_t(wanted), all));
    high.push_back(find(counts, places.back()));
  }
  std::vector<Counts> low(whole_bins ? 0 : percents.size(), Counts(bins));
  std::vector<bool> wanted(bins);
  for (const std::uint32_t bin : high) wanted[bin] = true;
  if (!whole_bins)
    each([&](float value, std::uint64_t count) {
      if (!std::isfinite(value)) return;
      const std::uint32_t key = key_of(value);
      for (std::size_t i = 0; wanted[key >> 16] && i < high.size(); ++i)
        if (key >> 16 == high[i]) low[i][key & 0xffffu] += count;
    });
  std::vector<double> values;
  for (std::size_t i = 0; i < high.size(); ++i) {
    const std::uint32_t key = high[i] << 16 | (whole_bins ? 0 : find(low[i], places[i]));
    values.push_back(double(std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key)));
  }
  return values;
}

/// Sets Field::active_percentiles, of values that `each` visits.
template <typename Each>
void set_percentiles(Field& field, std::span<const double> percents, const Each& each) {
  const std::vector<double> values = value_percentiles(each, percents);
  for (std::size_t i = 0; i < values.size(); ++i) field.active_percentiles[percents[i]] = values[i];
}

/// One of them.
template <typename Each>
double value_percentile(const Each& each, double percent) {
  return value_percentiles(each, std::span(&percent, 1)).front();
}

/// Least and greatest value of a scalar field, including the 0 where nothing is stored.
glm::dvec2 stored_range(const Field& field);

/// The same of all channels of any field.
glm::dvec2 range_of_all(const Field& field);
inline double greatest_value(const Field& field) { return range_of_all(field).y; }

/// Calls take(value, voxels) for the first channel of the leaves' voxels in the active box, and of
/// tiles.
template <typename Take>
void for_active(const Field& field, const Take& take) {
  visit_leaves(field, [&](std::span<const Leaf> leaves) {
    for (const Leaf& leaf : leaves) {
      const LeafValues values = values_of(field, leaf);
      for (int i = 0; i < 512; ++i) {
        const glm::ivec3 voxel = leaf_voxel(i);
        if (field.active_box.contains(leaf.origin + voxel))
          take(*values.at(voxel), std::uint64_t{1});
      }
    }
  });
  for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
}

/// The smallest active value that at least `percent` of the active values do not exceed, as found
/// by reading; for other fields, of the active box's voxels.
double active_percentile(const Field& field, double percent);

/// Least and greatest active value, as found by reading; for other fields, those of the active box.
glm::dvec2 active_range(const Field& field);

}  // namespace psivox
