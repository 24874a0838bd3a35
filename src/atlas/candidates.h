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

/// Least and greatest first channel of a brick's values.
ValueRange value_range(const BrickSource::Neighbours& from, int channels);

/// The bricks of a region that leaves and tiles reach, and with a margin those beside them. If they
/// are all kept, what options.visible says does not matter.
std::vector<Candidate> find_candidates(const BrickSource& source, const AtlasOptions& options,
                                       const Box& region, bool keep_all);

}  // namespace psivox::atlas
