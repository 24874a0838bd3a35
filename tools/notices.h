#pragma once

#include "psivox/medium.h"

namespace psivox {

/// On stderr: what was done to the grids as they were read and, if `auto` chose it, the extinction.
void print_notices(const View& view, bool chose_extinction);

}  // namespace psivox
