#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>

#include "psivox/field.h"

namespace psivox {

inline std::uint64_t tile_voxels(const Tile& tile) {
  const auto width = static_cast<std::uint64_t>(tile.width);
  return width * width * width;
}

/// Where all values are here.
struct NoOthers {
  void operator()(std::span<std::uint64_t>) const {}
};

/// The smallest value that at least `percent` of the values do not exceed; 0 if there are none. NaN
/// and Inf do not count. The values are visited twice and not stored: `each(take)` calls
/// `take(value, count)` for each value. `join(counts)` adds the counts of other processes.
template <typename Each, typename Join = NoOthers>
double value_percentile(const Each& each, double percent, const Join& join = {}) {
  // The bits of a float in the order of the numbers.
  const auto key_of = [](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
  };
  using Counts = std::array<std::uint64_t, 65536>;
  const auto counts = std::make_unique<Counts>();
  const auto find = [&](std::uint64_t& rank) {  // the bin of that rank, which becomes its own
    std::uint32_t bin = 0;
    for (; bin < 65535 && rank > (*counts)[bin]; ++bin) rank -= (*counts)[bin];
    return bin;
  };
  each([&](float value, std::uint64_t count) {
    if (!std::isfinite(value)) return;
    (*counts)[key_of(value) >> 16] += count;
  });
  join(std::span<std::uint64_t>(*counts));
  const std::uint64_t all = std::accumulate(counts->begin(), counts->end(), std::uint64_t{0});
  if (all == 0) return 0;
  const double wanted = std::ceil(percent / 100 * static_cast<double>(all));
  std::uint64_t rank = wanted < 1 ? 1 : static_cast<std::uint64_t>(wanted);
  if (rank > all) rank = all;
  const std::uint32_t high = find(rank);
  counts->fill(0);
  each([&](float value, std::uint64_t count) {
    if (std::isfinite(value) && key_of(value) >> 16 == high)
      (*counts)[key_of(value) & 0xffffu] += count;
  });
  join(std::span<std::uint64_t>(*counts));
  const std::uint32_t key = high << 16 | find(rank);
  return static_cast<double>(std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key));
}

}  // namespace psivox
