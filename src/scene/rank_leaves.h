#pragma once

#include <memory>
#include <string>

#include "psivox/field.h"
#include "psivox/team.h"
#include "psivox/vdb.h"
#include "scene/leaf_weights.h"

namespace psivox {

/// Surveys a density of which the topology has been read, if its values stay in the file. `ranks`
/// (null: this process is alone) share its leaves: each rank's own are those of the part of the
/// volume that it will draw. It surveys them, and keeps their values in memory until that part is
/// read, if they and its atlas take no more than `memory` [bytes; 0: not known]. All then have the
/// same ranges. `subject` begins messages.
/// Throws AgreedError(input) if ranks see different volumes, Error(input).
void survey_leaves(Field& field, const std::shared_ptr<Team>& team, const ReadOptions& options,
                   std::uint64_t memory, const std::string& subject);

/// Whether ranks share the field's leaves.
bool is_shared(const Field& field);

/// What survey_leaves has found of the field's own leaves, weighed by their values; null if it has
/// not surveyed them, and once a part of the field has been read.
std::shared_ptr<const WeighedLeaves> weighed_leaves(const Field& field);

/// This process's own part of such a field, in memory: the box of voxels that none but this process
/// has, with its leaves, and the voxels that the cells of this box reach beyond it. Of another
/// field all of it.
struct OwnPart {
  std::shared_ptr<const Field> field;
  Box voxels;
};
OwnPart own_part(const std::shared_ptr<const Field>& field);

}  // namespace psivox
