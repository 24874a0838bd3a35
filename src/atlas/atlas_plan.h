#pragma once

#include "atlas/atlas.h"
#include "atlas/brick_source.h"

namespace psivox {

/// The type of the host's bricks, by which light is computed and methods are chosen, whatever codes
/// the device has.
inline TexelType host_texel(TexelType texel) {
  return texel == TexelType::float16 ? texel : TexelType::float32;
}

}  // namespace psivox

namespace psivox::atlas {

/// Topology of an atlas: everything except the texels.
struct Plan {
  BrickSource source;
  BrickAtlas atlas;
};

Plan make_plan(const Field& field, const AtlasOptions& options);

std::uint64_t texel_bytes(std::size_t bricks, int channels, TexelType texel);

}  // namespace psivox::atlas
