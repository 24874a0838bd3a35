#pragma once

#include <cstddef>
#include <cstdint>

#include "psivox/field.h"
#include "psivox/medium.h"
#include "psivox/scene.h"

// A density whose values stay in the file.

namespace psivox {

/// The field by which a team chooses a view of a density whose values stay in the file: the density
/// itself if it has few leaves, else a sample of its voxels. `memory`: that it and its atlas may
/// take [bytes]; 0: not known.
Field overview_of(const Field& stored, Centering centering, std::uint64_t memory,
                  std::size_t most_leaves = std::size_t{1} << 14);  // 32 MiB of scalars

/// Gives all members of a team the first one's field: what it is, its leaves and tiles, and values
/// unless they stay in the file.
void take_first(Field& field, Team& team);

/// A text that differs, in all likelihood, between fields of different leaves.
std::string topology_of(const Field& field);

/// Whether several processes draw the volume together.
bool is_shared(const Parts& parts);
/// Bytes that the grids of one of them may take: those on one machine share what is free there.
std::uint64_t own_memory(const Scene& scene, const Parts& parts);

}  // namespace psivox
