#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

#include "git_hash.h"
#include "psivox/error.h"
#include "psivox/error_control.h"
#include "psivox/light.h"
#include "psivox/parameters.h"
#include "psivox/reference.h"
#include "psivox/renderer.h"
#include "psivox/stopwatch.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "study/difference_picture.h"
#include "study/folder.h"
#include "study/machine.h"
#include "study/report.h"
#include "study/results_table.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

constexpr const char* results_name = "results.json";

// Work for the progress bar, in units of one render of a cheap variant on the GPU.
constexpr double compile_work = 10;  // two programs, one of which counts
constexpr double reference_work = 10;
constexpr double double_work = 10;  // the march in double over that on the GPU

/// The view in another size of picture.
View resized(View view, const glm::ivec2& resolution) {
  view.scene.resolution = resolution;
  view.camera.half_height = view.camera.half_width / (double(resolution.x) / resolution.y);
  return view;
}

/// The way that a plan chose, as a variant.
Variant variant_of(const Trial& trial, const glm::ivec2& resolution) {
  Variant variant{trial.integrator, trial.sampling};
  if (trial.sampling == Sampling::uniform)
    variant.step = trial.step;
  else if (!is_cell_rule(trial.integrator))
    variant.segments = trial.segments;
  variant.resolution = resolution;
  return variant;
}

class StudyRun {
 public:
  StudyRun(View view, const StudyOptions& options);

  void run();
  void report() const { write_report(results(), options_.folder); }
  StudyResults results() const;
  std::string state() const;

 private:
  void light();
  void build_atlases();
  void resume();
  void make_references();
  Image make_reference(const Variant& variant);
  void measure(std::size_t i);
  void time(std::size_t i);

  View view_of(const Variant& variant) const;
  MarchPlan plan_of(const Variant& variant) const;
  View march_of(const Variant& variant);
  void upload(const Variant& variant);
  RenderResult render(const Variant& variant, bool count);
  PictureError split(const Variant& variant, const Image& gpu, PictureError& step_error);

  /// For the progress of long work: shows nothing, but stops it.
  Progress stopper() const {
    return [this](double) { stop_if_asked(); };
  }
  void stop_if_asked() const {
    if (options_.stop && options_.stop()) throw Error(ExitCode::interrupted, "interrupted");
  }
  bool measured(std::size_t i) const {
    return points_[i] && (!options_.split || points_[i]->arithmetic);
  }
  void did(double work) {
    done_ += work;
    if (options_.progress) options_.progress(done_ / all_work_);
  }
  double render_work(const Variant& v) const {
    const glm::dvec2 own(scene_of(v, view_.scene).resolution), all(view_.scene.resolution);
    const double work = v.tolerance                       ? 3
                        : v.sampling == Sampling::uniform ? 0.5 / v.step
                                                          : 1 + 0.2 * v.segments;
    return 0.3 + work * own.x * own.y / (all.x * all.y);
  }
  double measure_work(std::size_t i) const;
  void add_up_work();
  void save() const;

  const StudyOptions& options_;
  View view_;   ///< with its light computed
  View unlit_;  ///< as it came, for the reference's own light
  GlRenderer renderer_;
  StudyPlan plan_;
  StudyResults base_;                              ///< without points
  std::vector<std::optional<StudyPoint>> points_;  ///< one for each variant of the plan
  std::map<TexelType, MediumAtlas> atlases_;
  std::optional<std::pair<TexelType, Filter>> uploaded_;
  std::map<std::string, Image> references_;  ///< by reference_name(variant)
  std::map<std::string, MarchPlan> plans_;   ///< under tolerances, by variant_name(variant)
  double done_ = 0, all_work_ = 1;
};

StudyRun::StudyRun(View view, const StudyOptions& options)
    : options_(options), view_(std::move(view)), renderer_({view_.scene.device}) {
  view_.scene = without_sweep(view_.scene);
  unlit_ = view_;
  plan_ = plan_study(options.sweep, view_.scene);
  base_.version = PSIVOX_VERSION;
  base_.git = PSIVOX_GIT_HASH;
  base_.processor = processor_name();
  base_.system = system_name();
  base_.threads = static_cast<int>(std::thread::hardware_concurrency());
  base_.renderer = renderer_.description();
  base_.input = view_.scene.input;
  base_.input_hash = file_hash(view_.scene.input);
  base_.scene = to_json(view_.scene);
  base_.repeats = options.repeats;
}

/// Once, from the GPU, for all variants: its own error counts as theirs in step and total error.
void StudyRun::light() {
  if (!view_.medium.light) return;
  const MediumAtlas atlas = build_medium_atlas(view_);
  renderer_.upload(atlas);
  view_ = lit(std::move(view_), renderer_.light_depths(view_), stopper());
}

/// Of every texel type; a type that cannot hold the values takes its variants out of the plan.
void StudyRun::build_atlases() {
  std::vector<Variant> kept;
  std::map<TexelType, std::string> refused;
  for (const Variant& variant : plan_.variants) {
    const TexelType texel = variant.texel;
    if (!atlases_.contains(texel) && !refused.contains(texel)) {
      try {
        atlases_.emplace(texel, build_medium_atlas(view_of(variant)));
      } catch (const Error& error) {
        if (error.code() != ExitCode::input) throw;
        refused[texel] = error.what();
      }
    }
    if (refused.contains(texel))
      plan_.skipped.push_back({variant, refused[texel]});
    else
      kept.push_back(variant);
  }
  plan_.variants = std::move(kept);
  if (plan_.variants.empty())
    throw Error(ExitCode::usage,
                "the sweep has nothing to render: " +
                    (plan_.skipped.empty() ? "it is empty" : plan_.skipped.front().reason));
  base_.skipped = plan_.skipped;
  points_.resize(plan_.variants.size());
}

void StudyRun::resume() {
  const fs::path path = options_.folder / results_name;
  if (!options_.resume || !fs::exists(path)) return;
  const StudyResults begun = results_from_json(read_text(path.string(), "study"), path.string());
  const std::string obstacle = resume_obstacle(begun, base_, plan_);
  if (!obstacle.empty())
    throw Error(ExitCode::usage, "cannot resume: the study in " +
                                     in_quotes(options_.folder.string()) + " " + obstacle +
                                     "; give another folder with -o");
  for (const StudyPoint& point : begun.points) {
    const auto at = std::find(plan_.variants.begin(), plan_.variants.end(), point.variant);
    points_[std::size_t(at - plan_.variants.begin())] = point;
  }
}

/// Read where an earlier run of the study left it, else rendered. The bound is of the layer as it
/// is kept, so that both ways give the same.
Image StudyRun::make_reference(const Variant& variant) {
  const fs::path path = options_.folder / (reference_name(variant) + ".exr");
  View view = resized(unlit_, scene_of(variant, unlit_.scene).resolution);
  const std::string scene = to_json(view.scene);
  if (options_.resume && fs::exists(path) && read_metadata(path, "psivox:scene") == scene)
    return read_image(path);
  if (view.medium.light) view = lit(std::move(view), reference_light_depths(unlit_), stopper());
  Image image = render_reference(view, 1e-12, stopper()).image;
  image.metadata["psivox:scene"] = scene;
  write_image(image, path);
  return image;
}

/// One for each resolution.
void StudyRun::make_references() {
  for (const Variant& variant : plan_.variants) {
    const std::string name = reference_name(variant);
    if (references_.contains(name)) continue;
    const Image& image = references_[name] = make_reference(variant);
    write_image(image, options_.folder / (name + ".png"));
    for (const Layer& layer : image.layers)
      if (layer.name == "error")
        for (const float bound : layer.values)
          base_.reference_bound = std::max(base_.reference_bound, double(bound));
  }
}

View StudyRun::view_of(const Variant& variant) const {
  View view = view_;
  view.scene = scene_of(variant, view_.scene);
  return resized(view, view.scene.resolution);
}

MarchPlan StudyRun::plan_of(const Variant& variant) const {
  return plan_march(view_of(variant), atlases_.at(variant.texel));
}

/// The view as it is to be marched: under a tolerance as the plan says, which is always the same.
View StudyRun::march_of(const Variant& variant) {
  if (!variant.tolerance) return view_of(variant);
  const std::string name = variant_name(variant);
  const auto found = plans_.find(name);
  return (found != plans_.end() ? found : plans_.emplace(name, plan_of(variant)).first)
      ->second.view;
}

void StudyRun::upload(const Variant& variant) {
  const auto wanted = std::pair(variant.texel, variant.filter);
  if (uploaded_ == wanted) return;
  uploaded_.reset();
  renderer_.upload(atlases_.at(variant.texel), variant.filter);
  uploaded_ = wanted;
}

RenderResult StudyRun::render(const Variant& variant, bool count) {
  upload(variant);
  RenderOptions options;
  options.count = count;
  options.progress = stopper();
  return renderer_.render(march_of(variant), options);
}

PictureError StudyRun::split(const Variant& variant, const Image& gpu, PictureError& step_error) {
  RenderOptions options;
  options.progress = stopper();
  const Image exact =
      render_march_double(march_of(variant), atlases_.at(variant.texel), options).image;
  step_error = picture_error(exact, references_.at(reference_name(variant)));
  return picture_error(gpu, exact);
}

/// All but the times: what does not depend on when it is measured.
void StudyRun::measure(std::size_t i) {
  const Variant& variant = plan_.variants[i];
  StudyPoint point;
  point.variant = variant;
  if (points_[i]) point.times = points_[i]->times;

  const RenderResult drawn = render(variant, false);
  const RenderStats counts = render(variant, true).stats;
  const Image& reference = references_.at(reference_name(variant));
  if (variant.tolerance) {
    MarchPlan& plan = plans_.at(variant_name(variant));
    if (plan.rays() > 0) confirm(plan, renderer_.render(pilot_view(plan.view)).image);
    const Trial& chosen = plan.chosen;
    point.chosen = variant_of(chosen, variant.resolution);
    point.estimate = chosen.rms;
  }
  point.error = picture_error(drawn.image, reference);
  const double rays = static_cast<double>(counts.rays);
  point.samples_per_ray = static_cast<double>(counts.samples) / rays;
  point.steps_per_ray = static_cast<double>(counts.steps) / rays;
  point.atlas_bytes = atlases_.at(variant.texel).size().bytes();
  const Deviation& radiance = point.error.radiance;
  point.difference_scale = radiance.p99 > 0 ? radiance.p99 : radiance.max;
  if (options_.split) {
    PictureError step_error;
    point.arithmetic = split(variant, drawn.image, step_error);
    point.step_error = step_error;
  }
  const std::string file = file_name(variant) + ".png";
  write_image(drawn.image, options_.folder / pictures_folder / file);
  write_image(difference_picture(drawn.image, reference, point.difference_scale),
              options_.folder / differences_folder / file);
  points_[i] = std::move(point);
}

void StudyRun::time(std::size_t i) {
  const Variant& variant = plan_.variants[i];
  const Stopwatch planning;
  if (variant.tolerance) plans_[variant_name(variant)] = plan_of(variant);
  const double plan_ms = planning.ms(), plan_cpu_ms = planning.cpu_ms();
  const RenderStats stats = render(variant, false).stats;
  points_[i]->times.push_back({plan_ms + stats.march_ms, stats.gpu_ms, plan_cpu_ms + stats.cpu_ms});
}

double StudyRun::measure_work(std::size_t i) const {
  const Variant& v = plan_.variants[i];
  const bool new_program = i == 0 || plan_.variants[i - 1].integrator != v.integrator ||
                           plan_.variants[i - 1].sampling != v.sampling ||
                           plan_.variants[i - 1].filter != v.filter || v.tolerance;
  return render_work(v) * (2 + (options_.split ? double_work : 0)) +
         (new_program ? compile_work : 0);
}

void StudyRun::add_up_work() {
  all_work_ = reference_work;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!measured(i)) all_work_ += measure_work(i);
    const auto timed = points_[i] ? static_cast<int>(points_[i]->times.size()) : 0;
    all_work_ += std::max(options_.repeats - timed, 0) * render_work(plan_.variants[i]);
  }
}

StudyResults StudyRun::results() const {
  StudyResults results = base_;
  for (const auto& point : points_)
    if (point) results.points.push_back(*point);
  return results;
}

void StudyRun::save() const {
  const StudyResults now = results();
  write_text((options_.folder / "results.csv").string(), results_csv(now));
  write_text((options_.folder / results_name).string(), results_json(now));
}

std::string StudyRun::state() const {
  const auto finished = std::count_if(points_.begin(), points_.end(), [&](const auto& point) {
    return point && static_cast<int>(point->times.size()) >= options_.repeats;
  });
  return std::to_string(finished) + " of " + std::to_string(points_.size()) +
         " points are finished";
}

void StudyRun::run() {
  light();
  build_atlases();
  resume();
  for (const char* folder : {pictures_folder, differences_folder})
    make_folder(options_.folder / folder);
  add_up_work();
  if (!fs::exists(options_.folder / results_name)) save();
  make_references();
  did(reference_work);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (measured(i)) continue;
    measure(i);
    save();
    did(measure_work(i));
  }
  // Round by round, so that a machine that slows down does so for all variants alike.
  for (int round = 0; round < options_.repeats; ++round)
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (static_cast<int>(points_[i]->times.size()) > round) continue;
      time(i);
      save();
      did(render_work(plan_.variants[i]));
    }
  save();
}

}  // namespace

void check_study_folder(const fs::path& folder, bool resume) {
  if (!resume && fs::exists(folder / results_name))
    throw Error(ExitCode::usage, in_quotes(folder.string()) +
                                     " holds the results of a study; --resume goes on with it, or "
                                     "give another folder with -o");
  make_folder(folder);
}

void run_study(View view, const StudyOptions& options) {
  check_study_folder(options.folder, options.resume);
  StudyRun run(std::move(view), options);
  try {
    run.run();
  } catch (const Error& error) {
    if (error.code() != ExitCode::interrupted) throw;
    run.report();
    throw Error(ExitCode::interrupted, "interrupted: " + run.state() + " in " +
                                           in_quotes(options.folder.string()) +
                                           "; --resume goes on with it");
  }
  run.report();
  if (options.progress) options.progress(1);
}

}  // namespace psivox
