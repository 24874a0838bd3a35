#pragma once

#include <utility>

#include "atlas/regions.h"
#include "draw/part_marcher.h"
#include "psivox/scene.h"
#include "psivox/team.h"

namespace psivox {

/// The modes in which regions' pictures are joined.
inline constexpr std::pair<const char*, Mode> joined_modes[] = {{"alpha", Mode::alpha},
                                                                {"mip", Mode::mip},
                                                                {"lmip", Mode::lmip},
                                                                {"mean", Mode::mean},
                                                                {"isosurface", Mode::isosurface},
                                                                {"xray", Mode::xray}};

/// Draws a volume region by region.
inline PartMarcher in_regions(Marcher& marcher, Regions regions) {
  return {marcher, {false, Regions({}, 1), std::move(regions)}, *alone()};
}

}  // namespace psivox
