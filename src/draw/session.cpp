#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "draw/lighting.h"
#include "draw/needed_regions.h"
#include "draw/pick.h"
#include "draw/picture.h"
#include "draw/rank_marcher.h"
#include "draw/region_marcher.h"
#include "march/explain.h"
#include "march/march_double.h"
#include "psivox/clip.h"
#include "psivox/parameters.h"
#include "psivox/stopwatch.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

/// Numbers the uploads: each is one session's atlas with one texel type and one filter.
std::uint64_t next_upload() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

Progress of_stage(const StageProgress& progress, Stage stage) {
  if (!progress) return {};
  return [&progress, stage](double fraction) { progress(stage, fraction); };
}

void enter(const StageProgress& progress, Stage stage) {
  if (progress) progress(stage, 0);
}

/// Part of a tolerance that the light may use up. The march has what is left, in quadrature.
constexpr double light_share = 0.5;

LightNeed light_need(const Marcher& marcher, const Scene& scene, const Wish& wish) {
  if (wish.any_light) return {};
  if (wish.exact || !marcher.approximates_light() || scene.light_quality == LightQuality::exact)
    return {.exact = true};
  if (scene.tolerance) return {.rms = light_share * *scene.tolerance};
  if (wish.time_budget_ms) return {.rms = light_share * default_tolerance};
  return {.exact = true};
}

}  // namespace

const char* stage_text(Stage stage) {
  switch (stage) {
    case Stage::converting:
      return "converting";
    case Stage::lighting:
      return "lighting";
    case Stage::uploading:
      return "uploading";
    case Stage::choosing:
      return "choosing the march";
    case Stage::marching:
      return "marching";
    case Stage::checking:
      break;
  }
  return "checking";
}

StageProgress over_stages(Progress bar, bool lit) {
  if (!bar) return {};
  return [bar = std::move(bar), before = lit ? 0.5 : 0](Stage stage, double fraction) {
    switch (stage) {
      case Stage::converting:
        return bar(0);
      case Stage::lighting:
        return bar(before * fraction);
      case Stage::uploading:
      case Stage::choosing:
        return bar(before);
      case Stage::marching:
        return bar(before + (1 - before) * fraction);
      case Stage::checking:
        return bar(1);
    }
  };
}

struct Session::Impl {
  explicit Impl(View given) : view(std::move(given)), unlit(view.medium) {
    if (view.medium.light) lighting.emplace(view);
  }

  View viewed(const Wish& wish) const;
  const MediumAtlas& atlas(TexelType texel, PreparationTimes& times);
  void light(Marcher& marcher, const View& wanted, LightNeed need, const StageProgress& progress,
             PreparationTimes& times);
  /// Light that misses a small part of what the light of `drawn` does.
  void finer_light(Marcher& marcher, const View& drawn, const StageProgress& progress,
                   PreparationTimes& times);
  void upload(Marcher& marcher, const Scene& scene, PreparationTimes& times);
  void prepare(Marcher& marcher, const Wish& wish, PreparationTimes& times);
  MarchPlan plan(Marcher& marcher, const View& marched, const Wish& wish, PreparationTimes& times);
  /// The regions to draw by; unset: the atlas fits. It does not change with the camera.
  std::optional<Regions> regions(const View& wanted, const Wish& wish) const;
  Drawn draw_whole(Marcher& marcher, const Wish& wish);
  Drawn draw_in(const Regions& regions, Marcher& marcher, const Wish& wish);
  Drawn draw_on(Ranks& ranks, Marcher& marcher, const Wish& wish);
  /// Keeps some bricks of the density alone, in memory, and lights these.
  void hold(const Box& bricks);
  /// After the device was too small for the whole.
  Drawn draw_in_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure);

  View view;
  const Medium unlit;                  ///< the medium without its light
  std::optional<Lighting> lighting;    ///< of a medium that a light shines on
  std::optional<double> memory_limit;  ///< found when the device was full [bytes, host and device]
  std::optional<Box> held;             ///< bricks of the density, if not all
  Ranks* together = nullptr;           ///< processes that draw this picture
  std::map<TexelType, MediumAtlas> atlases;
  std::map<std::pair<TexelType, Filter>, std::uint64_t> uploads;  ///< their numbers
};

View Session::Impl::viewed(const Wish& wish) const {
  View result = view;
  if (wish.scene) {
    result.scene = with_planes(with_default_tolerance(*wish.scene), *view.subject);
    result.camera = make_camera(result.scene, *view.subject);
  }
  if (wish.resolution) result.scene.resolution = *wish.resolution;
  if (wish.exact) result = exact_view(result);
  return result;
}

const MediumAtlas& Session::Impl::atlas(TexelType texel, PreparationTimes& times) {
  const auto found = atlases.find(texel);
  if (found != atlases.end()) return found->second;
  const Stopwatch watch;
  View converted = view;
  converted.scene.texel = texel;
  const MediumAtlas& built = atlases.emplace(texel, build_medium_atlas(converted)).first->second;
  times.atlas_ms += watch.ms();
  return built;
}

void Session::Impl::light(Marcher& marcher, const View& wanted, LightNeed need,
                          const StageProgress& progress, PreparationTimes& times) {
  if (!lighting) return;
  const MediumAtlas* dark = marcher.marches() ? &atlas(view.scene.texel, times) : nullptr;
  const Stopwatch watch;
  bool served = false;
  const auto compute = [&] {
    served = lighting->serves(wanted.camera, wanted.scene, dark, need);
    if (served) return;
    if (marcher.marches()) {
      Scene exact = view.scene;
      exact.filter = Filter::exact;
      upload(marcher, exact, times);
    } else {  // the light that is there may be half of what the memory holds
      view.medium = lighting->dark();
      lighting->forget();
    }
    lighting->compute(marcher, wanted.camera, wanted.scene, dark, need,
                      of_stage(progress, Stage::lighting));
  };
  if (together)
    together->agree(compute);
  else
    compute();
  if (served) return;
  view.medium = lighting->medium();
  View shining = view;
  for (auto& [texel, lit] : atlases) {
    shining.scene.texel = texel;
    add_luminance(lit, shining);
  }
  uploads.clear();
  times.light_ms += watch.ms();
  times.light_cpu_ms += watch.cpu_ms();
}

void Session::Impl::finer_light(Marcher& marcher, const View& drawn, const StageProgress& progress,
                                PreparationTimes& times) {
  // a quarter changes an estimate by 3 %
  if (lighting && lighting->error().rms > 0)
    light(marcher, drawn, {.rms = lighting->error().rms / 4}, progress, times);
}

void Session::Impl::upload(Marcher& marcher, const Scene& scene, PreparationTimes& times) {
  const MediumAtlas& wanted = atlas(scene.texel, times);
  std::uint64_t& number = uploads[{scene.texel, scene.filter}];
  if (number != 0 && marcher.holds == number) return;
  marcher.holds = 0;
  marcher.upload(wanted, scene.filter);
  marcher.holds = number = next_upload();
}

void Session::Impl::prepare(Marcher& marcher, const Wish& wish, PreparationTimes& times) {
  View wanted = viewed(wish);
  wanted.medium = unlit;  // keeps no light that is to be replaced
  light(marcher, wanted, light_need(marcher, wanted.scene, wish), wish.progress, times);
  if (!marcher.marches()) return;
  enter(wish.progress, Stage::uploading);
  upload(marcher, wanted.scene, times);
}

std::optional<Regions> Session::Impl::regions(const View& wanted, const Wish& wish) const {
  if (!atlases.empty()) return {};
  View given = wanted;
  given.medium = unlit;
  return needed_regions(given, wish, memory_limit);
}

/// Time of a ray [ms] by the method that is the unit of budgets, measured on a small picture.
static double unit_ms(Marcher& marcher, const View& view) {
  View small = budget_unit(view);
  small.scene.resolution = glm::max(view.scene.resolution / 4, glm::ivec2(1));
  small.scene.pixel_samples = 1;
  const RenderStats stats = marcher.render(small).stats;
  return stats.march_ms / double(stats.rays);
}

MarchPlan Session::Impl::plan(Marcher& marcher, const View& marched, const Wish& wish,
                              PreparationTimes& times) {
  enter(wish.progress, Stage::choosing);
  const Stopwatch watch;
  const MediumAtlas& grids = atlas(marched.scene.texel, times);
  const LightError missed = lighting ? lighting->error() : LightError{};
  MarchPlan result;
  if (wish.time_budget_ms) {
    const glm::dvec2 size(marched.scene.resolution);
    const double rays = size.x * size.y * marched.scene.pixel_samples;
    const double budget = *wish.time_budget_ms / (rays * unit_ms(marcher, marched));
    result = plan_within(marched, grids, budget, of_stage(wish.progress, Stage::choosing));
  } else {
    View with_rest = marched;
    if (double& rest = *with_rest.scene.tolerance; missed.rms < rest)
      rest = std::sqrt(rest * rest - missed.rms * missed.rms);
    result = plan_march(with_rest, grids, of_stage(wish.progress, Stage::choosing));
  }
  result.light_rms = missed.rms;
  result.light_max = missed.max;
  const LightError all = sum({result.chosen.rms, result.chosen.max}, missed);
  result.chosen.rms = all.rms;
  result.chosen.max = all.max;
  times.plan_ms += watch.ms();
  times.plan_cpu_ms += watch.cpu_ms();
  return result;
}

Session::Session(View view) : impl_(std::make_unique<Impl>(std::move(view))) {}
Session::Session(const Scene& scene)
    : Session([&] {
        const Scene complete = with_default_tolerance(scene);
        validate(complete);
        return make_view(complete,
                         read_fields(complete, VdbFile(scene.input), false, {.allowed = true}));
      }()) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

const View& Session::view() const { return impl_->view; }

void Session::convert() {
  PreparationTimes times;
  if (!impl_->regions(impl_->view, {})) impl_->atlas(impl_->view.scene.texel, times);
}

void Session::prepare(Marcher& marcher, const Wish& wish) {
  PreparationTimes times;
  impl_->prepare(marcher, wish, times);
}

MarchPlan Session::plan(Marcher& marcher, const Wish& wish) {
  PreparationTimes times;
  impl_->prepare(marcher, wish, times);
  return impl_->plan(marcher, impl_->viewed(wish), wish, times);
}

Drawn Session::Impl::draw_whole(Marcher& marcher, const Wish& wish) {
  PreparationTimes times;
  const bool marched = !view.scene.shows(Shows::plane);
  const bool marches = marched && marcher.marches();
  if (marched) prepare(marcher, wish, times);
  const View wanted = viewed(wish);
  std::optional<MarchPlan> chosen = wish.plan;
  const bool chooses = wanted.scene.tolerance || wish.time_budget_ms;
  if (!chosen && chooses && marches) chosen = plan(marcher, wanted, wish, times);

  Picture picture(marcher, wanted, wish, std::move(chosen));
  picture.march();
  std::optional<DrawnLight> shone;
  if (lighting) shone = lighting->description();
  if (marches) {
    picture.confirm_plan();
    if (wish.layers.error) {
      finer_light(marcher, wanted, wish.progress, times);
      Scene exact = wanted.scene;
      exact.filter = Filter::exact;
      upload(marcher, exact, times);
      picture.add_error(view.medium);
    }
  }
  Drawn drawn = picture.finish();
  drawn.light = std::move(shone);
  drawn.times = times;
  if (marches) drawn.atlas = atlas(wanted.scene.texel, times).size();
  return drawn;
}

Drawn Session::Impl::draw_in(const Regions& regions, Marcher& marcher, const Wish& wish) {
  RegionMarcher parts(marcher, regions);
  Drawn drawn = draw_whole(parts, wish);
  if (drawn.scene.tolerance) drawn.plan = exact_plan(viewed(wish));
  drawn.notices.push_back("the volume is drawn in " + std::to_string(regions.count()) +
                          " parts, so that its atlas keeps within the memory");
  return drawn;
}

Drawn Session::Impl::draw_on(Ranks& ranks, Marcher& marcher, const Wish& wish) {
  std::optional<Regions> parts, own;
  ranks.agree([&] {
    View wanted = viewed(wish);
    const std::string obstacle = rank_obstacle(wanted, wish);
    if (!obstacle.empty())
      throw Error(ExitCode::usage, "several processes draw only " + obstacle + " together");
    wanted.medium = unlit;
    const std::vector<glm::ivec3> bricks = leaf_bricks(*unlit.density);
    parts = Regions::in_parts(bricks, std::size_t(ranks.count()));
    const Region part = parts->all()[std::size_t(ranks.rank())];
    own = regions_of_part(wanted, wish, bricks, part, ranks.place().local_count);
    const glm::ivec3 ghost = region_ghost(wanted);
    if (lighting) hold({part.bricks.min - ghost, part.bricks.max + ghost});
  });
  RankMarcher rank_marcher(marcher, ranks, *parts, *own);
  if (lighting)
    lighting->share({rank_marcher.light_share(unlit.density),
                     [&](const View& seen) { return rank_marcher.exact_depths(seen); }});
  Drawn drawn = draw_whole(rank_marcher, wish);
  if (drawn.scene.tolerance) drawn.plan = exact_plan(viewed(wish));
  return drawn;
}

void Session::Impl::hold(const Box& bricks) {
  if (held == bricks) return;
  view.medium = unlit;
  const bool margin = density_options(view).with_margin;
  Field part = field_of_bricks(*unlit.density, bricks, margin);
  part.stored_range = glm::vec2(density_range(unlit));
  view.medium.density = std::make_shared<const Field>(std::move(part));
  lighting.emplace(view, bricks);
  held = bricks;
}

Drawn Session::Impl::draw_in_smaller(Marcher& marcher, const Wish& wish,
                                     const DeviceFull& failure) {
  double bytes = 0;
  for (const auto& [texel, atlas] : atlases) bytes += double(atlas.size().bytes());
  atlases.clear();
  uploads.clear();
  marcher.holds = 0;
  view.medium = unlit;
  if (lighting) lighting.emplace(view);
  for (int tries = 0; tries < 6; ++tries) {
    bytes /= 2;
    memory_limit = 2 * bytes;  // host and device
    try {
      const auto parts = regions(viewed(wish), wish);
      if (!parts) break;
      return draw_in(*parts, marcher, wish);
    } catch (const Error& error) {
      if (error.code() != ExitCode::memory && error.code() != ExitCode::graphics) throw;
    }
  }
  memory_limit.reset();
  throw failure;
}

Drawn Session::draw(Marcher& marcher, const Wish& wish) {
  impl_->together = wish.ranks.get();
  if (wish.ranks) return impl_->draw_on(*wish.ranks, marcher, wish);
  if (impl_->view.scene.shows(Shows::plane) || !marcher.marches())
    return impl_->draw_whole(marcher, wish);
  if (const auto regions = impl_->regions(impl_->viewed(wish), wish))
    return impl_->draw_in(*regions, marcher, wish);
  try {
    return impl_->draw_whole(marcher, wish);
  } catch (const DeviceFull& failure) {
    return impl_->draw_in_smaller(marcher, wish, failure);
  }
}

std::vector<Explanation> Session::explain() {
  PreparationTimes times;
  const View view = impl_->viewed({});
  const MediumAtlas& grids = impl_->atlas(view.scene.texel, times);
  if (!view.scene.tolerance) return psivox::explain(view, grids);
  if (!view.medium.light) return psivox::explain(plan_march(view, grids).march->view, grids);
  std::vector<Explanation> lines = psivox::explain(view, grids);
  lines.insert(lines.begin(),
               {"tolerance", "sampling and rule are chosen when the light is known"});
  return lines;
}

std::optional<glm::dvec3> Session::pick(const Scene& scene, const glm::dvec2& pixel) {
  PreparationTimes times;
  const View view = impl_->viewed({.scene = scene});
  return pick_point(view, impl_->atlas(view.scene.texel, times), pixel);
}

CheckedError Session::check_error(const Image& picture, int pixels, const Progress& progress) {
  View view = impl_->view;
  if (impl_->lighting) {
    PreparationTimes times;
    view.medium = impl_->lighting->exact_medium(view.camera, view.scene,
                                                impl_->atlas(view.scene.texel, times));
  }
  return check_pixels(view, picture, pixels, progress);
}

}  // namespace psivox
