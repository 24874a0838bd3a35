#include <algorithm>
#include <cmath>
#include <map>

#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "psivox/stopwatch.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/report.h"
#include "study/results.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

// Work for the progress bar; the unit is one GPU render of a cheap variant.
constexpr double compile_work = 10;  // two programs, one of which counts
constexpr double reference_work = 10;
constexpr double double_work = 10;  // the march in double, relative to the GPU

/// The method that a plan chose, as a variant.
Variant variant_of(const Trial& chosen, const glm::ivec2& resolution) {
  Variant variant{chosen.method};
  if (is_cell_rule(chosen.method.integrator)) variant.method.segments = 0;
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
  void refuse_nothing() const;
  void check_texels();
  void resume();
  void make_references();
  Image make_reference(const Variant& variant);
  void measure(std::size_t i);
  void settle();
  void time(std::size_t i);

  Wish wish_of(const Variant& variant) const;
  PictureError split(const Variant& variant, const Drawn& drawn, PictureError& step_error);
  std::string same_picture(std::size_t i, const StudyPoint& point, const Image& image);
  void write_png(Image image, const Scene& scene, const fs::path& path) const;

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
    const glm::dvec2 own(scene_of(v, scene_).resolution), all(scene_.resolution);
    const Method& method = v.method;
    const double work = v.tolerance                            ? 3
                        : method.sampling == Sampling::uniform ? 0.5 / method.step
                                                               : 1 + 0.2 * method.segments;
    return 0.3 + work * own.x * own.y / (all.x * all.y);
  }
  double measure_work(std::size_t i) const;
  void add_up_work();
  void save() const;

  const StudyOptions& options_;
  Session session_;  ///< all draw it, in the light that the reference computes
  Scene scene_;      ///< the session's, without the parameters that the sweep sets
  std::shared_ptr<Marcher> gpu_, double_, reference_;
  StudyPlan plan_;
  StudyResults base_;                              ///< without points
  std::vector<std::optional<StudyPoint>> points_;  ///< one for each variant of the plan
  std::map<std::string, Image> references_;        ///< by reference_name(variant)
  double done_ = 0, all_work_ = 1;
};

/// The view of the scene that all variants share.
View shared_view(View view) {
  view.scene = studied_scene(view.scene);
  return view;
}

/// Whether the variants differ in their rule alone.
bool differ_in_rule(Variant a, const Variant& b) {
  a.method.integrator = b.method.integrator;
  return a == b && !a.tolerance;
}

StudyRun::StudyRun(View view, const StudyOptions& options)
    : options_(options),
      session_(shared_view(std::move(view))),
      scene_(session_.view().scene),
      gpu_(open_gpu({.device = scene_.device})),
      double_(open_double()),
      reference_(open_reference()) {
  plan_ = plan_study(options.sweep, scene_);
  base_ = new_results(session_.view(), description(*gpu_), options.repeats);
}

Wish StudyRun::wish_of(const Variant& variant) const {
  Wish wish;
  wish.scene = scene_of(variant, scene_);
  wish.progress = [this](Stage, double) { stop_if_asked(); };
  return wish;
}

void StudyRun::refuse_nothing() const {
  if (!plan_.variants.empty()) return;
  throw Error(ExitCode::usage,
              "the sweep has nothing to render: " +
                  (plan_.skipped.empty() ? "it is empty" : plan_.skipped.front().reason));
}

/// Removes from the plan the variants of a texel type that cannot hold the values.
void StudyRun::check_texels() {
  std::vector<Variant> kept;
  std::map<TexelType, std::string> found;  // the reason to refuse it, or empty
  for (const Variant& variant : plan_.variants) {
    const TexelType texel = variant.texel;
    if (!found.contains(texel)) {
      found[texel] = "";
      try {
        session_.prepare(*gpu_, wish_of(variant));
      } catch (const Error& error) {
        if (error.code() != ExitCode::input) throw;
        found[texel] = error.what();
      }
    }
    if (found[texel].empty())
      kept.push_back(variant);
    else
      plan_.skipped.push_back({variant, found[texel]});
  }
  plan_.variants = std::move(kept);
  refuse_nothing();
  base_.skipped = plan_.skipped;
  points_.resize(plan_.variants.size());
}

void StudyRun::resume() {
  if (!options_.resume || !fs::exists(options_.folder / results_name)) return;
  const StudyResults begun = read_results(options_.folder);
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

/// Reads the reference that an earlier run of the study left, or renders it. The bound always comes
/// from the layer as saved, so both cases give the same bound.
Image StudyRun::make_reference(const Variant& variant) {
  const fs::path path = options_.folder / (reference_name(variant) + ".exr");
  Wish wish = wish_of(variant);
  Scene own = scene_;
  own.resolution = wish.scene->resolution;
  wish.scene = own;
  wish.layers.error = true;
  const std::string scene = to_json(own);
  if (options_.resume && fs::exists(path) && read_metadata(path, "psivox:scene") == scene)
    return read_image(path);
  Image image = session_.draw(*reference_, wish).image;
  image.metadata["psivox:scene"] = scene;
  write_image(image, path);
  return image;
}

/// One reference for each resolution.
void StudyRun::make_references() {
  for (const Variant& variant : plan_.variants) {
    const std::string name = reference_name(variant);
    if (references_.contains(name)) continue;
    const Image& image = references_[name] = make_reference(variant);
    write_png(image, wish_of(variant).scene.value(), options_.folder / (name + ".png"));
    for (const Layer& layer : image.layers)
      if (layer.name == "error")
        for (const float bound : layer.values)
          base_.reference_bound = std::max(base_.reference_bound, double(bound));
  }
}

/// Step and arithmetic error, both from one march in double.
PictureError StudyRun::split(const Variant& variant, const Drawn& drawn, PictureError& step_error) {
  Wish wish = wish_of(variant);
  wish.plan = drawn.plan;
  const Image exact = session_.draw(*double_, wish).image;
  step_error = picture_error(exact, references_.at(reference_name(variant)));
  return picture_error(drawn.image, exact);
}

/// The name of a point that differs from this one in its rule alone and has the same picture but
/// for rounding; empty if there is none.
std::string StudyRun::same_picture(std::size_t i, const StudyPoint& point, const Image& image) {
  const double rounding = rounding_rms(image);
  for (std::size_t j = 0; j < points_.size(); ++j) {
    if (j == i || !points_[j] || !points_[j]->same_as.empty() ||
        !differ_in_rule(plan_.variants[j], point.variant) ||
        std::abs(points_[j]->error.rms() - point.error.rms()) > rounding)  // triangle inequality
      continue;
    const Image other = session_.draw(*gpu_, wish_of(plan_.variants[j])).image;
    if (picture_error(other, image).rms() <= rounding) return variant_name(plan_.variants[j]);
  }
  return {};
}

/// Writes the picture as `render` does, with the scene's background and exposure.
void StudyRun::write_png(Image image, const Scene& scene, const fs::path& path) const {
  write_picture(image, scene, legend_of(session_.view()), base_.renderer, {path.string()});
}

/// Measures all but the times; these results do not depend on when they are measured.
void StudyRun::measure(std::size_t i) {
  const Variant& variant = plan_.variants[i];
  StudyPoint point;
  point.variant = variant;
  if (points_[i]) point.times = points_[i]->times;

  Wish wish = wish_of(variant);
  Drawn drawn = session_.draw(*gpu_, wish);
  wish.plan = drawn.plan;
  wish.count = true;
  wish.confirm = false;
  const RenderStats counts = session_.draw(*gpu_, wish).stats;
  const Image& reference = references_.at(reference_name(variant));
  if (drawn.plan) {
    point.chosen = variant_of(drawn.plan->chosen, variant.resolution);
    point.estimate = drawn.plan->chosen.rms;
  }
  point.error = picture_error(drawn.image, reference);
  point.same_as = same_picture(i, point, drawn.image);
  const double rays = static_cast<double>(counts.rays);
  point.samples_per_ray = static_cast<double>(counts.samples) / rays;
  point.steps_per_ray = static_cast<double>(counts.steps) / rays;
  point.atlas_bytes = drawn.atlas.bytes();
  const Deviation& radiance = point.error.radiance;
  point.difference_scale = radiance.p99 > 0 ? radiance.p99 : radiance.max;
  if (options_.split) {
    PictureError step_error;
    point.arithmetic = split(variant, drawn, step_error);
    point.step_error = step_error;
  }
  const std::string file = file_name(variant) + ".png";
  write_image(difference_picture(drawn.image, reference, point.difference_scale),
              options_.folder / differences_folder / file);
  write_png(std::move(drawn.image), wish.scene.value(), options_.folder / pictures_folder / file);
  points_[i] = std::move(point);
}

/// Draws without timing, because drivers go on with new programs in the background after a first
/// draw: what is timed first would pay for it.
void StudyRun::settle() {
  constexpr double background_ms = 200;
  const Stopwatch watch;
  do session_.draw(*gpu_, wish_of(plan_.variants.front()));
  while (watch.ms() < background_ms);
}

void StudyRun::time(std::size_t i) {
  const Variant& variant = plan_.variants[i];
  Wish wish = wish_of(variant);
  wish.confirm = false;
  const Drawn drawn = session_.draw(*gpu_, wish);
  const RenderStats& stats = drawn.stats;
  const PreparationTimes& before = drawn.times;
  points_[i]->times.push_back(
      {before.plan_ms + stats.march_ms, stats.gpu_ms, before.plan_cpu_ms + stats.cpu_ms});
}

double StudyRun::measure_work(std::size_t i) const {
  const Variant& v = plan_.variants[i];
  const Variant& last = plan_.variants[i > 0 ? i - 1 : 0];
  const bool new_program = i == 0 || last.method.integrator != v.method.integrator ||
                           last.method.sampling != v.method.sampling || last.filter != v.filter ||
                           v.tolerance;
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
  refuse_nothing();
  session_.prepare(*reference_, wish_of(plan_.variants.front()));
  check_texels();
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
  const auto finished = [&](const auto& point) {
    return static_cast<int>(point->times.size()) >= options_.repeats;
  };
  if (!std::all_of(points_.begin(), points_.end(), finished)) settle();
  // Times are measured in rounds, so that a machine that slows down affects all variants alike.
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

std::string run_study(View view, const StudyOptions& options) {
  if (view.scene.shows(Shows::plane))
    throw Error(ExitCode::usage, "--mode slice does not march; a study has nothing to compare");
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
  return conclusion_text(run.results());
}

}  // namespace psivox
