#pragma once

#include <span>
#include <string>

#include "psivox/open.h"

namespace psivox {

/// Prints to stderr, one line each.
void print_notices(std::span<const std::string> notices);

/// "look smoke" and how to see the options that give the same picture, or these options.
std::string look_text(const std::string& look, std::span<const Setting> settings, bool to_copy,
                      const std::string& how = "-v prints its options");

/// Prints the look, and the grids that the picture does not show.
void print_look(const LookedScene& looked, bool to_copy,
                const std::string& how = "-v prints its options");

/// Prints how the grids were changed as they were read, and the numbers that `auto` chose where the
/// look leaves them open: rounded, or as options to copy.
void print_choices(const OpenedScene& opened, bool to_copy);

}  // namespace psivox
