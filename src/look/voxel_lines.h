#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "field/field_cursor.h"
#include "psivox/image.h"
#include "psivox/medium.h"
#include "scene/transfer_function.h"

namespace psivox {

/// The density of a medium along straight lines, at points that are a voxel apart. Each thread
/// needs a copy, which shares the rest.
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

  /// Attenuation of a value at extinction 1.
  double attenuation(double value) const;

  /// Optical depth at extinction 1 of a voxel from its middle on [voxels].
  double depth_of(const glm::ivec3& voxel) { return 0.5 * attenuation(density_.at(voxel)); }
  /// Optical depth at extinction 1 from a voxel on, by nearest voxels, without the voxel itself; it
  /// may end where it is above `most`.
  double depth_behind(const glm::ivec3& voxel, const Line& along, double most = HUGE_VAL);

  /// Calls see(value) for the voxels nearest to the points k, k + 1, ... of a line while they are
  /// in the domain and it returns true. Passes over what is not stored, if that attenuates nothing.
  template <typename See>
  void walk(const Line& line, double k, See&& see) {
    while (true) {
      const glm::dvec3 point = line.from + k * line.way;
      const glm::ivec3 voxel = nearest_voxel(point);
      if (!domain_.contains(voxel)) return;
      const double value = density_.at(voxel);
      const std::size_t empty =
          value == 0 && empty_is_clear_ ? density_.empty_steps(point, line.way) : 0;
      if (empty == 0 && !see(value)) return;
      k += double(std::max<std::size_t>(empty, 1));
    }
  }

 private:
  /// Without colours, among whose many knots a search would take longer.
  std::shared_ptr<const TransferFunction> function_;
  FieldCursor density_;
  Box domain_;
  glm::dmat3 to_index_;
  bool empty_is_clear_;
};

/// Extinction [1/world unit] at which a third of the first light's intensity reaches the medium of
/// a view, on average over what it attenuates; at least the view's own. In a sparse medium 0.6
/// reaches it, and the least is an eighth of the view's own. Attenuations are taken from voxels
/// along straight steps of a voxel, from some thousands of them.
double light_extinction(const View& view, bool sparse);

/// A small picture of a scene, drawn in double precision, in coarse light.
Image draft_picture(Scene scene, const MediumFields& fields);

/// The brightest channel that this part of the glowing pixels exceeds, however bright they are: of
/// those that have a hundredth of the greatest. 0 if none glows.
double glow_level(const Image& image, double part);

}  // namespace psivox
