#include "sanitise.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace psivox::vdb {
namespace {

constexpr std::size_t kGrain = 64;  // leaves per task: 128 KiB or more
constexpr float kMaxFloat = std::numeric_limits<float>::max();

/// True if a value of the 512 is NaN, infinite or below lo. It has no branch and a fixed length, so
/// that it runs at the speed of memory; almost every leaf of almost every file needs nothing more.
bool has_bad_value(const float* values, float lo) {
  int bad = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const int good = (values[i] >= lo) & (values[i] <= kMaxFloat);
    bad |= good ^ 1;
  }
  return bad != 0;
}

/// Counts one bad value and replaces it, except +Inf, whose replacement is not known yet.
void sanitise_value(float& value, float lo, BadValues& count) {
  if (value >= lo && value <= kMaxFloat) return;
  if (std::isnan(value)) {
    ++count.nan;
  } else if (value > 0.0f) {
    ++count.positive_infinite;
    return;
  } else if (std::isinf(value)) {
    ++count.negative_infinite;
  } else {
    ++count.negative;
    count.least = std::min(count.least, value);
  }
  value = 0.0f;
}

using Range = tbb::blocked_range<std::size_t>;

float largest_finite(std::span<float* const> leaves, std::span<const Tile> tiles, int channels,
                     float elsewhere) {
  const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
  float largest = tbb::parallel_reduce(
      Range(0, leaves.size(), kGrain), elsewhere,
      [&](const Range& range, float most) {
        for (std::size_t n = range.begin(); n != range.end(); ++n) {
          for (std::size_t i = 0; i < length; ++i) {
            if (leaves[n][i] <= kMaxFloat) most = std::max(most, leaves[n][i]);
          }
        }
        return most;
      },
      [](float a, float b) { return std::max(a, b); });
  for (const Tile& tile : tiles) {
    for (int c = 0; c < channels; ++c) {
      if (tile.value[c] <= kMaxFloat) largest = std::max(largest, tile.value[c]);
    }
  }
  return largest > 0.0f ? largest : 1.0f;
}

void replace_infinite(std::span<float* const> leaves, std::span<Tile> tiles, int channels,
                      float largest) {
  const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
  tbb::parallel_for(Range(0, leaves.size(), kGrain), [&](const Range& range) {
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      for (std::size_t i = 0; i < length; ++i) leaves[n][i] = std::min(leaves[n][i], largest);
    }
  });
  for (Tile& tile : tiles) {
    for (int c = 0; c < channels; ++c) tile.value[c] = std::min(tile.value[c], largest);
  }
}

}  // namespace

float smallest_good(GridRole role) { return role == GridRole::data ? -kMaxFloat : 0.0f; }

BadValues sanitise_leaf(float* values, int channels, float smallest) {
  BadValues count;
  for (int c = 0; c < channels; ++c, values += kLeafVoxels) {
    if (!has_bad_value(values, smallest)) continue;
    for (std::size_t i = 0; i < kLeafVoxels; ++i) sanitise_value(values[i], smallest, count);
  }
  return count;
}

BadValues sanitise(std::span<float* const> leaves, std::span<Tile> tiles, int channels,
                   GridRole role, float elsewhere) {
  const float lo = smallest_good(role);
  BadValues count = tbb::parallel_reduce(
      Range(0, leaves.size(), kGrain), BadValues(),
      [&](const Range& range, BadValues sub_count) {
        for (std::size_t n = range.begin(); n != range.end(); ++n)
          sub_count = sub_count + sanitise_leaf(leaves[n], channels, lo);
        return sub_count;
      },
      [](const BadValues& a, const BadValues& b) { return a + b; });
  for (Tile& tile : tiles) {
    for (int c = 0; c < channels; ++c) sanitise_value(tile.value[c], lo, count);
  }
  if (count.positive_infinite > 0) {
    count.largest = largest_finite(leaves, tiles, channels, elsewhere);
    replace_infinite(leaves, tiles, channels, count.largest);
  }
  return count;
}

bool all_good(std::span<const float> values, GridRole role, bool infinite) {
  const float lo = smallest_good(role);
  if (infinite) return std::ranges::all_of(values, [&](float v) { return v >= lo; });
  while (values.size() >= kLeafVoxels) {
    if (has_bad_value(values.data(), lo)) return false;
    values = values.subspan(kLeafVoxels);
  }
  return std::ranges::all_of(values, [&](float v) { return v >= lo && v <= kMaxFloat; });
}

}  // namespace psivox::vdb
