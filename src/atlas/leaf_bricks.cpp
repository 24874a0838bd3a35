#include <array>
#include <bitset>
#include <map>

#include "psivox/atlas.h"

namespace psivox {

std::vector<glm::ivec3> leaf_bricks(const Field& field) {
  // cubes of 8^3 bricks, a bit each: a dense volume of a million leaves takes kilobytes
  std::map<std::array<int, 3>, std::bitset<512>> cubes;
  for (const Leaf& leaf : field.leaves)
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 brick = (leaf.origin >> 3) - glm::ivec3(i >> 2, i >> 1 & 1, i & 1);
      const glm::ivec3 cube = brick >> 3, in_cube = brick & 7;
      const int place = (in_cube.x * 8 + in_cube.y) * 8 + in_cube.z;
      cubes[{cube.x, cube.y, cube.z}].set(std::size_t(place));
    }
  std::vector<glm::ivec3> bricks;
  std::size_t count = 0;
  for (const auto& [cube, bits] : cubes) count += bits.count();
  bricks.reserve(count);
  for (const auto& [cube, bits] : cubes)
    for (int n = 0; n < 512; ++n)
      if (bits[std::size_t(n)])
        bricks.push_back(8 * glm::ivec3(cube[0], cube[1], cube[2]) +
                         glm::ivec3(n >> 6, n >> 3 & 7, n & 7));
  return bricks;
}

}  // namespace psivox
