#pragma once

#include <cstddef>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "field/index_space.h"
#include "psivox/camera.h"
#include "psivox/field.h"

namespace psivox {

/// A box of bricks, as a part of a volume.
struct Region {
  Box bricks;  ///< ends inclusive [8 voxels]; empty if there are more regions than bricks
  std::size_t count = 0;   ///< bricks in it
  std::size_t number = 0;  ///< 0 for the first of Regions::all
  bool empty() const { return bricks.empty(); }
};

/// A box of bricks split by a kd tree whose planes lie between bricks. The regions fill the box.
/// The same bricks give the same regions in every process.
class Regions {
 public:
  /// Splits at medians, until no region has more than `most` bricks, or one.
  Regions(std::vector<glm::ivec3> bricks, std::size_t most, const Box& box = everywhere);

  /// Splits into so many regions with about as many bricks each. Some are empty if the bricks are
  /// fewer.
  static Regions in_parts(std::vector<glm::ivec3> bricks, std::size_t parts);

  std::size_t count() const { return count_; }
  /// All bricks, in some order.
  const std::vector<glm::ivec3>& bricks() const { return bricks_; }
  /// All regions by their number, the empty ones too.
  std::vector<Region> all() const;
  /// The regions that are not empty, in an order in which no ray meets one before an earlier one.
  std::vector<Region> front_to_back(const Camera& camera, const glm::dmat4& world_from_index) const;

 private:
  struct Node {
    Box box;
    std::size_t bricks = 0;
    std::size_t first = 0;  ///< number of the first region in it
    int axis = 0;
    int plane = 0;  ///< first brick of the upper child along the axis
    std::unique_ptr<Node> lower, upper;
  };
  Regions() = default;
  /// Into so many parts; 0: until no part has more than `most` bricks.
  void split(Node& node, std::span<glm::ivec3> bricks, std::size_t parts, std::size_t most);
  std::vector<Region> ordered(const std::function<bool(const Node&)>& lower_first) const;

  Node root_;
  std::vector<glm::ivec3> bricks_;
  std::size_t count_ = 0;
};

}  // namespace psivox
