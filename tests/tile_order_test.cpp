// The pixels that the GPU draws of a picture, and the order of their tiles.

#include "gl/tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "made_fields.h"
#include "march/pixel_box.h"
#include "reference/ray_radiance.h"

namespace psivox::gl {
namespace {

double distance_of(const PixelBox& tile, const glm::dvec2& point) {
  const glm::dvec2 low(tile.origin), high(tile.origin + tile.size);
  return glm::distance(point, glm::clamp(point, low, high));
}

std::size_t index_of(const glm::ivec2& pixel, const glm::ivec2& picture) {
  return std::size_t(pixel.y * picture.x + pixel.x);
}

TEST(PixelBox, WhatIsAroundABoxHasEachPixelOnce) {
  const PixelBox all{{2, 3}, {9, 7}};
  for (const PixelBox& inner : {PixelBox{{4, 5}, {3, 2}},
                                {{2, 3}, {9, 7}},
                                {{2, 3}, {1, 1}},
                                {{2, 5}, {9, 2}},
                                {{10, 3}, {1, 7}},
                                {}}) {
    std::vector<int> covered(9 * 7);
    std::vector<PixelBox> boxes = around(inner, all);
    boxes.push_back(inner);
    for (const PixelBox& box : boxes)
      for (int y = 0; y < box.size.y; ++y)
        for (int x = 0; x < box.size.x; ++x)
          ++covered[index_of(box.origin - all.origin + glm::ivec2(x, y), all.size)];
    EXPECT_EQ(std::ranges::count(covered, 1), 9 * 7);
    EXPECT_LE(boxes.size(), 5u);
  }
}

// The box's edges are projected, rays meet the box: two ways to the same pixels.
TEST(PixelBox, HoldsAllWhoseRaysMeetABox) {
  const Field field = make_field({{-9, 3, 4}, {22, 15, 31}}, [](glm::ivec3) { return 1.0f; });
  const Box domain = field.domain();
  const glm::dvec3 low(domain.min), high(domain.max), middle = 0.5 * (low + high);
  constexpr int side = 160;
  int inside = 0, smaller = 0;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 away(std::cos(i), std::sin(2.4 * i), std::sin(i));
    const double distance = 10 + 3 * i;  // the first cameras are inside
    Scene scene = looking(small_scene(side), middle + distance * away,
                          middle + 20.0 * glm::dvec3(std::sin(5 * i), 0.3, std::cos(3 * i)),
                          i % 3 == 0 ? std::optional<double>(70) : std::nullopt);
    scene.extinction = 1;
    const bool cells = i % 2 == 1;  // voxels are, each around its first corner
    if (cells) scene.classification = Classification::nearest;
    const View view = view_of(scene, field);
    const PixelBox box = pixels_of(view, low, high);
    smaller += !box.empty() && box.size != view.scene.resolution;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        WorldRay ray = pixel_ray(view, x, y);
        if (cells) ray.origin += 0.5;
        const glm::dvec3 to_low = (low - ray.origin) / ray.direction,
                         to_high = (high - ray.origin) / ray.direction;
        const glm::dvec3 enters = glm::min(to_low, to_high), leaves = glm::max(to_low, to_high);
        const double begin = std::max({0.0, enters.x, enters.y, enters.z});
        if (begin > std::min({leaves.x, leaves.y, leaves.z})) continue;
        ++inside;
        EXPECT_FALSE(common(box, {{x, y}, {1, 1}}).empty()) << i << ": " << x << ' ' << y;
      }
  }
  EXPECT_GT(inside, 10000);
  EXPECT_GT(smaller, 20);
}

TEST(TileOrder, EveryPixelIsInOneTileWhateverTheSides) {
  const glm::ivec2 picture{333, 190}, first{7, 1000};
  std::vector<int> covered(std::size_t(picture.x * picture.y));
  const int sides[] = {16, 64, 32, 128, 16, 256};
  int taken = 0;
  for (TileOrder order({first, picture}, first, 256); !order.empty(); ++taken) {
    const int side = sides[taken % 6];
    const PixelBox tile = order.take(side);
    EXPECT_LE(std::max(tile.size.x, tile.size.y), side);
    for (int y = 0; y < tile.size.y; ++y)
      for (int x = 0; x < tile.size.x; ++x)
        ++covered[index_of(tile.origin - first + glm::ivec2(x, y), picture)];
  }
  EXPECT_EQ(std::ranges::count(covered, 1), picture.x * picture.y);
  EXPECT_GT(taken, 6);
}

TEST(TileOrder, TheCentreComesFirst) {
  const glm::ivec2 picture{1280, 760};
  const glm::dvec2 centre = 0.5 * glm::dvec2(picture);
  double before = 0;
  int tiles = 0;
  for (TileOrder order({{}, picture}, picture / 2, 1024); !order.empty(); ++tiles) {
    const double distance = distance_of(order.take(64), centre);
    EXPECT_GE(distance, before);
    before = distance;
  }
  EXPECT_EQ(tiles, 20 * 12);
}

}  // namespace
}  // namespace psivox::gl
