#pragma once

#include <span>
#include <string>

#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// A scalar grid that glows.
struct Flame {
  std::string grid;     ///< empty: none
  double greatest = 0;  ///< value
};

/// Names of grids of flames; `hot`: and, after them, of heat, which may only drive a smoke.
std::span<const char* const> flame_names(bool hot);

/// What glows beside a file's density: its flame, if it has a grid of that name; else its heat.
/// Nothing glows where no value is above 0.
Flame find_flame(const VdbFile& file, const std::string& density);

/// Sets the emission that `asked` leaves open to black bodies over a flame. Values above 200 are
/// Kelvin; others become 800 K at 0 and 2300 K at the greatest. The emission's scale makes the
/// brightest hundredth of what glows four times as bright as white, which a filmic curve shows as
/// nearly white with red edges. A flame that the camera does not see
/// sets nothing.
void set_flame(const Scene& asked, const VdbFile& file, const Flame& flame, Scene& scene);

}  // namespace psivox
