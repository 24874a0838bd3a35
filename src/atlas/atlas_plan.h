#pragma once

#include "atlas/brick_source.h"
#include "psivox/atlas.h"

namespace psivox::atlas {

/// Topology of an atlas: everything except the texels.
struct Plan {
  BrickSource source;
  BrickAtlas atlas;
};

Plan make_plan(const Field& field, const AtlasOptions& options);

std::uint64_t texel_bytes(std::size_t bricks, int channels, TexelType texel);

}  // namespace psivox::atlas
