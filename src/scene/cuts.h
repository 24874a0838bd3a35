#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "psivox/camera.h"
#include "psivox/scene.h"

namespace psivox {

/// Whether a vector of any length gives a direction: its square is neither 0 nor infinite.
inline bool has_direction(const glm::dvec3& v) { return std::isnormal(glm::dot(v, v)); }

/// The points where dot(normal, p) >= offset [world].
struct HalfSpace {
  glm::dvec3 normal;
  double offset;
};

/// What --clip and --clip-plane leave: the intersection of these. Empty: everything.
std::vector<HalfSpace> clip_of(const Scene& scene);

/// The clip's half spaces and, behind them, one that the slice's plane bounds, if the mode shows
/// it.
std::vector<HalfSpace> cuts_of(const Scene& scene);

/// The part of a ray, from and to [world units], that the half spaces leave of it. Empty if the
/// second is not above the first.
glm::dvec2 clip_interval(const std::vector<HalfSpace>& clip, const WorldRay& ray);

/// The scene with a plane for --mode slice, across the view from the front, and with the subject's
/// middle for planes without a point.
Scene with_planes(Scene scene, const Subject& subject);

/// Whether the clip cuts every block of the subject off.
bool cuts_all(Subject subject, const std::vector<HalfSpace>& clip);

/// The subject without the blocks that the clip cuts off as a whole; unchanged if those are all.
Subject clipped(const Subject& subject, const std::vector<HalfSpace>& clip);

/// Opaque things that another renderer has drawn through the scene's camera: each ray ends at its
/// pixel's depth, so that the picture goes over theirs by plain `over` (Porter and Duff 1984).
struct Holdout {
  glm::ivec2 size{0};             ///< [pixels]
  DepthKind kind = DepthKind::z;  ///< of the depths
  std::vector<float> depths;      ///< [world units], from the top left pixel, row by row

  /// Distance from the camera along the view at which the rays of a pixel end, in a picture of
  /// `resolution` pixels of the same frame [world units]; +Inf where nothing is there: the file's
  /// depth is not finite, or not above 0.
  double z(const Camera& camera, const glm::ivec2& resolution, const glm::ivec2& pixel) const;
};

/// Distance from the camera at which the holdout, which may be null, ends a ray of a pixel.
double held_at(const Holdout* holdout, const Camera& camera, const glm::ivec2& resolution,
               const glm::ivec2& pixel, const WorldRay& ray);

/// A layer of a picture's file, as FILE.exr[:LAYER] names it.
struct LayerOfFile {
  std::string file;
  std::string layer;  ///< empty: not said

  explicit LayerOfFile(const std::string& text);
  std::string text() const { return layer.empty() ? file : file + ":" + layer; }
};

}  // namespace psivox
