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
  std::uint64_t memory = 0;  ///< that the member's leaves and their atlas may take; 0: not known
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
/// A process that is alone weighs the leaves, too; it does not look at `lod`. Of several each
/// surveys its own leaves, which are in the part of the volume that it will draw. It keeps their
/// values until they are read for that, if they and their atlas take no more than `memory`. Then
/// all get the same ranges and the same `field`, which is in memory: at a `lod` above 0 the coarse
/// volume, which is also the one to draw; else an overview, which is the density itself if that has
/// few leaves, and otherwise a sample of its voxels.
/// Throws AgreedError(input) if they see different volumes, Error(input).
SurveyedDensity survey_density(Field field, const Parts& parts, const SurveyOptions& options);

/// Whether several processes draw the volume together.
bool is_shared(const Parts& parts);
/// Bytes that the grids of one of them may take: those on one machine share what is free there.
std::uint64_t own_memory(const Scene& scene, const Parts& parts);

}  // namespace psivox
