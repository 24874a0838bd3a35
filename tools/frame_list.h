#pragma once

#include <optional>
#include <string>
#include <vector>

#include "psivox/draw.h"
#include "psivox/sequence.h"
#include "render_call.h"
#include "sequence/camera_motion.h"

namespace psivox {

struct Frame {
  int number = 0;
  std::string input, output;  ///< `output` is empty if only a film is written
};

struct FrameList {
  std::vector<Frame> frames;         ///< ascending
  int first = 1;                     ///< number of the sequence's first frame, drawn or not
  std::vector<std::string> files;    ///< of the sequence, drawn or not
  std::vector<std::string> samples;  ///< files from which `auto` chooses
  std::vector<std::string> notices;  ///< one line each
};

/// The frames of files. Throws Error(usage), and Error(input) for frames that are missing.
FrameList list_files(const FrameOptions& options, const SequenceFiles& files);

/// The frames that a call asks for; unset: it asks for one picture. `path`: the camera's, or null.
/// Throws Error(usage), and Error(input) for frames that are missing.
std::optional<FrameList> list_frames(const RenderCall& call, const Scene& scene,
                                     const CameraPath* path);

/// Prints to stderr the look that was chosen for all frames, or what it sets, as options.
void print_choice(const SequenceScene& sequence, const FrameList& list, bool to_copy = true);

/// Draws the frames of a sequence. While one is drawn, the next is read and converted, and the one
/// before is written, so that at most two volumes and two pictures are in memory. Throws
/// Error(input) at the end if --keep-going went on after frames that could not be read.
void render_frames(const RenderCall& call, const Scene& scene, const FrameList& list,
                   const CameraPath* path);

}  // namespace psivox
