#pragma once

#include <epoxy/gl.h>

#include <vector>

#include "psivox/atlas.h"

namespace psivox::gl {

/// A brick atlas on the GPU: page table and constants as texture buffers; texels as one or more
/// texture buffers for exact filtering, or as one 3D texture of bricks for the hardware's.
/// Needs a current context for its whole life.
class AtlasTextures {
 public:
  /// `beside`: an atlas of the same bricks, whose texels become further channels of this one's; for
  /// exact filtering only. Throws Error(graphics) where the device's limits are too small,
  /// Error(memory) where its memory is.
  AtlasTextures(const BrickAtlas& atlas, Filter filter, const BrickAtlas* beside = nullptr);
  ~AtlasTextures();
  AtlasTextures(const AtlasTextures&) = delete;
  AtlasTextures& operator=(const AtlasTextures&) = delete;

  /// Number of texel buffers, at least 1 (shader constant DENSITY_BUFFERS or LUMINANCE_BUFFERS).
  int buffers() const { return int(texels_.size()); }
  /// Texels in each buffer but the last: whole bricks.
  int texels_per_buffer() const { return texels_per_buffer_; }

  void bind(int first_unit) const;
  /// Units that bind uses: pages, constants, bricks, then buffers() texel buffers.
  int units() const { return 3 + buffers(); }

 private:
  GLuint buffer_texture(GLenum format, const void* data, std::size_t bytes, GLbitfield flags = 0);
  void upload_pages(const std::vector<std::uint32_t>& entries);
  void upload_buffers(const BrickAtlas& atlas, const BrickAtlas* beside);
  /// A texture of `count` texels of both atlases, from the `first` on.
  GLuint upload_pairs(const BrickAtlas& atlas, const BrickAtlas& beside, std::uint64_t first,
                      std::uint64_t count);
  void upload_bricks(const BrickAtlas& atlas);

  GLuint pages_ = 0, constants_ = 0, bricks_ = 0;
  std::vector<GLuint> texels_;
  std::vector<GLuint> storage_;  ///< buffer objects
  std::uint64_t max_texels_ = 0;
  int texels_per_buffer_ = brick_texels;
};

}  // namespace psivox::gl
