#include "look/voxel_lines.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace psivox {
namespace {

std::optional<TransferFunction> attenuation_of(const Medium& medium) {
  if (!medium.transfer) return {};
  return medium.transfer->attenuation_alone();
}

}  // namespace

VoxelLines::VoxelLines(const Medium& medium)
    : function_(attenuation_of(medium)),
      index_(*medium.density),
      domain_(medium.density->domain()),
      to_index_(glm::inverse(glm::dmat3(medium.density->world_from_index))),
      empty_is_clear_(attenuation(0) == 0),
      block_(index_.block(domain_.min & ~7)),
      origin_(domain_.min & ~7) {}

VoxelLines::Line VoxelLines::line(const glm::dvec3& from, const glm::dvec3& direction) const {
  const glm::dvec3 way = to_index_ * direction;
  const double step = 1 / glm::length(way);
  return {from, step * way, step * glm::length(direction)};
}

double VoxelLines::attenuation(double value) const {
  return function_ ? function_->at(value).attenuation : std::max(value, 0.0);
}

double VoxelLines::depth_behind(const glm::ivec3& voxel, const Line& along) {
  double sum = 0;
  walk({glm::dvec3(voxel), along.way, along.step}, 1, [&](double value) {
    sum += attenuation(value);
    return true;
  });
  return sum;
}

double VoxelLines::at(const glm::ivec3& voxel) {
  const glm::ivec3 origin = voxel & ~7;
  if (origin != origin_) block_ = index_.block(origin_ = origin);
  const glm::ivec3 local = voxel - origin;
  return double(block_.value((local.x * 8 + local.y) * 8 + local.z));
}

double VoxelLines::at(const glm::dvec3& point) {
  const glm::ivec3 cell = nearest_voxel(point - 0.5);
  const glm::dvec3 u = point - glm::dvec3(cell);
  const auto along_z = [&](int x, int y) {
    return glm::mix(at(cell + glm::ivec3(x, y, 0)), at(cell + glm::ivec3(x, y, 1)), u.z);
  };
  const auto along_y = [&](int x) { return glm::mix(along_z(x, 0), along_z(x, 1), u.y); };
  return glm::mix(along_y(0), along_y(1), u.x);
}

}  // namespace psivox
