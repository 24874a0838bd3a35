#pragma once

#include <string>

#include "psivox/vdb.h"

namespace psivox {

/// The scalar grid of a file that glows, if there is one beside its density: the first of flame,
/// flames, fire, temperature, heat, temp and fuel. Empty: none.
std::string flame_grid(const VdbFile& file, const std::string& density);

/// Whether the values look like those of a scan or a simulation stored as steps: at most 256
/// different ones, or none near 0, so that the field does not fade into its surroundings.
bool is_scan(const Field& density);

/// Whether most values are low, as those of vessels or plumes in their surroundings: their mean is
/// in the lowest quarter of the range.
bool is_mostly_low(const Field& density);

}  // namespace psivox
