#pragma once

#include <span>
#include <string>

#include "psivox/look.h"
#include "psivox/medium.h"

namespace psivox {

/// Prints to stderr how the grids were changed as they were read, and the numbers that `auto` chose
/// where `scene`, which the view resolves, leaves them open.
void print_notices(const View& view, const Scene& scene);

/// Prints to stderr, one line each.
void print_notices(std::span<const std::string> notices);

/// Prints what a look has chosen, as options that give the same picture, and the grids that the
/// picture does not show.
void print_look(const LookedScene& looked);

}  // namespace psivox
