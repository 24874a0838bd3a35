#pragma once

#include <vector>

#include "march/pixel_box.h"

namespace psivox::gl {

/// Cuts a rectangle of pixels into tiles, those nearest to a pixel first. The sides are powers of
/// two and may change from tile to tile.
class TileOrder {
 public:
  /// No tile has a side above `largest`.
  TileOrder(const PixelBox& pixels, const glm::ivec2& first, int largest);

  bool empty() const { return blocks_.empty(); }
  /// Takes the next tile, of at most `side` pixels a side.
  PixelBox take(int side);

 private:
  struct Block {
    glm::ivec2 origin{0};
    int side = 0;
    double distance = 0;  ///< from the first pixel [pixels, squared]
  };
  static bool later(const Block& a, const Block& b);
  void push(const glm::ivec2& origin, int side);

  PixelBox pixels_;
  glm::dvec2 first_;           ///< in the rectangle's own pixels
  std::vector<Block> blocks_;  ///< a heap by `later`
};

}  // namespace psivox::gl
