#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "gl/grid_textures.h"
#include "gl/march_program.h"
#include "gl/tile_target.h"
#include "gl/triangle.h"

namespace psivox::gl {

/// light.frag over a view's density: optical depths from voxels towards the light. Needs a current
/// context for its whole life.
class LightPass {
 public:
  /// The textures must stay until the last use.
  LightPass(const View& view, const GridTextures& textures);

  /// 512 depths a block, z fastest.
  std::vector<double> depths(std::span<const glm::ivec3> origins) const;

 private:
  static constexpr int side = 512;  ///< of the target: the voxels of a block, and blocks at a time

  LightPass(MarchSetup setup, const GridTextures& textures);
  void append(std::span<const glm::ivec3> origins, std::vector<double>& depths) const;

  MarchSetup setup_;
  const GridTextures& textures_;
  MarchProgram march_;
  TileTarget target_;
  Triangle triangle_;
};

}  // namespace psivox::gl
