#pragma once

#include "gl/grid_textures.h"
#include "gl/march_program.h"
#include "gl/tile_target.h"
#include "march/light.h"

namespace psivox::gl {

/// light.frag over a view's density: exact optical depths from voxels towards the light. Needs a
/// current context for its whole life.
class LightPass {
 public:
  /// `setup`: of light_march. The program is light.frag by the textures' key for it. All must stay
  /// until the last use.
  LightPass(const MarchSetup& setup, const GridTextures& textures, const MarchProgram& program);

  void depths(const LightBlocks& blocks, const TakeDepths& take, const Progress& progress);
  /// Rays that stood still before their end.
  std::uint64_t stuck() const { return stuck_; }

 private:
  static constexpr int side = 512;  ///< of the target: the voxels of a block, and blocks at a time

  const MarchSetup& setup_;
  const GridTextures& textures_;
  const MarchProgram& march_;
  TileTarget target_;
  Triangle triangle_;
  std::uint64_t stuck_ = 0;
};

}  // namespace psivox::gl
