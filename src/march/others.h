#pragma once

#include <optional>
#include <vector>

#include "march/march_parameters.h"
#include "march/medium_atlas.h"

namespace psivox {

/// The bricks of a further volume, or of what it emits, before they are joined.
struct OtherBricks {
  std::size_t volume = 0;  ///< place in Medium::others
  bool emits = false;
  BrickAtlas bricks{};
  std::optional<BrickAtlas> light{};  ///< its luminance, in the same slots
};

/// Sets the atlas's further volumes: the bricks of all as one grid of one channel. A volume's
/// channels follow each other there, each with as many slots as it has bricks.
void join_others(const std::vector<OtherBricks>& parts, MediumAtlas& atlas);

/// Writes them into the march's tables.
void place_others(const View& view, const MediumAtlas& atlas, MarchSetup& setup);

}  // namespace psivox
