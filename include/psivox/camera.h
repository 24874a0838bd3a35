#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// A box in a grid's index space that holds visible voxels, with the sum of their attenuation.
struct VisibleBlock {
  glm::dvec3 min{0}, max{0};
  double amount = 1;
};

struct VisibleGrid {
  glm::dmat4 world_from_index{1.0};
  std::vector<VisibleBlock> blocks;
  int frame = 0;  ///< of a film: what counts is found for each frame, as if it were alone

  /// The greatest dot product of a point of the block with a direction [world units].
  double reach(const VisibleBlock& block, const glm::dvec3& direction) const;
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

/// A resolved camera: the orthonormal frame and the half extents of its image plane.
struct Camera {
  glm::dvec3 position;
  glm::dvec3 target;
  glm::dvec3 right, up, forward;  ///< unit, R = F x up, U = R x F
  glm::dvec3 camera_up{0, 1, 0};  ///< the `up` that the frame was made with
  bool orthographic = false;
  double half_width = 1;   ///< tan(fov/2), or half the ortho width [world units]
  double half_height = 1;  ///< half_width * H / W
  bool operator==(const Camera&) const = default;
};

/// A ray: p(t) = origin + t * direction, t in world units from the camera (its plane if
/// orthographic), direction of unit length. Both in world space.
struct WorldRay {
  glm::dvec3 origin;
  glm::dvec3 direction;
};

/// The scene's camera. Unset parameters frame all that is visible of the subject, looking along -Z,
/// or along +Y if Z is up. Throws Error(usage) if the position equals the target, the view is along
/// `up`, or an extent is not positive.
Camera make_camera(const Scene& scene, const Subject& subject);
/// The camera for a whole box.
Camera make_camera(const Scene& scene, const glm::dvec3& box_min, const glm::dvec3& box_max);

/// Gives the scene the camera, so that make_camera returns it for any subject.
void keep_camera(Scene& scene, const Camera& camera);

/// Where a point of the world is for the camera, as OpenEXR's standard attributes have it
/// (ImfStandardAttributes.h), for column vectors.
struct CameraMatrices {
  glm::dmat4 world_to_camera;  ///< right, up, forward [world units]: left-handed
  glm::dmat4 world_to_ndc;     ///< x, y over w: from 0, 0 in the top left corner to 1, 1
};
CameraMatrices camera_matrices(const Camera& camera);

/// A vector of the camera's axes (right, up and backwards, as in OpenGL and glTF) in the world.
glm::dvec3 from_camera(const Camera& camera, const glm::dvec3& vector);

/// Horizontal field of view [degrees]: the scene's fov, else that of its lens, made narrower by its
/// zoom.
double horizontal_fov(const Scene& scene);

/// Whether Z is up, by the scene or else by the file.
bool z_is_up(const Scene& scene, const Subject& subject);

/// The direction that is up in the picture: the scene's own, else its up axis.
glm::dvec3 up_direction(const Scene& scene, const Subject& subject);

void world_bounds(const Field& field, glm::dvec3& box_min, glm::dvec3& box_max);

/// Position of sample i of n inside a pixel, in [0,1)^2 (a Hammersley set; (0.5, 0.5) for n = 1).
glm::dvec2 pixel_sample(int i, int n);

/// Ray through pixel coordinates (x, y) from the top left; centres are at +0.5.
WorldRay camera_ray(const Camera& camera, const glm::ivec2& resolution, double x, double y);

/// Rays of a picture in the index space of one grid, as affine functions of the image plane's
/// normalised coordinates (u, v), u = 2x/W - 1 rightwards, v = 1 - 2y/H upwards, so that single
/// precision suffices: with w(u,v) = world direction, not normalised, and s = 1/|w|,
///   direction(u,v) = s * (direction_0 + u direction_u + v direction_v)   [voxels / world unit]
///   p(t) = anchor_0 + u anchor_u + v anchor_v + t * direction            [voxels, from `origin`]
/// t counts world units from the anchor plane, which is perpendicular to the view and passes
/// through the middle of `centre`'s domain, or through the camera if that middle lies behind it.
/// Numbers therefore stay of the size of the grid, however far away the camera or the world's
/// origin is. The camera is at t = -distance * |w|, or -distance if orthographic.
struct RayBundle {
  glm::dvec3 anchor_0, anchor_u, anchor_v;
  glm::dvec3 direction_0, direction_u, direction_v;
  glm::dvec3 world_0, world_u, world_v;
  double distance = 0;
  bool orthographic = false;
  glm::ivec3 origin;  ///< voxel that coordinates are relative to, a multiple of 8
};

/// Bundle in `field`'s index space, anchored in the middle of `centre` (the density grid), so that
/// bundles of several grids share t.
RayBundle make_ray_bundle(const Camera& camera, const Field& field, const Field& centre);

/// Width of the strip at the picture's right edge that a colour bar fills [pixels]; 0 if the
/// picture is too small for one. The default camera leaves the strip free.
int color_bar_strip(const glm::ivec2& resolution);

}  // namespace psivox
