#pragma once

#include "gl/grid_textures.h"
#include "gl/march_program.h"
#include "gl/tile_target.h"
#include "gl/triangle.h"
#include "march/light_lattice.h"

namespace psivox::gl {

/// light_lattice.frag over a view's density: optical depths along columns of a light's lattice.
/// Needs a current context for its whole life.
class LatticePass {
 public:
  /// `setup`: of lattice_setup. The program is light_lattice.frag by the textures' key for it. All
  /// must stay until the last use.
  LatticePass(const MarchSetup& setup, const GridTextures& textures, const MarchProgram& program);

  /// As LatticeColumns.
  void columns(std::span<const LatticeBrick> bricks, std::span<double> depths) const;

 private:
  static constexpr int side = 512;  ///< of the target
  static constexpr int row_bricks = side / (lattice_columns * lattice_columns);
  static constexpr std::size_t most_bricks = std::size_t(side) * row_bricks;

  void draw(std::span<const LatticeBrick> bricks, double* depths) const;

  const MarchSetup& setup_;
  const GridTextures& textures_;
  const MarchProgram& march_;
  TileTarget target_;
  Triangle triangle_;
  mutable std::vector<glm::vec4> first_, last_;  ///< what was read back, kept for its memory
};

}  // namespace psivox::gl
