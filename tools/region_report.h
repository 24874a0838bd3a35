#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psivox/regions.h"

namespace psivox {

/// What one of several processes would hold of a volume (psivox render under mpirun).
struct RegionRow {
  Region region;
  Box voxels;                ///< of the domain; empty if the region has none
  std::uint64_t leaves = 0;  ///< to read, with those that neighbours read too
  std::uint64_t values = 0;  ///< of these leaves [bytes]
  std::uint64_t atlas = 0;   ///< at most, in float32, on host and GPU [bytes]
};

/// A volume's split into as many regions as there are processes.
struct RegionReport {
  std::string path, grid;
  std::vector<RegionRow> rows;

  std::string json() const;
  std::string text() const;
};

/// Of the grid that `render` draws. Throws Error(input).
RegionReport regions_of(const std::string& path, int count);

}  // namespace psivox
