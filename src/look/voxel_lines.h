#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "psivox/medium.h"
#include "scene/field_index.h"
#include "scene/rank_leaves.h"

namespace psivox {

/// The density of a medium along straight lines, at points that are a voxel apart. It keeps the
/// block that it read last: not for several threads. Of a density that several processes share it
/// knows this one's own part.
class VoxelLines {
 public:
  explicit VoxelLines(const Medium& medium);

  /// A line in index space.
  struct Line {
    glm::dvec3 from;
    glm::dvec3 way;  ///< a voxel long
    double step;     ///< its length [world units]
  };
  /// The line through an index-space point along a direction [world].
  Line line(const glm::dvec3& from, const glm::dvec3& direction) const;

  /// Whether a voxel is in this process's part.
  bool own(const glm::ivec3& voxel) const {
    return voxel == glm::clamp(voxel, part_.voxels.min, part_.voxels.max);
  }

  /// Attenuation of a value at extinction 1.
  double attenuation(double value) const;

  /// Value of a voxel, and between voxels.
  double at(const glm::ivec3& voxel);
  double at(const glm::dvec3& point);

  /// Optical depth at extinction 1 from a voxel on, by nearest voxels, without the voxel itself.
  /// Those that processes find in their own parts add up.
  double depth_behind(const glm::ivec3& voxel, const Line& along);

  /// Calls see(point, value) at points k, k + 1, ... of a line while they are in the domain and it
  /// returns true; the value is that of the nearest voxel. Passes over what is not stored, if that
  /// attenuates nothing.
  template <typename See>
  void walk(const Line& line, double k, See&& see) {
    while (true) {
      const glm::dvec3 point = line.from + k * line.way;
      const glm::ivec3 voxel(glm::round(point));
      if (glm::clamp(voxel, domain_.min, domain_.max) != voxel) return;
      const double value = at(voxel);
      const std::size_t empty =
          value == 0 && empty_is_clear_ ? index_.empty_steps(point, line.way) : 0;
      if (empty == 0 && !see(point, value)) return;
      k += double(std::max<std::size_t>(empty, 1));
    }
  }

 private:
  /// Without colours, among whose many knots a search would take longer.
  std::optional<TransferFunction> function_;
  OwnPart part_;
  FieldIndex index_;
  Box domain_;
  glm::dmat3 to_index_;
  bool empty_is_clear_;
  FieldIndex::Block block_;  ///< at origin_
  glm::ivec3 origin_;
};

}  // namespace psivox
