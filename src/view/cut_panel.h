#pragma once

#include <glm/vec3.hpp>

#include "psivox/camera.h"
#include "psivox/scene.h"

namespace psivox::view {

/// What the panel's user did.
struct CutEdits {
  bool sliced = false;   ///< the slice was moved
  bool turned = false;   ///< and has another normal: the camera may want to face it
  bool clipped = false;  ///< the clip was changed
};

/// Widgets of --slice, under its mode, --clip and --clip-plane: their axes, and sliders over the
/// subject's box. `forward` is the direction of the view, which a plane may take as its normal.
CutEdits edit_cuts(Scene& scene, const Subject& subject, const glm::dvec3& forward);

}  // namespace psivox::view
