#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "survey.h"

// What `psivox info` says of a grid, whatever it is read from.

namespace psivox::vdb {

/// Statistics of active values that add up; of lengths, if there are vectors.
struct Statistics {
  double least = std::numeric_limits<double>::infinity(), greatest = -least, mean = 0, voxels = 0;
  std::uint64_t not_finite = 0;

  void add(double value, std::uint64_t count);
  void add(const Statistics& other);
  /// A value of so many voxels. `Number` is float or double.
  template <typename Number>
  void add(const Number* value, int channels, std::uint64_t count) {
    add(channels == 1 ? double(*value)
                      : std::hypot(double(value[0]), double(value[1]), double(value[2])),
        count);
  }
  /// The active values of a leaf.
  template <typename Number>
  void add(const Number* values, int channels, const LeafMask& active) {
    for (auto on = active.beginOn(); on; ++on)
      add(values + on.pos() * std::size_t(channels), channels, std::uint64_t{1});
  }
  std::optional<ValueStatistics> all() const;  ///< unset: no value was finite
};

/// What a picture could be made of a grid with so many active voxels, some of which are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

/// Whether coordinates would overflow: the box is 2^30 voxels wide or that far from the origin.
bool too_large(const Box& box);

}  // namespace psivox::vdb
