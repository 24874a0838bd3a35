#pragma once

#include <memory>
#include <string>

#include "psivox/field.h"
#include "psivox/ranks.h"
#include "psivox/vdb.h"

namespace psivox {

/// Shares the leaves of a density among ranks, all of which have read its topology: each rank's own
/// are those of the part of the volume that it will draw. It surveys them, and keeps their values
/// in memory until that part is read, if they and its atlas take no more than `memory` [bytes; 0:
/// not known]. All then have the same ranges. `subject` begins messages.
/// Throws AgreedError(input) if ranks see different volumes, Error(input).
void share_leaves(Field& field, const std::shared_ptr<Ranks>& ranks, const ReadOptions& options,
                  std::uint64_t memory, const std::string& subject);

/// Whether share_leaves has shared the field's leaves.
bool is_shared(const Field& field);

/// This process's own part of such a field, in memory: the box of voxels that none but this process
/// has, with its leaves, and the voxels that the cells of this box reach beyond it. Of another
/// field all of it.
struct OwnPart {
  std::shared_ptr<const Field> field;
  Box voxels;
};
OwnPart own_part(const std::shared_ptr<const Field>& field);

}  // namespace psivox
