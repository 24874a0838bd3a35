#pragma once

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <optional>

#include "field/index_space.h"
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

/// Sets the world bounds of the centres of the active box's voxels. `to_world` takes a point of
/// index space to the world.
template <typename ToWorld>
void set_world_box(GridInfo& info, const ToWorld& to_world) {
  info.world_min = glm::dvec3(std::numeric_limits<double>::infinity());
  info.world_max = -info.world_min;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 p = to_world(glm::dvec3(corner_of(info.active_box, i)));
    info.world_min = glm::min(info.world_min, p);
    info.world_max = glm::max(info.world_max, p);
  }
}

/// Sets the world's box by the active box and the transform, which must be affine.
void set_world_box(GridInfo& info);

/// What a picture could be made of a grid with so many active voxels, some of which are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

/// Whether coordinates would overflow: the box is 2^30 voxels wide or that far from the origin.
bool too_large(const Box& box);

}  // namespace psivox::vdb
