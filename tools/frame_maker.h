#pragma once

#include <memory>
#include <string>

#include "frame_list.h"
#include "psivox/camera_motion.h"
#include "psivox/draw.h"
#include "psivox/sequence.h"

namespace psivox {

/// A frame that was read.
struct ReadFrame {
  std::shared_ptr<Session> session;
  Scene scene;         ///< to draw, complete
  double read_ms = 0;  ///< reading and converting
};

/// Knows the scene of each frame, and reads frames. Only one thread may use it at a time.
class FrameMaker {
 public:
  FrameMaker(const RenderCall& call, const Scene& scene, const FrameList& list,
             const CameraPath* path);

  const SequenceScene& sequence() const { return sequence_; }

  /// The frame's scene as its picture's metadata has it, without reading voxels; unset if the
  /// camera follows what they show. Throws Error(input).
  std::optional<Scene> scene_of(const Frame& frame) const;

  /// Reads a frame; the session of the frame before if that has the same file. Throws Error(input),
  /// Error(memory).
  ReadFrame read(const Frame& frame);

 private:
  Scene moved(const Scene& scene, int frame) const;

  SequenceScene sequence_;
  std::optional<int> turntable_;
  const CameraPath* path_;
  bool follow_;
  int first_;
  std::string last_input_;
  std::shared_ptr<Session> last_session_;
  Scene last_scene_;
};

}  // namespace psivox
