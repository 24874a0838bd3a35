#pragma once

#include <string>

#include "psivox/scene.h"

namespace psivox {

/// A small picture of assets/blobs.vdb, marched from cell to cell to its end: whole or in parts, it
/// is the same but for rounding.
inline Scene blobs_scene() {
  Scene scene;
  scene.input = std::string(PSIVOX_ASSETS) + "/blobs.vdb";
  scene.extinction = 4;
  scene.resolution = {64, 48};
  scene.sampling = Sampling::cells;
  scene.early_termination = 0;
  return scene;
}

}  // namespace psivox
