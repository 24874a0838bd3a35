#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "psivox/scene.h"
#include "psivox/team.h"

// Drawing a volume in parts, because it takes more memory than it may.

namespace psivox {

/// Where the values of a scene's density may be.
struct Parts {
  /// If they take more than half of grid_memory(), they may stay in the file, provided that the
  /// scene can be drawn in parts.
  bool allowed = false;
  /// In a team of several they stay in the file if they can, however few they are. Each member
  /// reads the values of its own part.
  std::shared_ptr<Team> team = alone();
};

/// Which pictures can be drawn in parts, if the scene's cannot, as the rest of a sentence; else
/// empty.
std::string parts_obstacle(const Scene& scene);

/// Bytes that a scene's grids may take on host and GPU together: its memory limit without what the
/// program itself and the picture take, but no less than 32 MiB or the limit; or four fifths of the
/// memory that is free, if it has no limit. 0: not known.
std::uint64_t grid_memory(const Scene& scene);

}  // namespace psivox
