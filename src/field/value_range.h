#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "psivox/field.h"

namespace psivox {

inline std::uint64_t tile_voxels(const Tile& tile) {
  const auto width = std::uint64_t(tile.width);
  return width * width * width;
}

/// Where all values are here.
struct NoOthers {
  void operator()(std::span<std::uint64_t>) const {}
};

/// For each of some percentages, the smallest value that at least so many of the values do not
/// exceed; 0 if there are none. NaN and Inf do not count. The values are visited once or twice and
/// not stored: `each(take)` calls `take(value, count)` for each value. `join(counts)` adds the
/// counts of other processes.
template <typename Each, typename Join = NoOthers>
std::vector<double> value_percentiles(const Each& each, std::span<const double> percents,
                                      const Join& join = {}) {
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
  Counts counts(bins + 1);
  std::uint32_t low_bits = 0;
  each([&](float value, std::uint64_t count) {
    if (!std::isfinite(value)) return;
    const std::uint32_t key = key_of(value);
    counts[key >> 16] += count;
    low_bits |= key & 0xffffu;
  });
  counts[bins] = low_bits != 0;
  join(std::span(counts));
  const bool whole_bins = counts[bins] == 0;  // as of bytes: each bin is of one value
  counts.pop_back();
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
  if (!whole_bins)
    each([&](float value, std::uint64_t count) {
      if (!std::isfinite(value)) return;
      const std::uint32_t key = key_of(value);
      for (std::size_t i = 0; i < high.size(); ++i)
        if (key >> 16 == high[i]) low[i][key & 0xffffu] += count;
    });
  for (Counts& counts_of_one : low) join(std::span(counts_of_one));
  std::vector<double> values;
  for (std::size_t i = 0; i < high.size(); ++i) {
    const std::uint32_t key = high[i] << 16 | (whole_bins ? 0 : find(low[i], places[i]));
    values.push_back(double(std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key)));
  }
  return values;
}

/// Calls take(value, 1) for the first channel of leaves that stay in a file, NaN where a voxel is
/// not active, and then, if they are wanted, take(value, voxels) for active tiles.
template <typename Take>
void each_active(const LeafReader& reader, std::span<const std::uint32_t> leaves, int channels,
                 const Take& take, bool tiles = true) {
  constexpr std::size_t at_once = 4096;  // 8 MiB of scalars
  const std::size_t floats = 512 * std::size_t(channels);
  std::vector<float> values(std::min(at_once, leaves.size()) * floats);
  for (std::size_t n = 0; n < leaves.size(); n += at_once) {
    const auto some = leaves.subspan(n, std::min(at_once, leaves.size() - n));
    reader.read(some, values.data(), LeafRead::active);
    for (std::size_t i = 0; i < floats * some.size(); i += floats / 512) take(values[i], 1);
  }
  if (!tiles) return;
  for (const TileValue& tile : reader.active_tiles()) take(tile.value, tile.voxels);
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

/// Greatest value of any channel, at least 0.
double greatest_value(const Field& field);

/// The smallest active value that at least `percent` of the active values do not exceed, as found
/// by reading; for other fields, of the active box's voxels.
double active_percentile(const Field& field, double percent);

/// Least and greatest active value, as found by reading; for other fields, those of the active box.
glm::dvec2 active_range(const Field& field);

}  // namespace psivox
