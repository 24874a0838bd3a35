#include "march/end_corrections.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace psivox {
namespace {

/// Whether rays begin inside the density's domain: the eye does, or a part of the orthographic
/// camera's plane may.
bool begins_inside(const View& view) {
  const Field& density = *view.medium.density;
  const Box domain = density.domain();
  const glm::dvec3 low(domain.min), high(domain.max);
  if (!view.camera.orthographic) {
    const glm::dvec3 eye(glm::inverse(density.world_from_index) *
                         glm::dvec4(view.camera.position, 1));
    return glm::all(glm::greaterThan(eye, low)) && glm::all(glm::lessThan(eye, high));
  }
  bool before = false, behind = false;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner = glm::mix(low, high, glm::dvec3(i >> 2, i >> 1 & 1, i & 1));
    const glm::dvec3 at(density.world_from_index * glm::dvec4(corner, 1));
    (glm::dot(at - view.camera.position, view.camera.forward) > 0 ? before : behind) = true;
  }
  return before && behind;
}

}  // namespace

bool has_end_corrections(const View& view) {
  const Scene& scene = view.scene;
  // From vacuum to vacuum there is nothing to correct.
  return scene.end_corrections && scene.resolved_sampling() == Sampling::uniform &&
         !view.medium.transfer && !view.medium.emission && scene.mode == Mode::alpha &&
         scene.resolved_integrator() == Integrator::psi_balanced &&
         (begins_inside(view) || scene.clip || scene.clip_plane);
}

}  // namespace psivox
