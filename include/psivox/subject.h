#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace psivox {

/// A box in a grid's index space that holds visible voxels, with the sum of their attenuation.
struct VisibleBlock {
  glm::dvec3 min{0}, max{0};
  double amount = 1;
};

struct VisibleGrid {
  glm::dmat4 world_from_index{1.0};
  std::vector<VisibleBlock> blocks;
};

/// What an automatic camera looks at: the visible parts of a medium, and the axis that is up.
struct Subject {
  std::vector<VisibleGrid> grids;     ///< with one block at least
  glm::dvec3 box_min{0}, box_max{0};  ///< of the density's domain [world units]
  std::string z_up{};                 ///< what tells that the file's Z axis is up; empty: Y is up
};

/// A whole box that is visible.
Subject box_subject(const glm::dvec3& box_min, const glm::dvec3& box_max);

/// A place of the camera from which all that counts of the subject is inside the frame.
///
/// Parts that an eye would not miss do not count. Along each axis of the frame psivox takes the
/// stretch from 1 to 99 % of what the medium hides, or from 5 to 95 % if that is less than a
/// quarter as long. It adds a quarter of it on both sides, but not beyond the visible voxels. So a
/// compact body is kept whole, and stray voxels far from it do not count.
struct Framing {
  glm::dvec3 target{0};   ///< in the picture's middle
  double distance = 1;    ///< of the target along the view [world units]
  double half_width = 1;  ///< of an orthographic picture around the target [world units]
};

/// `axes` has the columns right, up and forward; `half_width` and `half_height` are those of the
/// perspective picture at distance 1. If `target` is set, it stays in the picture's middle;
/// else there are equal margins left and right of the orthographic or of the perspective picture.
/// The right `strip` of the picture's width stays free, too.
Framing framing_of(const Subject& subject, const glm::dmat3& axes, double half_width,
                   double half_height, bool orthographic,
                   const std::optional<glm::dvec3>& target = {}, double strip = 0);

/// The middle of what counts, along the world's axes.
glm::dvec3 middle_of(const Subject& subject);

}  // namespace psivox
