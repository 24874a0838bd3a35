#include "view/viewer.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/stopwatch.h"
#include "base/terminal.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"

namespace psivox::view {
namespace {

/// Without a change for this long [s], things are at rest.
constexpr double rest_s = 0.12;

/// On the screen, if the scene has none.
constexpr glm::dvec3 no_background{0.006};

}  // namespace

Viewer::Viewer(const Scene& scene, const ViewerOptions& options)
    : options_(options),
      window_(scene.resolution, options.egl, options.debug),
      gui_(window_),
      volume_(Window::wake),
      maker_(options, scene.device, Window::wake),
      messages_([this] { redraw(3); }),
      now_{scene, LookChoice(scene), {}, options.inputs} {
  now_.look.ask(now_.look.start(), now_.scene, /*camera_too=*/true);
  if (now_.inputs.empty() && !now_.scene.input.empty()) now_.inputs = {now_.scene.input};
  if (now_.inputs.empty()) return;
  panels_.open_path = now_.inputs.front();
  now_.sequence = Sequence::of(now_.inputs);
  now_.scene.input = now_.sequence.path();
}

Viewer::~Viewer() {
  window_.hide();  // the threads may take a moment to end
}

Scene Viewer::scene() const {
  Scene scene = now_.scene;
  const glm::ivec2 size = window_.size();
  if (size.x > 0 && size.y > 0) scene.resolution = size;
  if (!camera_due_) navigation_.apply(scene);
  return scene;
}

std::optional<Image> Viewer::complete_picture(std::size_t side) const {
  if (!pictures_.complete()) return {};
  return display_.exact(pictures_.refined, side);
}

std::optional<Image> Viewer::exact_picture() const {
  if (layer_ != ShownLayer::picture) return {};
  return complete_picture();
}

void Viewer::redraw(int frames) { frames_due_ = std::max(frames_due_, frames); }

void Viewer::take_look() {
  fallback_.reset();
  const std::string chosen = now_.look.take(*volume(), now_.scene);
  if (chosen.empty()) return;
  messages_.say(chosen);
  if (!options_.quiet && options_.tell_look) options_.tell_look(*volume()->chosen);
}

void Viewer::take_volume(bool first) {
  take_look();
  if (camera_due_) {
    if (!first || !navigation_.moved()) navigation_.reset(now_.scene, *volume()->subject);
    camera_due_ = false;
    navigation_.set_viewport(scene().resolution);
    remember_file(now_.inputs.size() == 1 ? now_.inputs.front() : now_.scene.input);
  }
  navigation_.set_subject(*volume()->subject);
  // the default camera frames what the volume shows
  if (!navigation_.moved()) navigation_.reset(scene(), *volume()->subject);
  window_.set_title(std::filesystem::path(now_.scene.input).filename().string() + " - psivox");
  if (options_.quiet) return;
  for (const std::string& notice : volume()->notices) print_notice(notice);
}

void Viewer::keep_old_volume(const std::exception_ptr& refusal) {
  if (!volume() && (!fallback_ || fallback_->scene.input == now_.scene.input)) {
    first_error_ = refusal;
    return;
  }
  messages_.error(message_of(refusal));
  if (fallback_) {
    now_ = *std::exchange(fallback_, {});
  } else if (!now_.sequence.empty() && now_.scene.input != volume()->scene.input) {
    return;  // the next frame may be better
  } else {
    now_.scene = with_medium_of(*volume(), now_.scene);
  }
  if (!camera_due_ || !volume()) return;
  camera_due_ = false;
  navigation_.hold();
}

void Viewer::take_volume_news() {
  const bool first = !volume();
  const CurrentVolume::News news = volume_.take_news();
  if (news.subject && volume_.first_subject()) {
    redraw(3);
    try {
      if (camera_due_ && !navigation_.moved())
        navigation_.reset(now_.scene, *volume_.first_subject());
    } catch (const Error&) {  // loading the volume reports the same error
    }
  }
  if (news.error) return keep_old_volume(news.error);
  if (!news.volume) return;
  redraw(3);
  try {
    take_volume(first);
  } catch (...) {
    volume_.refuse();
    keep_old_volume(std::current_exception());
  }
}

void Viewer::take_pictures() {
  PictureNews news = maker_.news();
  for (PicturePart& picture : news.previews) {
    if (!now_.scene.exposure && picture.side == 0)
      auto_exposure_ = psivox::auto_exposure(picture.image, now_.scene.tone_map);
    display_.set_preview(std::move(picture));
    redraw(1);
  }
  for (const PicturePart& part : news.parts)
    if (part.number == pictures_.wished) display_.add_part(part);
  if (news.state.refined != pictures_.refined) redraw(2);
  const std::uint64_t wished = pictures_.wished;
  pictures_ = news.state;
  pictures_.wished = wished;
  if (news.picked) navigation_.set_pivot(*news.picked);
  if (news.probed) {
    probed_ = *news.probed;
    redraw(1);
  }
  if (news.fatal && !pictures_.shown) first_error_ = news.fatal;
  for (const std::string& message : news.errors) messages_.error(message);
}

void Viewer::take_saved() {
  if (!saving() || saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  messages_.attempt([&] {
    saving_.get();
    messages_.say("saved " + saved_path_);
  });
}

void Viewer::take_news() {
  take_volume_news();
  take_pictures();
  take_saved();
  if (first_error_) std::rethrow_exception(first_error_);
  if (options_.watch && watch_.changed(now_.scene.input)) {
    volume_.reload();
    messages_.say("read again");
  }
}

void Viewer::wish_pictures(const Scene& wanted, bool at_hand) {
  // of the volume at hand, too: a frame may lack a grid of the sequence's scene
  std::vector<Scene> scenes{with_medium_of(*volume(), wanted)};
  if (other_) scenes.push_back(with_method_of(*other_, scenes.front()));
  std::string text = std::to_string(int(layer_)) + "/" +
                     std::to_string(reinterpret_cast<std::uintptr_t>(volume()));
  for (Scene scene : scenes) {
    scene.exposure = Scene{}.exposure;  // of the window alone
    scene.tone_map = Scene{}.tone_map;
    text += to_json(scene);
  }
  if (text == posted_) return;
  posted_ = text;
  probed_.reset();
  try {
    for (const Scene& scene : scenes) validate(scene);
  } catch (const Error& e) {
    if (at_hand) messages_.error(e.what());
    return;
  }
  quiet_s_ = 0;
  maker_.wish({++pictures_.wished, volume_.get(), std::move(scenes), layer_});
  if (!at_hand || !now_.sequence.playing) return;
  Scene after = wanted;
  after.input = now_.sequence.file(now_.sequence.next());
  volume_.prefetch(after, now_.sequence.samples());
}

void Viewer::follow_sequence() {
  if (now_.sequence.empty() || now_.scene.input == now_.sequence.path()) return;
  if (!now_.scene.camera_position) navigation_.hold();
  // what auto chose for a file counts for those beside it; for a named sequence it was chosen
  if (at_hand_ && now_.sequence.samples().empty()) now_.look.hold(*volume(), now_.scene);
  if (at_hand_ && !now_.scene.exposure) now_.scene.exposure = auto_exposure_;
  now_.scene.input = now_.sequence.path();
}

void Viewer::update_wishes() {
  follow_sequence();
  const glm::ivec2 size = window_.size();
  if (size.x < 1 || size.y < 1 || now_.scene.input.empty()) return;
  navigation_.set_viewport(size);
  const Scene wanted = scene();
  at_hand_ = volume_.wish(wanted, now_.sequence.samples());
  if (volume()) wish_pictures(wanted, at_hand_);
}

void Viewer::notice_rest() {
  if (quiet_s_ < rest_s || rested_ == pictures_.wished) return;
  rested_ = pictures_.wished;
  maker_.rest(rested_);
}

void Viewer::handle(const Event& event) {
  gui_.feed(event);
  using Kind = Event::Kind;
  switch (event.kind) {
    case Kind::move:
      controls_.move(event);
      break;
    case Kind::button:
      controls_.button(event);
      break;
    case Kind::wheel:
      if (!gui_.takes_pointer()) navigation_.dolly(event.place.y);
      break;
    case Kind::key:
      controls_.key(event);
      break;
    case Kind::drop:
      if (!event.files.empty()) open(event.files);
      break;
    case Kind::close:
      closed_ = true;
      break;
    default:  // the window is drawn after every event
      break;
  }
}

void Viewer::draw(double seconds) {
  const glm::ivec2 size = window_.size();
  if (size.x < 1 || size.y < 1) return;
  settings_.background = now_.scene.background.value_or(no_background).color;
  settings_.display = {};  // of a layer, whose colours mean values
  if (layer_ == ShownLayer::picture) {
    settings_.display = display_of(now_.scene);
    settings_.display.exposure = exposure();
  }
  display_.draw(size, settings_);
  gui_.begin_frame(size, seconds);
  draw_panels(*this);
  changing_ &= gui_.editing();
  gui_.end_frame();
  if (options_.debug)
    for (const std::string& problem : window_.problems()) messages_.error("OpenGL: " + problem);
  if (!photograph_.empty()) write_image(window_.grab(), std::exchange(photograph_, {}));
  window_.swap();
}

bool Viewer::frame(double wait_s) {
  const bool moving = controls_.flying() || now_.sequence.playing;
  const bool busy = moving || loading() || pictures_.refined != pictures_.wished || saving();
  double wait = frames_due_ > 0 ? 0 : busy ? std::min(wait_s, 0.1) : wait_s;
  if (moving) wait = std::min(wait, 0.01);
  const Stopwatch waiting;
  const std::vector<Event> events = window_.wait(wait);
  // Time spent on drawing the window does not count: events wait meanwhile.
  quiet_s_ += 1e-3 * waiting.ms();
  for (const Event& event : events) handle(event);
  // A drag of the camera changes the picture alone, whose own news have the window drawn.
  if (!events.empty() && !controls_.dragging()) redraw(3);
  const auto now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - last_frame_).count();
  if (controls_.fly(now)) redraw(1);
  take_news();
  if (!loading() && pictures_.shown == pictures_.wished) now_.sequence.play(now);
  update_wishes();
  notice_rest();
  // Progress is shown ten times a second: drawing the window takes time from the work.
  if (frames_due_ > 0 || (busy && seconds > 0.1)) {
    frames_due_ = std::max(frames_due_ - 1, 0);
    last_frame_ = now;
    draw(seconds);
  }
  return !closed_;
}

void Viewer::run() {
  while (frame(0.5)) continue;
}

}  // namespace psivox::view
