#include "gl/tile_order.h"

#include <algorithm>
#include <glm/common.hpp>
#include <tuple>

namespace psivox::gl {

TileOrder::TileOrder(const PixelBox& pixels, const glm::ivec2& first, int largest)
    : pixels_(pixels), first_(first - pixels.origin) {
  for (int y = 0; y < pixels.size.y; y += largest)
    for (int x = 0; x < pixels.size.x; x += largest) push({x, y}, largest);
}

bool TileOrder::later(const Block& a, const Block& b) {
  return std::tie(a.distance, a.origin.y, a.origin.x) >
         std::tie(b.distance, b.origin.y, b.origin.x);
}

void TileOrder::push(const glm::ivec2& origin, int side) {
  if (origin.x >= pixels_.size.x || origin.y >= pixels_.size.y) return;
  const glm::dvec2 low(origin), high(origin + side);
  const glm::dvec2 away = first_ - glm::clamp(first_, low, high);
  blocks_.push_back({origin, side, away.x * away.x + away.y * away.y});
  std::push_heap(blocks_.begin(), blocks_.end(), later);
}

PixelBox TileOrder::take(int side) {
  while (true) {
    std::pop_heap(blocks_.begin(), blocks_.end(), later);
    const Block block = blocks_.back();
    blocks_.pop_back();
    if (block.side <= side)
      return {pixels_.origin + block.origin,
              glm::min(glm::ivec2(block.side), pixels_.size - block.origin)};
    const int half = block.side / 2;
    for (const glm::ivec2 corner : {glm::ivec2(0), {half, 0}, {0, half}, {half, half}})
      push(block.origin + corner, half);
  }
}

}  // namespace psivox::gl
