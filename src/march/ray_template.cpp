#include "march/ray_template.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "psivox/error.h"

namespace psivox {
namespace {

/// The line's next crossing of a face between voxels along one axis.
struct Crossing {
  int axis;
  double at;  ///< [planes along the main axis]
};

}  // namespace

RayTemplate make_ray_template(const glm::dvec3& direction, int planes, int connectivity) {
  constexpr int most = 1 << 22;
  if (planes > most / 3)
    throw Error(ExitCode::usage,
                "--sampling template: the grid is too wide for a template; use --sampling uniform");
  RayTemplate result;
  const glm::dvec3 size = glm::abs(direction);
  result.axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const glm::dvec3 slope = direction / size[result.axis];
  const glm::dvec3 sign = glm::sign(direction);

  const auto add = [&](const glm::dvec3& offset) {
    const double t = glm::dot(offset, direction) / glm::dot(direction, direction);
    result.entries.emplace_back(offset, t);
  };
  glm::dvec3 voxel(0);
  add(voxel);
  std::array<int, 3> crossed{};  ///< faces along each axis so far
  for (int plane = 1; plane <= planes; ++plane) {
    // the faces that the line crosses on its way from plane to plane, in order
    std::vector<Crossing> crossings;
    for (int axis = 0; axis < 3; ++axis)
      for (;;) {
        const double at = (crossed[std::size_t(axis)] + 0.5) / std::abs(slope[axis]);
        if (!(at < plane)) break;
        crossings.push_back({axis, at});
        ++crossed[std::size_t(axis)];
      }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
    const std::size_t together = connectivity == 26 ? 3 : connectivity == 18 ? 2 : 1;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      voxel[crossings[i].axis] += sign[crossings[i].axis];
      if ((i + 1) % together == 0 || i + 1 == crossings.size()) add(voxel);
    }
  }
  result.spacing = result.entries.back().w / double(result.entries.size() - 1);
  return result;
}

}  // namespace psivox
