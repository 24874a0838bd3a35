#pragma once

#include "psivox/field.h"

namespace psivox {

/// Whether the values look like those of a scan or a simulation: whole steps of their greatest one,
/// at most 255 of them. In a grid that is not known to be a fog, integers and values that do not
/// fade to 0 tell so too.
bool is_scan(const Field& density, bool known_fog);

/// Whether most values are low, like those of vessels or plumes in their surroundings: their mean
/// is in the lowest quarter of the range.
bool is_mostly_low(const Field& density);

/// Whether values of both signs matter: the lower ones reach a twentieth of the greatest magnitude.
bool is_signed(const Field& density);

}  // namespace psivox
