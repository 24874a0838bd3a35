#pragma once

#include <memory>

#include "gl/march_program.h"
#include "march/grids.h"

namespace psivox::gl {

class AtlasTextures;

/// Whether the current context's driver draws from the host's memory: a buffer of scalar texels is
/// the atlas's own array, not a copy.
bool draws_from_host();

/// The grids of an atlas on the GPU. Needs a current context for its whole life.
class GridTextures {
 public:
  /// Throws Error(graphics) beyond the device's limits. The atlas must stay as long as this.
  GridTextures(const MediumAtlas& atlas, Filter filter);
  ~GridTextures();

  const MediumAtlas& atlas() const { return atlas_; }
  Filter filter() const { return filter_; }

  /// Key of the program that marches over them. Lowers max_turns to what one pass may take.
  ProgramKey key(MarchSetup& setup) const;

  void bind(const MarchProgram& march) const;

 private:
  const MediumAtlas& atlas_;
  Filter filter_;
  PerGrid<std::unique_ptr<const AtlasTextures>> textures_;
};

}  // namespace psivox::gl
