#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "gl/atlas_textures.h"
#include "gl/march_program.h"
#include "gl/tile_target.h"

namespace psivox::gl {

/// light.frag over a view's density: optical depths from voxels towards the light. Needs a current
/// context for its whole life.
class LightPass {
 public:
  /// The textures must stay until the last use. `gradient`: null where the transfer function has
  /// none.
  LightPass(const View& view, const MediumAtlas& atlas, const AtlasTextures& density,
            const AtlasTextures* gradient);
  ~LightPass();
  LightPass(const LightPass&) = delete;
  LightPass& operator=(const LightPass&) = delete;

  /// 512 depths a block, z fastest.
  std::vector<double> depths(std::span<const glm::ivec3> origins) const;

 private:
  static constexpr int side = 512;  ///< of the target: the voxels of a block, and blocks at a time

  LightPass(MarchSetup setup, const AtlasTextures& density, const AtlasTextures* gradient);
  void append(std::span<const glm::ivec3> origins, std::vector<double>& depths) const;

  MarchSetup setup_;
  const AtlasTextures& density_;
  const AtlasTextures* gradient_;
  bool resumable_;
  MarchProgram march_;
  TileTarget target_;
  GLuint vertex_array_ = 0;
};

}  // namespace psivox::gl
