#include "frame_maker.h"

#include "picture_output.h"
#include "psivox/stopwatch.h"

namespace psivox {

FrameMaker::FrameMaker(const RenderCall& call, const Scene& scene, const FrameList& list,
                       const CameraPath* path)
    : sequence_(resolve_sequence(scene, list.samples, "auto", shows_background(call),
                                 call.keep_going ? list.files : std::vector<std::string>())),
      turntable_(call.turntable),
      path_(path),
      follow_(call.follow),
      first_(list.first) {
  if (!turntable_ || scene.camera_position) return;
  // the camera as the scene sets it, in the look that was chosen
  Scene open = scene;
  open.up_axis = sequence_.scene.up_axis;
  const Scene framed = framed_for_turn(open, *sequence_.subject);
  keep_camera(sequence_.scene, make_camera(framed, *sequence_.subject));
}

Scene FrameMaker::moved(const Scene& scene, int frame) const {
  if (path_) return path_->at(scene, frame);
  if (turntable_) return turned(scene, 360.0 * (frame - first_) / *turntable_);
  return scene;
}

std::optional<Scene> FrameMaker::scene_of(const Frame& frame) const {
  if (follow_) return {};
  return moved(frame_scene(sequence_, VdbFile(frame.input), frame.input), frame.number);
}

ReadFrame FrameMaker::read(const Frame& frame) {
  const Stopwatch watch;
  if (last_input_ != frame.input) {
    last_session_.reset();
    const VdbFile file(frame.input);
    last_scene_ = frame_scene(sequence_, file, frame.input);
    View view = make_view(last_scene_, read_fields(last_scene_, file, true));
    if (follow_) view = followed(std::move(view));
    last_scene_ = view.scene;
    last_session_ = std::make_shared<Session>(std::move(view));
    // a limit is for one volume: no other one is converted beside it
    if (last_scene_.memory_limit == 0 && last_scene_.renderer != RendererKind::reference)
      last_session_->convert();
    last_input_ = frame.input;
  }
  return {last_session_, moved(last_scene_, frame.number), watch.ms()};
}

}  // namespace psivox
