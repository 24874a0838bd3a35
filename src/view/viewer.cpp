#include "view/viewer.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/text_file.h"
#include "view/command_text.h"
#include "view/recent_files.h"

namespace psivox::view {
namespace {

namespace fs = std::filesystem;

std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    return "out of memory; try --texel float16";
  } catch (const std::exception& e) {
    return e.what();
  }
}

std::string file_stamp(const std::string& path) {
  std::error_code missing;
  const auto time = fs::last_write_time(path, missing);
  if (missing) return "";
  const auto size = fs::file_size(path, missing);
  return std::to_string(time.time_since_epoch().count()) + "/" + std::to_string(size);
}

/// On the screen, where the picture has none.
constexpr glm::dvec3 no_background{0.006};

/// The right side of a comparison: the method of `other` as far as it needs no other volume, the
/// rest of `scene`.
Scene compared(const Scene& scene, const Scene& other) {
  Scene result = scene;
  for (const Parameter& p : parameters()) {
    const bool differs = p.group == ParameterGroup::accuracy && p.name != "split-knots" &&
                         p.under_tolerance != UnderTolerance::unchanged;
    if (differs) std::visit([&](auto member) { result.*member = other.*member; }, p.member);
  }
  return result;
}

}  // namespace

Viewer::Viewer(const Scene& scene, const ViewerOptions& options)
    : options_(options),
      window_({.size = scene.resolution, .egl = options.egl, .debug = options.debug}),
      gui_(window_),
      loader_(Window::wake),
      maker_({.budget_ms = options.frame_budget_ms,
              .device = scene.device,
              .debug = options.debug,
              .count_objects = options.count_objects},
             Window::wake),
      scene_(scene) {
  if (scene_.input.empty()) return;
  sequence_ = Sequence::of(scene_.input);
  scene_.input = sequence_.path();
  open_path_ = scene_.input;
}

Viewer::~Viewer() {
  window_.hide();  // the threads may take a moment to end
}

Scene Viewer::scene() const {
  Scene scene = scene_;
  const glm::ivec2 size = window_.size();
  if (size.x > 0 && size.y > 0) scene.resolution = size;
  if (!camera_due_) navigation_.apply(scene);
  return scene;
}

const Image* Viewer::complete_picture(std::size_t side) const {
  return refined_ && refined_ == wished_ ? display_.exact(refined_, side) : nullptr;
}

const Image* Viewer::exact_picture() const {
  return layer_ == ShownLayer::picture ? complete_picture() : nullptr;
}

void Viewer::photograph(const std::string& path) {
  photograph_ = path;
  draw(0.01);
}

void Viewer::error(const std::string& message) {
  ++problems_;
  last_error_ = message;
  message_.clear();
  message_since_ = Clock::now();
  frames_due_ = 3;
  std::fprintf(stderr, "psivox: %s\n", message.c_str());
}

void Viewer::say(const std::string& message) {
  last_error_.clear();
  message_ = message;
  message_since_ = Clock::now();
  frames_due_ = 3;
}

void Viewer::attempt(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    error(e.what());
  }
}

void Viewer::set_scene(const Scene& scene) {
  const Scene before = this->scene();
  scene_ = scene;
  const auto camera_of = [](const Scene& s) {
    std::string text;
    for (const Parameter& p : parameters())
      if (p.group == ParameterGroup::camera) text += parameter_text(s, p) + "\n";
    return text;
  };
  if (volume_ && camera_of(before) != camera_of(scene)) {
    try {
      navigation_.reset(this->scene(), volume_->box_min, volume_->box_max);
    } catch (const Error& e) {
      scene_ = before;
      error(e.what());
    }
  }
  frames_due_ = 3;
}

void Viewer::open(const std::string& path) {
  sequence_ = Sequence::of(path);
  Scene next = scene_;
  next.input = sequence_.path();
  for (std::string Scene::*grid :
       {&Scene::grid, &Scene::luminance_grid, &Scene::temperature_grid, &Scene::emission_grid})
    (next.*grid).clear();
  for (std::optional<glm::dvec3> Scene::*place : {&Scene::camera_position, &Scene::camera_target})
    (next.*place).reset();
  next.ortho_width.reset();
  next.extinction.reset();
  next.range.reset();
  next.isovalue.reset();
  scene_ = next;
  open_path_ = path;
  camera_due_ = true;
  refused_key_.clear();
  frames_due_ = 3;
}

void Viewer::compare(Comparison comparison, const std::optional<Scene>& other) {
  look_.comparison = comparison;
  other_ = comparison == Comparison::none ? std::nullopt : other;
  if (comparison != Comparison::none && !other_) {
    other_ = scene_;
    other_->tolerance.reset();
    if (scene_.mode != Mode::isosurface) {
      other_->step = 2 * scene_.resolved_step();
      other_->sampling = Sampling::uniform;
      other_->integrator.reset();
    }
  }
  frames_due_ = 3;
}

void Viewer::show(ShownLayer layer) {
  if (layer == layer_) return;
  layer_ = layer;
  layer_range_ = {};
  refined_ = 0;
  posted_.clear();
  frames_due_ = 3;
}

void Viewer::reload() {
  ++generation_;
  refused_key_.clear();
  attempt([&] {
    display_.reload_shader();
    maker_.reload_shaders();
  });
  frames_due_ = 3;
}

Scene Viewer::kept_scene() {
  Scene kept = scene();
  if (!picture_size_.empty()) set_parameter(kept, "resolution", picture_size_);
  if (const auto name = editor_.keep(kept)) {
    scene_.transfer_function = *name;
    say("the transfer function is in " + *name);
  }
  return kept;
}

std::string Viewer::copy_command_line() {
  const std::string line = render_command_line(kept_scene(), picture_path_);
  window_.set_clipboard(line);
  say("copied: " + line);
  return line;
}

void Viewer::save_scene(const std::string& path) {
  write_text(path, to_json(kept_scene()));
  say("saved " + path);
}

void Viewer::save_picture(const std::string& path) {
  if (!options_.render || save_.running()) return;
  std::vector<std::string> arguments = render_arguments(kept_scene(), path);
  arguments.insert(arguments.begin(), "--quiet");
  const auto task = [render = options_.render, arguments] {
    try {
      render(arguments);
    } catch (...) {
      return message_of(std::current_exception());
    }
    return std::string();
  };
  save_.start(path, task, Window::wake);
}

void Viewer::take_volume(std::shared_ptr<Volume> volume) {
  const bool first = !volume_;
  volume_ = std::move(volume);
  awaited_key_.reset();
  box_.reset();
  if (camera_due_) {
    if (!first || !navigation_.moved())
      navigation_.reset(scene_, volume_->box_min, volume_->box_max);
    camera_due_ = false;
    navigation_.set_viewport(scene().resolution);
    remember_file(scene_.input);
  }
  navigation_.set_box(volume_->box_min, volume_->box_max);
  window_.set_title(fs::path(scene_.input).filename().string() + " - psivox");
  if (!options_.quiet)
    for (const std::string& notice : volume_->notices)
      std::fprintf(stderr, "psivox: %s\n", notice.c_str());
}

void Viewer::take_loader_news() {
  VolumeLoader::News news = loader_.news();
  if (news.box && !volume_) {
    box_ = news.box;
    try {
      if (camera_due_ && !navigation_.moved()) navigation_.reset(scene_, box_->first, box_->second);
    } catch (const Error&) {  // make_view says it again
    }
    frames_due_ = 3;
  }
  if (!awaited_key_ || news.key != *awaited_key_) return;
  frames_due_ = 3;
  try {
    if (news.error) std::rethrow_exception(news.error);
    take_volume(std::move(news.volume));
    return;
  } catch (...) {
    news.error = std::current_exception();
  }
  refused_key_ = news.key;
  awaited_key_.reset();
  error(message_of(news.error));
  if (!volume_) {
    first_error_ = news.error;
    return;
  }
  // what was there stays
  scene_ = with_medium_of(*volume_, scene_);
  sequence_ = Sequence::of(scene_.input);
  if (camera_due_) {
    camera_due_ = false;
    navigation_.hold();
  }
}

void Viewer::take_pictures() {
  PictureNews news = maker_.news();
  for (const PreviewPicture& picture : news.previews) {
    display_.set_preview(picture);
    shown_ = std::max(shown_, picture.number);
    rung_ = picture.rung;
    preview_ms_ = picture.ms;
    frames_due_ = std::max(frames_due_, 1);
  }
  for (const ExactPart& part : news.parts) {
    if (part.number != wished_) continue;
    display_.add_part(part);
  }
  if (news.estimated_rms) estimated_rms_ = news.estimated_rms;
  if (news.refined) {
    refined_ = *news.refined;
    refine_ms_ = news.refine_ms;
    frames_due_ = std::max(frames_due_, 2);
  }
  layer_range_ = news.layer_range.value_or(layer_range_);
  if (news.picked) navigation_.set_pivot(*news.picked);
  if (!news.renderer.empty()) renderer_ = news.renderer;
  picture_objects_ = news.objects;
  if (news.fatal && !shown_) first_error_ = news.fatal;
  for (const std::string& message : news.errors) error(message);
}

void Viewer::take_news() {
  take_loader_news();
  take_pictures();
  if (const auto outcome = save_.outcome()) {
    if (outcome->error.empty())
      say("saved " + outcome->what);
    else
      error(outcome->error);
  }
}

void Viewer::watch_files() {
  if (!options_.watch || Clock::now() - watched_at_ < std::chrono::milliseconds(500)) return;
  watched_at_ = Clock::now();
  const std::string stamp = file_stamp(scene_.input);
  const bool changed = watched_ == scene_.input && !stamp.empty() && stamp != watched_stamp_;
  watched_ = scene_.input;
  watched_stamp_ = stamp;
  if (changed) {
    ++generation_;
    refused_key_.clear();
    say("read again");
  }
}

void Viewer::step_sequence() {
  if (sequence_.empty() || !sequence_.playing || awaited_key_) return;
  const auto period = std::chrono::duration<double>(1 / std::max(sequence_.rate, 0.1));
  if (Clock::now() - stepped_at_ < period || shown_ != wished_) return;
  stepped_at_ = Clock::now();
  sequence_.go_to(sequence_.next());
}

void Viewer::update_wishes() {
  if (!sequence_.empty() && scene_.input != sequence_.path()) {
    navigation_.hold();
    scene_.input = sequence_.path();
  }
  const glm::ivec2 size = window_.size();
  if (size.x < 1 || size.y < 1 || scene_.input.empty()) return;
  navigation_.set_viewport(size);
  const Scene wanted = scene();
  const std::string key = volume_key(wanted, generation_);
  const bool at_hand = volume_ && volume_->key == key;
  if (at_hand) awaited_key_.reset();
  if (!at_hand && key != refused_key_ && key != awaited_key_) {
    loader_.load(wanted, generation_);
    awaited_key_ = key;
  }
  if (!volume_) return;
  std::vector<Scene> scenes{at_hand ? wanted : with_medium_of(*volume_, wanted)};
  if (other_) scenes.push_back(compared(scenes.front(), *other_));
  std::string text = std::to_string(static_cast<int>(layer_)) + "/";
  text += std::to_string(reinterpret_cast<std::uintptr_t>(volume_.get()));
  for (const Scene& scene : scenes) text += to_json(scene);
  if (text == posted_) return;
  posted_ = text;
  try {
    for (const Scene& scene : scenes) validate(scene);
  } catch (const Error& e) {
    if (at_hand) error(e.what());
    return;
  }
  estimated_rms_.reset();
  maker_.wish({++wished_, volume_, std::move(scenes), layer_});
  if (at_hand && sequence_.playing) {
    Scene after = wanted;
    after.input = *sequence_.file(sequence_.next());
    loader_.prefetch(after, generation_);
  }
}

void Viewer::draw(double seconds) {
  const glm::ivec2 size = window_.size();
  if (size.x < 1 || size.y < 1) return;
  look_.background = scene_.background.value_or(no_background);
  DisplaySettings look = look_;
  if (layer_ != ShownLayer::picture) look.exposure = 0;  // colours mean values
  display_.draw(size, look);
  gui_.begin_frame(size, seconds);
  draw_panels();
  gui_.end_frame();
  if (options_.debug)
    for (const std::string& problem : window_.problems()) error("OpenGL: " + problem);
  if (!photograph_.empty()) write_image(window_.grab(), std::exchange(photograph_, {}));
  window_.swap();
}

bool Viewer::frame(double wait_s) {
  const bool busy = awaited_key_ || refined_ != wished_ || sequence_.playing ||
                    flying_ != glm::dvec3(0) || save_.running();
  double wait = frames_due_ > 0 ? 0 : busy ? std::min(wait_s, 0.1) : wait_s;
  if (flying_ != glm::dvec3(0) || sequence_.playing) wait = std::min(wait, 0.01);
  const std::vector<Event> events = window_.wait(wait);
  for (const Event& event : events) handle(event);
  // A drag of the picture shows in the picture alone: the window's time is better spent on that.
  if (!events.empty() && dragging_ < 0) frames_due_ = 3;
  const auto now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - last_frame_).count();
  fly(now);
  watch_files();
  take_news();
  if (first_error_) std::rethrow_exception(first_error_);
  step_sequence();
  update_wishes();
  // What refines, loads or is saved is shown now and then: drawing the window takes time from it.
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
