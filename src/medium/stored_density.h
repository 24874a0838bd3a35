#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "medium/visible_parts.h"
#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/team.h"
#include "psivox/vdb.h"

namespace psivox {

/// How a density is surveyed whose values reading has left in the file.
struct SurveyOptions {
  const ReadOptions& reading;
  std::string subject{};     ///< begins messages
  std::uint64_t memory = 0;  ///< that the member's leaves and their atlas may take; 0: not known
  int lod = 0;               ///< of a density that a team shares
  Centering centering = Centering::node;
  std::size_t most_leaves = std::size_t{1} << 14;  ///< of an overview: 32 MiB of scalars
};

struct SurveyedDensity {
  Field field;  ///< by which a view is chosen
  /// The density to draw, if it is not `field`: its values stay in the file, and `field` is an
  /// overview of it.
  std::optional<Field> drawn;
  /// What the leaves of `field` weigh, if their values stay in the file.
  std::shared_ptr<const WeighedLeaves> weights;
  bool is_coarse = false;  ///< `field` is the volume as --lod has it
};

/// Surveys a density of which the topology has been read, if its values stay in the file.
///
/// In a team each member surveys its own leaves: those of the part of the volume that it will draw.
/// It keeps their values until they are read for that, if they and their atlas take no more than
/// `memory`. All members then get the same ranges and the same overview, in memory: the density
/// itself if it has few leaves, else a part of its voxels. With `lod` that is the volume to draw.
/// Throws AgreedError(input) if members see different volumes, Error(input).
SurveyedDensity survey_density(Field density, Team& team, const SurveyOptions& options);

}  // namespace psivox
