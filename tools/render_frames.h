#pragma once

#include "frame_list.h"
#include "psivox/camera_motion.h"
#include "render_call.h"

namespace psivox {

/// Draws the frames of a sequence. While one is drawn, the next is read and converted, and the one
/// before is written, so that at most two volumes and two pictures are in memory. Throws
/// Error(input) at the end if --keep-going went on after frames that could not be read.
void render_frames(const RenderCall& call, const Scene& scene, const FrameList& list,
                   const CameraPath* path);

}  // namespace psivox
