#include "drawing.h"

#include <unistd.h>

#include <algorithm>
#include <map>

#include "psivox/camera.h"
#include "psivox/open.h"

namespace psivox::python {
namespace {

void add_once(std::vector<std::string>& notices, const std::string& notice) {
  if (!notice.empty() && !std::ranges::count(notices, notice)) notices.push_back(notice);
}

/// Checks what needs no work.
void check(const Scene& scene, const PictureWords& wanted) {
  check_picture(scene, wanted.layers);
  if (wanted.check_error > 0 && scene.shows(Shows::plane))
    throw Error(ExitCode::usage, "--mode slice does not march: it has no error to check");
  if (const std::string no = page_obstacle(scene); wanted.page && !no.empty())
    throw Error(ExitCode::usage, no);
  check_picture_memory(scene.resolution.x, scene.resolution.y, int(wanted.layers.size()), 0);
}

bool is_same(const Scene& a, const Scene& b) {
  return std::ranges::all_of(parameters(), [&](const Parameter& p) { return has_same(a, b, p); });
}

/// A marcher that another thread may take afterwards.
struct Released {
  Marcher& marcher;
  ~Released() { release(marcher); }
};

/// Says which thread draws, while it does.
struct DrawingThread {
  std::atomic<std::thread::id>& thread;
  explicit DrawingThread(std::atomic<std::thread::id>& told) : thread(told) {
    thread = std::this_thread::get_id();
  }
  ~DrawingThread() { thread = std::thread::id(); }
};

constexpr std::uint64_t large_atlas = 64 << 20;  // [bytes]
constexpr std::size_t most_idle = 2;

/// Marchers that nobody draws with now. Never destroyed: drivers end before a static object would.
struct Pool {
  std::mutex mutex;
  std::multimap<MarcherKey, std::shared_ptr<Marcher>> idle;
};
Pool& pool() {
  static auto* const kept = new Pool;
  return *kept;
}

}  // namespace

bool SceneWords::give(const std::string& name) const {
  return std::ranges::any_of(settings, [&](const auto& setting) { return setting.first == name; });
}

Scene scene_of(const SceneWords& words, const VolumeFile& file, Scene scene) {
  if (!words.base.empty()) scene = scene_from_json(words.base);
  if (!words.base_file.empty()) scene = read_scene_file(words.base_file).scene;
  std::vector<Setting> settings;
  for (const auto& [name, text] : words.settings) settings.push_back({name, text});
  scene = with_settings(std::move(scene), words.camera, settings, [&](const Scene& known) {
    return known.up_axis == UpAxis::automatic ? !file.z_up().empty() : known.up_axis == UpAxis::z;
  });
  validate(scene);
  return scene;
}

std::vector<std::string> write(const Picture& picture, const std::string& path,
                               const WriteOptions& format) {
  check_writable(path, format, picture.image.width, picture.image.height);
  Image image = picture.image;
  Scene scene = picture.scene;
  if (!scene.background && shows_background(path, format))
    scene.background = picture.look_background;
  if (holds_codes(path, format) && !scene.exposure) scene.exposure = picture.auto_exposure;
  PictureFile file{path, format, {}};
  if (holds_layers(path)) file.layers = picture.layers;
  return write_picture(image, scene, picture.legend, picture.renderer, file).notices;
}

Drawing::Drawing(std::shared_ptr<const VolumeFile> file, const SceneWords& words)
    : file_(std::move(file)),
      given_(scene_of(words, *file_)),
      gives_background_(words.give("background")) {
  for (const auto& [name, text] : words.settings)
    if (const Parameter* p = find_parameter(name)) add_once(color_notices_, color_notice(*p, text));
}

void Drawing::prepare(const Scene& given, const Progress& progress) {
  session_.reset();
  progress(0);
  // what else one picture has does not choose the look of those that follow
  prepared_ = given_;
  for (const Parameter& p : parameters()) {
    if (!belongs_to_medium(p)) continue;
    copy_parameter(given, prepared_, p);
    if (given.given.contains(p.name))
      prepared_.given.insert(p.name);
    else
      prepared_.given.erase(p.name);
  }
  prepared_.tolerance = with_default_tolerance(given).tolerance;
  OpenedScene opened = open_scene(prepared_, *file_, {.parts = {.allowed = true}});
  progress(0);
  looked_ = std::move(opened.looked.scene);
  look_background_ = std::exchange(looked_.background, {});
  opened.view.scene.background.reset();
  own_ = in_look(given, looked_);
  if (!is_same(own_, looked_)) opened = open_scene(own_, std::move(opened.looked.fields));
  notices_ = color_notices_;
  for (const std::string& notice : notices_of(opened.view)) add_once(notices_, notice);
  session_.emplace(std::move(opened.view));
}

bool Drawing::is_prepared(const Scene& given) const {
  return session_ && std::ranges::all_of(parameters(), [&](const Parameter& p) {
           return !belongs_to_medium(p) ||
                  (has_same(given, prepared_, p) && is_given(given, p) == is_given(prepared_, p));
         });
}

Scene Drawing::in_look(const Scene& given, Scene scene) const {
  for (const Parameter& p : parameters()) {
    if (belongs_to_medium(p)) continue;
    const bool by_look = !has_same(looked_, prepared_, p) && leaves_to_look(given, p.name);
    copy_parameter(by_look ? looked_ : given, scene, p);
  }
  scene.tolerance = with_default_tolerance(given).tolerance;
  return scene;
}

Picture Drawing::finish(Drawn drawn, const Wish& wish, const PictureWords& wanted) {
  View view = std::move(drawn.view);
  if (wish.scene) {
    keep_camera(view.scene, view.camera);
    view.scene.up_axis = z_is_up(view.scene, *view.subject) ? UpAxis::z : UpAxis::y;
  }
  Picture picture;
  picture.notices = notices_;
  for (const std::string& notice : drawn.notices) add_once(picture.notices, notice);
  add_once(picture.notices, blank_reason(view, drawn.image));
  picture.image = std::move(drawn.image);
  picture.scene = view.scene;
  picture.look_background = look_background_;
  if (!view.scene.exposure)
    picture.auto_exposure = auto_exposure(picture.image, view.scene.tone_map);
  picture.legend = legend_of(view);
  if (view.scene.background)
    add_background(picture.image, view.scene.background->color, picture.legend.behind);
  picture.layers = wanted.layers;
  picture.renderer = drawn.stats.renderer;
  picture.plan = std::move(drawn.plan);
  if (picture.plan) picture.plan->march.reset();
  return picture;
}

Picture Drawing::draw(const SceneWords& words, const PictureWords& wanted,
                      const Progress& progress) {
  check_not_drawing();
  const std::lock_guard lock(mutex_);
  const DrawingThread drawing(drawing_);
  const Scene given = scene_of(words, *file_, given_);
  check(given, wanted);
  if (!is_prepared(given)) prepare(given, progress);
  Wish wish;
  if (!is_same(in_look(given, looked_), own_)) wish.scene = in_look(given, session_->view().scene);
  wish.layers = layers_of(wanted.layers);
  wish.fewest_bytes = wanted.page.has_value();
  wish.progress = over_stages(progress);
  if (wanted.page) check_page(*session_, wish.scene.value_or(session_->view().scene), *wanted.page);
  try {
    if (lease_ && !lease_->fits(given)) lease_.reset();
    if (!lease_) lease_.emplace(given);
    const Released used{lease_->marcher()};
    Drawn drawn = session_->draw(used.marcher, wish);
    lease_->large = drawn.atlas.bytes() > large_atlas;
    std::optional<CheckedError> checked;
    if (wanted.check_error > 0)
      checked =
          session_->check_error(drawn, wanted.check_error, [&](Stage, double) { progress(1); });
    const bool by_look = !gives_background_ && !words.give("background");
    std::string page;
    if (wanted.page) {
      if (by_look) drawn.view.scene.background = look_background_;
      page = page_text(*session_, drawn, *wanted.page);
      if (by_look) drawn.view.scene.background.reset();
    }
    Picture picture = finish(std::move(drawn), wish, wanted);
    if (!by_look) picture.look_background.reset();
    picture.checked = checked;
    picture.page = std::move(page);
    return picture;
  } catch (const Error& error) {
    if (lease_ && error.code() == ExitCode::graphics) {
      lease_->large = true;
      lease_.reset();
    }
    throw;
  }
}

void Drawing::check_not_drawing() const {
  if (drawing_ == std::this_thread::get_id())
    throw Error(ExitCode::usage,
                "progress cannot draw with the session that calls it, nor close it");
}

void Drawing::close() {
  check_not_drawing();
  const std::lock_guard lock(mutex_);
  lease_.reset();
}

View study_view(const VolumeFile& file, const SceneWords& words) {
  return open_scene(scene_of(words, file), file).view;
}

Lease::Lease(const Scene& scene) : key_(scene.renderer, scene.device) {
  {
    const std::lock_guard lock(pool().mutex);
    if (auto idle = pool().idle.extract(key_)) marcher_ = std::move(idle.mapped());
  }
  if (!marcher_) marcher_ = open_marcher(scene);
}

Lease::~Lease() {
  if (large) return;
  const std::lock_guard lock(pool().mutex);
  if (pool().idle.size() < most_idle) pool().idle.emplace(key_, marcher_);
}

void close_marchers() {
  const std::lock_guard lock(pool().mutex);
  pool().idle.clear();
}

void check_process() {
  static std::atomic<pid_t> first = 0;
  pid_t none = 0;
  const pid_t own = getpid();
  if (!first.compare_exchange_strong(none, own) && none != own)
    throw Error(ExitCode::failure,
                "this process was forked from one that has used psivox; start it with "
                "multiprocessing.get_context('spawn')");
}

}  // namespace psivox::python
