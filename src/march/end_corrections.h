#pragma once

#include "psivox/medium.h"

namespace psivox {

/// Whether the view's march corrects the ends of its lattice: psi-balanced does, where rays may
/// begin inside the medium and nothing else in the scene forbids it.
bool has_end_corrections(const View& view);

}  // namespace psivox
