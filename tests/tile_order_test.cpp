// The order in which the GPU draws the tiles of a picture.

#include "gl/tile_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

namespace psivox::gl {
namespace {

double distance_of(const Tile& tile, const glm::dvec2& point) {
  const glm::dvec2 low(tile.origin), high(tile.origin + tile.size);
  return glm::distance(point, glm::clamp(point, low, high));
}

TEST(TileOrder, EveryPixelIsInOneTileWhateverTheSides) {
  const glm::ivec2 picture{333, 190};
  std::vector<int> covered(std::size_t(picture.x * picture.y));
  const int sides[] = {16, 64, 32, 128, 16, 256};
  int taken = 0;
  for (TileOrder order(picture, 256); !order.empty(); ++taken) {
    const int side = sides[taken % 6];
    const Tile tile = order.take(side);
    EXPECT_LE(std::max(tile.size.x, tile.size.y), side);
    for (int y = 0; y < tile.size.y; ++y)
      for (int x = 0; x < tile.size.x; ++x)
        ++covered[std::size_t((tile.origin.y + y) * picture.x + tile.origin.x + x)];
  }
  EXPECT_EQ(std::ranges::count(covered, 1), picture.x * picture.y);
  EXPECT_GT(taken, 6);
}

TEST(TileOrder, TheCentreComesFirst) {
  const glm::ivec2 picture{1280, 760};
  const glm::dvec2 centre = 0.5 * glm::dvec2(picture);
  double before = 0;
  int tiles = 0;
  for (TileOrder order(picture, 1024); !order.empty(); ++tiles) {
    const double distance = distance_of(order.take(64), centre);
    EXPECT_GE(distance, before);
    before = distance;
  }
  EXPECT_EQ(tiles, 20 * 12);
}

}  // namespace
}  // namespace psivox::gl
