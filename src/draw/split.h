#pragma once

#include <optional>
#include <string>

#include "atlas/regions.h"
#include "psivox/draw.h"

namespace psivox {

/// How a picture's volume is split: each member of a team draws one part of it, in one region or as
/// many as memory asks for.
struct Split {
  bool whole = true;               ///< one process draws it as one region, whose atlas may be kept
  Regions parts = Regions({}, 1);  ///< one for each member
  Regions own = Regions({}, 1);    ///< this member's part
};

/// The split by which the wish's team must draw a view. Alone, the volume is whole if its atlases
/// fit: on host and GPU they may take the scene's memory limit, or four fifths of the memory that
/// is free if it has none; and if only free memory is short and the picture cannot be drawn in
/// parts. Other grids than the density and its gradient stay whole. Members of a team that share a
/// machine share its memory, unless the scene has a limit, which is each member's; with light their
/// parts' values are in memory. Throws Error(memory) if the limit cannot be kept. `limit` stands
/// for the scene's [bytes].
Split split_of(const View& view, const Wish& wish, std::optional<double> limit = {});

}  // namespace psivox
