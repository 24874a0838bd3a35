#pragma once

#include <epoxy/gl.h>

#include <functional>
#include <glm/vec4.hpp>
#include <vector>

#include "gl/march_program.h"
#include "march/pixel_box.h"

namespace psivox::gl {

/// What one tile is drawn into, by fragment or by compute shaders: picture, layers where they are
/// wanted and, for rays that take several passes, two sets of state textures that are read and
/// written in turn.
class TileTarget {
 public:
  /// `layers`: whether what the march writes beside the picture is kept.
  TileTarget(int side, bool resumable, bool layers);
  ~TileTarget();
  TileTarget(const TileTarget&) = delete;
  TileTarget& operator=(const TileTarget&) = delete;

  int side() const { return side_; }

  /// Binds the framebuffer and the images that write state set `set` (0 or 1) and, to units 0 to 3,
  /// the other's textures.
  void bind(int set) const;

  /// Rows of a width x height region, top row first, `stride` pixels from one to the next. What was
  /// written by the last draw.
  void read_picture(int width, int height, glm::vec4* pixels, int stride) const;
  void read_layers(int width, int height, glm::vec4* pixels, int stride) const;

  /// Draws the rays of a width x height region in as many passes as they need; returns their
  /// number. `draw` draws the program's triangle over them. Throws Error(graphics) if a pass
  /// neither moves nor ends any.
  int draw_passes(const MarchProgram& march, int width, int height,
                  const std::function<void()>& draw);

 private:
  /// Whether all rays have ended after a pass that wrote `set`.
  bool all_done(int width, int height, int set, bool first_pass);
  static void read(GLenum attachment, int width, int height, glm::vec4* pixels, int stride);

  int side_;
  GLuint picture_ = 0, layers_ = 0;
  GLuint states_[2][4] = {};
  GLuint framebuffers_[2] = {};
  int sets_;
  std::vector<glm::ivec4> rays_;  ///< the last of the state textures, after the last pass
};

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
