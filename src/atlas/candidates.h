#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/brick_source.h"

namespace psivox::atlas {

/// Candidate bricks and their kind.
struct Candidate {
  Box bricks;
  EntryKind kind = EntryKind::empty;
  glm::vec3 value{0};
};

/// Calls `each` for the bricks of a box, whose ends are inclusive.
template <typename Each>
void for_bricks(const Box& box, const Each& each) {
  for (int x = box.min.x; x <= box.max.x; ++x)
    for (int y = box.min.y; y <= box.max.y; ++y)
      for (int z = box.min.z; z <= box.max.z; ++z) each(glm::ivec3(x, y, z));
}

/// The bricks of a region that leaves and tiles reach, and with a margin those beside them. If they
/// are all kept, what options.visible says does not matter.
std::vector<Candidate> find_candidates(const BrickSource& source, const AtlasOptions& options,
                                       const Box& region, bool keep_all);

}  // namespace psivox::atlas
