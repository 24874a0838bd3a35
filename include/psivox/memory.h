#pragma once

#include <cstdint>

namespace psivox {

/// Memory that no process uses, or that the system would give up at once [bytes]; 0 if it is not
/// known.
std::uint64_t available_memory();

}  // namespace psivox
