#pragma once

#include <glm/vec2.hpp>
#include <vector>

namespace psivox::gl {

/// A rectangle of pixels.
struct Tile {
  glm::ivec2 origin{0}, size{0};
};

/// Cuts a picture into tiles, the centre's first. The sides are powers of two and may change from
/// tile to tile.
class TileOrder {
 public:
  /// No tile has a side above `largest`.
  TileOrder(const glm::ivec2& picture, int largest);

  bool empty() const { return blocks_.empty(); }
  /// Takes the next tile, of at most `side` pixels a side.
  Tile take(int side);

 private:
  struct Block {
    glm::ivec2 origin{0};
    int side = 0;
    double distance = 0;  ///< from the picture's centre [pixels, squared]
  };
  static bool later(const Block& a, const Block& b);
  void push(const glm::ivec2& origin, int side);

  glm::ivec2 picture_;
  std::vector<Block> blocks_;  ///< a heap by `later`
};

}  // namespace psivox::gl
