#pragma once

#include <span>
#include <string>

#include "psivox/medium.h"

namespace psivox {

/// On stderr: what was done to the grids as they were read and, if `auto` chose it, the extinction.
void print_notices(const View& view, bool chose_extinction);

/// On stderr, a line each.
void print_notices(std::span<const std::string> notices);

}  // namespace psivox
