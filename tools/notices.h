#pragma once

#include <span>
#include <string>

#include "psivox/medium.h"

namespace psivox {

/// Prints to stderr how the grids were changed as they were read, and the extinction if `auto`
/// chose it.
void print_notices(const View& view, bool chose_extinction);

/// Prints to stderr, one line each.
void print_notices(std::span<const std::string> notices);

}  // namespace psivox
