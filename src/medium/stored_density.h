#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "medium/visible_parts.h"
#include "psivox/field.h"
#include "psivox/medium.h"
#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// How a density is surveyed whose values reading has left in the file.
struct SurveyOptions {
  const ReadOptions& reading;
  std::string subject{};     ///< begins messages
  std::uint64_t memory = 0;  ///< that an overview and its atlas may take; 0: not known
  int lod = 0;               ///< see survey_density
  Centering centering = Centering::node;
  std::size_t most_leaves = std::size_t{1} << 14;  ///< of an overview: 32 MiB of scalars
};

struct SurveyedDensity {
  Field field{};  ///< by which a view is chosen
  /// The density to draw, if it is not `field`: its values stay in the file, and `field` is an
  /// overview of it.
  std::optional<Field> drawn{};
  /// What the leaves of `field` weigh, if their values stay in the file.
  std::shared_ptr<const WeighedLeaves> weights{};
  bool is_coarse = false;  ///< `field` is the volume at level SurveyOptions::lod
};

/// Surveys a density of which the topology has been read, if its values stay in the file.
///
/// A process alone also weighs the leaves and ignores `lod`. In a team, each member surveys only
/// the leaves of the part that it will draw. Then all get the same ranges and the same
/// `field`, in memory. At a `lod` above 0 that is the coarse volume, which is also drawn. Else it
/// is an overview: the density itself if it has few leaves, otherwise a sample of its voxels.
/// Throws AgreedError(input) if they see different volumes, Error(input).
SurveyedDensity survey_density(Field field, const Parts& parts, const SurveyOptions& options);

/// Whether several processes draw the volume together.
bool is_shared(const Parts& parts);
/// Bytes that the grids of one of them may take: those on one machine share what is free there.
std::uint64_t own_memory(const Scene& scene, const Parts& parts);

}  // namespace psivox
