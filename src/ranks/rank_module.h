#pragma once

#include <string>

#include "psivox/ranks.h"

namespace psivox {

/// A module's one symbol (src/mpi). There is one module for each MPI that the build found, so that
/// libpsivox needs none, and one build runs under both.
inline constexpr const char* open_ranks_symbol = "psivox_open_ranks";
using OpenRanks = Ranks* (*)();

/// The file of the module for an MPI: `openmpi` or `mpich`.
inline std::string rank_module(const std::string& mpi) { return "libpsivox_" + mpi + ".so"; }

}  // namespace psivox
