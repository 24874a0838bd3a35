#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/camera.h"
#include "psivox/scene.h"

namespace psivox {

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

}  // namespace psivox
