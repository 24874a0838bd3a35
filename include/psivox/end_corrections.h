#pragma once

#include "psivox/medium.h"

namespace psivox {

/// Whether the view's march adds psi-balanced's end corrections: its rays begin inside the medium,
/// and nothing else in the scene forbids them.
bool has_end_corrections(const View& view);

}  // namespace psivox
