#pragma once

#include <functional>
#include <string>
#include <vector>

#include "psivox/camera.h"
#include "psivox/medium.h"
#include "psivox/scene.h"
#include "scene/camera_file.h"

// Cameras that move over the frames of a sequence.

namespace psivox {

/// The scene with its camera turned to the right by an angle [degrees], about the up axis through
/// its target. The scene's camera must be set.
Scene turned(Scene scene, double angle);

/// The scene with a camera that frames the subject from every side at one distance, so that it can
/// turn around the subject's middle. Unchanged if the scene sets the camera's position.
Scene framed_for_turn(const Scene& scene, const Subject& subject);

/// The view with its camera moved so that it looks at its own subject as the default camera does,
/// but from the distance and the direction that it has.
View followed(View view);

/// A camera at a place on its path. What no key sets is the scene's.
struct CameraKey {
  double frame = 0;
  Scene camera;         ///< its position, target, up and fov
  bool linear = false;  ///< until the next key; else eased in and out by 3s^2 - 2s^3
};

/// The way of a camera over a sequence's frames.
class CameraPath {
 public:
  /// Reads key frames, JSON: {"keys": [{"frame": 1, "position": [x,y,z], "target": ..., "up": ...,
  /// "fov": 40, "ease": "linear"}, ...]}; or the animation of a glTF file's first camera,
  /// `FILE:NAME` another, in which a frame is 1 / rate [s]. `z_up` as in read_camera. Throws
  /// Error(input).
  static CameraPath read(const std::string& path, bool z_up, double rate);

  /// The scene with the camera of a frame; before the first and after the last key, with theirs.
  Scene at(Scene scene, double frame) const;

  double first() const { return first_; }  ///< [frames]
  double last() const { return last_; }

 private:
  std::vector<CameraKey> keys_;                     ///< ascending
  std::function<FileCamera(double frame)> camera_;  ///< of an animation, in place of keys
  double first_ = 0, last_ = 0;
};

}  // namespace psivox
