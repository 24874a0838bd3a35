#include "atlas/regions.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <utility>

#include "atlas/atlas.h"
#include "field/block_map.h"

namespace psivox {
namespace {

/// A plane across the longest extent of some bricks, which are sorted into its two sides.
struct Cut {
  int axis = 0;
  int plane = 0;
  std::size_t lower = 0;  ///< bricks below the plane, which come first
};

/// Puts about `share` of two or more bricks below the plane, and on each side at least one.
Cut cut(std::span<glm::ivec3> bricks, double share) {
  glm::ivec3 low(far_away), high(-far_away);
  for (const glm::ivec3& brick : bricks) {
    low = glm::min(low, brick);
    high = glm::max(high, brick);
  }
  const glm::ivec3 extent = high - low;
  Cut result;
  result.axis = longest_axis(extent);
  const int axis = result.axis;
  const auto wanted = std::ptrdiff_t(std::lround(share * double(bricks.size())));
  const auto place = bricks.begin() + std::min(wanted, std::ptrdiff_t(bricks.size()) - 1);
  std::nth_element(bricks.begin(), place, bricks.end(),
                   [axis](const glm::ivec3& a, const glm::ivec3& b) { return a[axis] < b[axis]; });
  // bricks of one slice stay together: the plane is before it or behind it
  const int slice = (*place)[axis];
  const auto below = [&](int plane) {
    return std::count_if(bricks.begin(), bricks.end(),
                         [&](const glm::ivec3& brick) { return brick[axis] < plane; });
  };
  const bool before = slice > low[axis] &&
                      (slice == high[axis] || wanted - below(slice) <= below(slice + 1) - wanted);
  result.plane = before ? slice : slice + 1;
  const auto upper = std::partition(bricks.begin(), bricks.end(), [&](const glm::ivec3& brick) {
    return brick[axis] < result.plane;
  });
  result.lower = std::size_t(upper - bricks.begin());
  return result;
}

}  // namespace

Regions::Regions(std::vector<glm::ivec3> bricks, std::size_t most, const Box& box)
    : bricks_(std::move(bricks)) {
  root_.box = box;
  split(root_, bricks_, 0, std::max<std::size_t>(most, 1));
}

Regions Regions::in_parts(std::vector<glm::ivec3> bricks, std::size_t parts) {
  Regions result;
  result.root_.box = everywhere;
  result.bricks_ = std::move(bricks);
  result.split(result.root_, result.bricks_, std::max<std::size_t>(parts, 1), 1);
  return result;
}

void Regions::split(Node& node, std::span<glm::ivec3> bricks, std::size_t parts, std::size_t most) {
  node.bricks = bricks.size();
  node.first = count_;
  if (parts > 0 ? parts == 1 || bricks.size() < 2 : bricks.size() <= most) {
    count_ += std::max<std::size_t>(parts, 1);
    return;
  }
  const std::size_t below = parts / 2;
  const Cut at = cut(bricks, parts > 0 ? double(below) / double(parts) : 0.5);
  node.axis = at.axis;
  node.plane = at.plane;
  node.lower = std::make_unique<Node>();
  node.upper = std::make_unique<Node>();
  node.lower->box = node.upper->box = node.box;
  node.lower->box.max[at.axis] = at.plane - 1;
  node.upper->box.min[at.axis] = at.plane;
  split(*node.lower, bricks.first(at.lower), below, most);
  split(*node.upper, bricks.subspan(at.lower), parts - below, most);
}

std::vector<Region> Regions::ordered(const std::function<bool(const Node&)>& lower_first) const {
  std::vector<Region> regions;
  std::vector<const Node*> open{&root_};
  while (!open.empty()) {
    const Node& node = *open.back();
    open.pop_back();
    if (!node.lower) {
      regions.push_back({node.box, node.bricks, node.first});
      continue;
    }
    const bool lower = lower_first(node);
    open.push_back(lower ? node.upper.get() : node.lower.get());
    open.push_back(lower ? node.lower.get() : node.upper.get());
  }
  return regions;
}

std::vector<Region> Regions::all() const {
  std::vector<Region> regions(count_);
  for (std::size_t i = 0; i < count_; ++i) regions[i].number = i;
  for (const Region& region : ordered([](const Node&) { return true; }))
    regions[region.number] = region;
  return regions;
}

std::vector<Region> Regions::front_to_back(const Camera& camera,
                                           const glm::dmat4& world_from_index) const {
  const glm::dmat4 to_index = glm::inverse(world_from_index);
  const glm::dvec3 eye(to_index * glm::dvec4(camera.position, 1));
  const glm::dvec3 forward = glm::dmat3(to_index) * camera.forward;
  // rays in a plane ascend through it (clamp_component in shaders/ray.glsl)
  const double level = -1e-15 * glm::length(forward);
  return ordered([&](const Node& node) {
    return camera.orthographic ? forward[node.axis] > level : eye[node.axis] <= 8.0 * node.plane;
  });
}

std::vector<glm::ivec3> leaf_bricks(const Field& field) {
  BlockMap seen(field.leaves.size());
  std::vector<glm::ivec3> bricks;
  for (const Leaf& leaf : field.leaves)
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 brick = (leaf.origin >> 3) - cube_corner(i);
      const auto next = std::int32_t(bricks.size());
      if (seen.insert(brick, next) == next) bricks.push_back(brick);
    }
  return bricks;
}

}  // namespace psivox
