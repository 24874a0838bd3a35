#pragma once

#include <epoxy/gl.h>

#include <glm/vec4.hpp>
#include <vector>

namespace psivox::gl {

/// Framebuffer of one tile: picture, layers and, for rays that take several passes, two sets of
/// state textures that are read and written in turn.
class TileTarget {
 public:
  TileTarget(int side, bool resumable);
  ~TileTarget();
  TileTarget(const TileTarget&) = delete;
  TileTarget& operator=(const TileTarget&) = delete;

  int side() const { return side_; }

  /// Binds the framebuffer that writes state set `set` (0 or 1) and, to units 0 to 3, the other's
  /// textures.
  void bind(int set) const;

  /// Rows of a width x height region, top row first. What was written by the last draw.
  void read_picture(int width, int height, std::vector<glm::vec4>& values) const;
  void read_layers(int width, int height, std::vector<glm::vec4>& values) const;

  /// True if every ray of the region has ended, by the state that the last draw wrote to `set`.
  bool all_done(int width, int height, int set) const;

 private:
  int side_;
  GLuint picture_ = 0, layers_ = 0;
  GLuint states_[2][4] = {};
  GLuint framebuffers_[2] = {};
  int sets_;
};

}  // namespace psivox::gl
