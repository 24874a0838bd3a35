#include "psivox/draw.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stopwatch.h"
#include "draw/kept.h"
#include "draw/part_marcher.h"
#include "draw/picture.h"
#include "field/leaf_values.h"
#include "image/scene_pictures.h"
#include "march/grids.h"
#include "march/march_parameters.h"
#include "plan/budget.h"
#include "psivox/parameters.h"
#include "psivox/vdb.h"
#include "scene/cuts.h"
#include "scene/environment.h"

// A picture's stages, in their order. Each is a function of what it depends on, and a session keeps
// what the next picture can use:
//
//   stage       depends on                                  kept
//   view        the scene that is wished for                -
//   split       the view, the memory, the team              -
//   bricks      the fields, the values that the rule needs  by these
//   light       the bricks, the camera, the largest error   as long as it serves
//   lit bricks  the bricks, the light                       by both
//   plan        the view, the lit bricks, the tolerance     by the caller, as Wish::plan
//   codes       the lit bricks, the plan's widths           by these
//   march       the view, the plan, the codes               -
//   check       the picture, the view, the plan, the light  -

namespace psivox {

struct Session::Impl {
  /// A colour bar lists the labels that the density has.
  Impl(View given, bool for_one_picture)
      : view(std::move(given)),
        is_for_one(for_one_picture &&
                   !(view.scene.color_bar && view.scene.colormap == Colormap::labels)) {
    if (!view.scene.environment.empty())
      view.environment = std::make_shared<const Environment>(read_environment(view.scene));
  }

  // --- the stages
  /// The view that a wish asks for, without light. `stands`: what is kept is enough to draw it,
  /// without the values that were taken.
  View viewed(const Wish& wish, bool stands = false);
  /// The marcher over the parts that the volume must be drawn in.
  PartMarcher split(Marcher& marcher, const View& wanted, const Wish& wish);
  /// The whole's bricks without light, for a scene's method.
  std::shared_ptr<MediumAtlas> bricks(const Scene& scene);
  /// Gives a view the medium in light that meets the need. Makes the bricks of a whole.
  void light(PartMarcher& parts, View& wanted, LightNeed need, const StageProgress& progress);
  /// The medium with the light that is there.
  Medium& medium() { return lighting.medium() ? *lighting.medium() : view.medium; }
  /// The density in some bricks alone, in memory.
  std::shared_ptr<const Field> part(const Box& bricks);
  /// The whole's bricks with their light.
  std::shared_ptr<MediumAtlas> lit_bricks(const Scene& scene);
  /// The march of a view within its tolerance.
  MarchPlan plan(PartMarcher& parts, View marched, const Wish& wish);
  /// What a device stores of the whole: codes of these widths, codes of the scene's texel type, or
  /// the bricks.
  std::shared_ptr<const MediumAtlas> stored(const Scene& scene, const CodeWidths& codes = {});
  /// All stages.
  Drawn draw(Marcher& marcher, const Wish& wish);

  // --- memory
  /// Whether stages may take the memory of what they are made of, so that it goes.
  bool may_take(const Wish& wish) const {
    const Layers& layers = wish.layers;
    return is_for_one && !layers.error && !layers.bound && !layers.deep;
  }
  /// Moves the values out of one of the medium's fields, which keeps all else; unset if they stay.
  std::optional<Field> taken(std::shared_ptr<const Field> Medium::*grid);
  /// Whether the bricks that are kept serve a draw without the values that they were made from.
  bool stands(const Marcher& marcher, const Wish& wish) const;
  /// Reads the fields again whose values were taken.
  void need_values() {
    if (lacks_values) start_over();
  }
  /// Forgets what all stages have made.
  void start_over();
  /// Bricks or codes of the whole; null: there are none.
  const MediumAtlas* kept() const;
  /// Whether the volume is drawn whole.
  bool is_whole() const;
  /// The bricks for a scene's method, all of whose values stay. Throws Error(memory) if they are
  /// too large.
  const MediumAtlas& whole(const Scene& scene);
  /// Draws in parts, after the device was too small for the whole.
  Drawn draw_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure);

  View view;  ///< without light
  NamedHoldout holdout;
  Kept<bool, MediumAtlas> kept_bricks;  ///< by whether they are of every value
  Kept<Box, Field> kept_part;           ///< the density in a member's own bricks
  Lighting lighting;
  Kept<bool, MediumAtlas> kept_lit;                      ///< the bricks in the light that is there
  Kept<std::vector<CodeWidth>, MediumAtlas> kept_codes;  ///< of the bricks made last
  std::optional<double> memory_limit;  ///< found when the device was full [bytes, host and device]
  const bool is_for_one;               ///< the session draws one picture
  bool takes = false;                  ///< stages take the memory of what they are made from
  bool lacks_values = false;           ///< a field has lost its values
  PreparationTimes times;              ///< of this picture so far
};

View Session::Impl::viewed(const Wish& wish, bool stands) {
  if (!stands) need_values();
  View result = view;
  if (wish.scene) {
    result.scene = with_planes(with_default_tolerance(*wish.scene), *view.subject);
    result.camera = make_camera(result.scene, *view.subject);
  }
  if (!result.scene.holdout.empty()) result.holdout = holdout.of(result.scene);
  if (wish.resolution) result.scene.resolution = *wish.resolution;
  if (wish.exact) result = exact_view(result);
  check_sampling(result);
  return result;
}

PartMarcher Session::Impl::split(Marcher& marcher, const View& wanted, const Wish& wish) {
  const bool marches = marcher.marches() && !wanted.scene.shows(Shows::plane);
  Split split;
  if (wish.team->size() > 1 || (marches && !kept()))
    wish.team->agree([&] {
      const Copies copies = memory_limit ? Copies{} : copies_of(marcher, wanted, may_take(wish));
      split = split_of(wanted, wish, copies, memory_limit);
    });
  takes = may_take(wish) && marches && split.whole;
  return {marcher, std::move(split), *wish.team};
}

std::shared_ptr<MediumAtlas> Session::Impl::bricks(const Scene& scene) {
  return kept_bricks.of(needs_every_value(scene), [&] {
    need_values();
    kept_codes.forget();
    const Stopwatch watch;
    const auto& medium = view.medium;
    std::optional<Field> density;
    if (!medium.light && std::ranges::count(fields_of(medium), medium.density.get()) == 1)
      density = taken(&Medium::density);
    View by_scene = view;
    by_scene.scene = scene;
    MediumAtlas made = build_medium_atlas(by_scene, std::move(density));
    times.atlas_ms += watch.ms();
    return made;
  });
}

void Session::Impl::light(PartMarcher& parts, View& wanted, LightNeed need,
                          const StageProgress& progress) {
  wanted.medium = {};  // keeps no light that is to be replaced, and no values that are taken
  const auto whole = parts.marches_whole() ? bricks(wanted.scene) : nullptr;
  if (view.medium.light) {
    const Stopwatch watch;
    bool serves = false;
    parts.team().agree([&] {
      View dark = view;
      dark.camera = wanted.camera;
      dark.scene.resolution = wanted.scene.resolution;
      const Box& box = parts.split().lit;
      if (box != everywhere) dark.medium.density = part(box);
      const LightSource source = parts.light_source(whole.get());
      serves = lighting.serves(dark, source, need);
      if (serves) return;
      kept_lit.forget();
      kept_codes.forget();
      if (whole)
        parts.marcher().hold(whole, Filter::exact);
      else
        lighting.forget();  // it may be half of what the memory holds
      lighting.compute(dark, box, source, need, of_stage(progress, Stage::lighting));
    });
    if (whole) lit_bricks(wanted.scene);
    if (!serves) {
      times.light_ms += watch.ms();
      times.light_cpu_ms += watch.cpu_ms();
    }
  }
  taken(&Medium::luminance);
  wanted.medium = medium();
}

std::shared_ptr<const Field> Session::Impl::part(const Box& bricks) {
  return kept_part.of(bricks, [&] {
    lighting.forget();
    return field_of_bricks(*view.medium.density, bricks, density_options(view).with_margin);
  });
}

std::shared_ptr<MediumAtlas> Session::Impl::lit_bricks(const Scene& scene) {
  if (!lighting.medium()) return bricks(scene);
  return kept_lit.of(needs_every_value(scene), [&] {
    const auto unlit = bricks(scene);
    if (takes) kept_bricks.forget();
    taken(&Medium::density);
    std::optional<Field> luminance = taken(&Medium::luminance);
    View lit = view;
    lit.medium = medium();
    MediumAtlas made = takes ? std::move(*unlit) : *unlit;
    add_luminance(made, lit, std::move(luminance));
    return made;
  });
}

MarchPlan Session::Impl::plan(PartMarcher& parts, View marched, const Wish& wish) {
  const auto grids = parts.whole() ? lit_bricks(marched.scene) : nullptr;
  enter(wish.progress, Stage::choosing);
  const Progress progress = of_stage(wish.progress, Stage::choosing);
  const LightError missed = lighting.error();
  const Stopwatch watch;
  MarchPlan result;
  if (grids) {
    double& rest = *marched.scene.tolerance;  // light has its share
    rest = budget::beside(missed.rms, rest);
    result = plan_march(marched, *grids, progress);
    if (may_be_coded(marched)) choose_codes(result, *grids, rest, wish.fewest_bytes, progress);
  } else {  // each member has the light of its own part
    marched.medium.brightest = std::ranges::max(parts.team().gather(marched.medium.brightest));
    result = exact_plan(marched);
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

std::shared_ptr<const MediumAtlas> Session::Impl::stored(const Scene& scene,
                                                         const CodeWidths& planned) {
  const auto grids = lit_bricks(scene);
  const CodeWidths widths = planned ? planned : fixed_widths(*grids, scene.texel);
  if (!widths) return grids;
  return kept_codes.of(*widths, [&] {
    if (takes) kept_bricks.forget(), kept_lit.forget();
    const Stopwatch watch;
    MediumAtlas made = coded(takes ? std::move(*grids) : *grids, *widths, takes);
    times.atlas_ms += watch.ms();
    return made;
  });
}

Drawn Session::Impl::draw(Marcher& marcher, const Wish& wish) {
  View wanted = viewed(wish, stands(marcher, wish));
  PartMarcher parts = split(marcher, wanted, wish);
  const bool slice = wanted.scene.shows(Shows::plane), deep = wish.layers.deep;
  const bool marches = marcher.marches() && !slice && !deep;
  if (deep) check_deep(wanted.scene, parts);
  if (!slice) light(parts, wanted, light_need(marcher, wanted.scene, wish), wish.progress);

  std::optional<MarchPlan> chosen;
  if (!deep) chosen = wish.plan;
  // a plan for the whole may have steps of its bricks
  if (marches && wanted.scene.tolerance && !(chosen && parts.whole()))
    chosen = plan(parts, wanted, wish);
  std::shared_ptr<const MediumAtlas> grids;
  if (deep) grids = lit_bricks(wanted.scene);
  if (marches && parts.whole()) {
    enter(wish.progress, Stage::uploading);
    grids = stored(wanted.scene, chosen ? chosen->march->code_widths : nullptr);
  }

  Picture picture(parts, wanted, wish, std::move(chosen));
  picture.march(grids);
  Drawn& drawn = picture.drawn();
  if (wanted.medium.lit) drawn.light = lighting.description();
  if (grids) drawn.atlas = grids->size();
  if (marches) {
    picture.confirm_plan();
    if (wish.layers.error) {
      View better = wanted;
      if (const double rms = budget::better_light * lighting.error().rms; rms > 0)
        light(parts, better, {.rms = rms}, wish.progress);
      marcher.hold(lit_bricks(wanted.scene), Filter::exact);
      picture.add_error(better.medium);
    }
    if (wish.layers.bound) picture.add_bound(view.medium);
  }
  picture.finish();
  drawn.times = std::exchange(times, {});
  return std::move(drawn);
}

std::optional<Field> Session::Impl::taken(std::shared_ptr<const Field> Medium::*grid) {
  const std::shared_ptr<const Field> field = medium().*grid;
  if (!takes || !field) return {};
  Field values = *field;
  const auto rest = std::make_shared<const Field>(Field{FieldHead(values)});
  for (Medium* one : {&view.medium, &medium()})
    for (auto* place : {&one->density, &one->luminance})
      if (*place == field) *place = rest;
  lacks_values = true;
  return values;
}

bool Session::Impl::stands(const Marcher& marcher, const Wish& wish) const {
  return may_take(wish) && marcher.marches() && !view.scene.shows(Shows::plane) &&
         (kept_bricks.get() || kept_lit.get()) && !(view.medium.light && lacks_values);
}

void Session::Impl::start_over() {
  kept_bricks.forget();
  kept_lit.forget();
  kept_codes.forget();
  kept_part.forget();
  lighting.forget();
  if (std::exchange(lacks_values, false))
    view.medium = make_view(view.scene, read_fields(view.scene, VolumeFile(view.scene.input), false,
                                                    {.allowed = true}))
                      .medium;
}

const MediumAtlas* Session::Impl::kept() const {
  for (const MediumAtlas* atlas :
       {kept_lit.get().get(), kept_bricks.get().get(), kept_codes.get().get()})
    if (atlas) return atlas;
  return nullptr;
}

bool Session::Impl::is_whole() const {
  return kept() || split_of(view, {}, {}, memory_limit).whole;
}

const MediumAtlas& Session::Impl::whole(const Scene& scene) {
  if (!is_whole())
    throw Error(ExitCode::memory,
                "the volume must be drawn in parts; raise --memory-limit, or take --lod 1");
  takes = false;
  return *lit_bricks(scene);
}

Drawn Session::Impl::draw_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure) {
  double bytes = double(kept()->size().bytes());
  for (int tries = 0; tries < 6; ++tries) {
    start_over();
    bytes /= 2;
    memory_limit = 2 * bytes;  // host and device
    try {
      return draw(marcher, wish);
    } catch (const Error& error) {
      if (error.code() != ExitCode::memory && error.code() != ExitCode::graphics) throw;
    }
  }
  memory_limit.reset();
  throw failure;
}

Session::Session(View view, bool for_one_picture)
    : impl_(std::make_unique<Impl>(std::move(view), for_one_picture)) {}
Session::Session(const Scene& scene)
    : Session([&] {
        const Scene complete = with_default_tolerance(scene);
        validate(complete);
        return make_view(complete,
                         read_fields(complete, VolumeFile(scene.input), false, {.allowed = true}));
      }()) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

const View& Session::view() const { return impl_->view; }

void Session::convert() {
  if (impl_->kept()) return;
  impl_->need_values();
  impl_->takes = impl_->is_for_one;
  if (impl_->is_whole()) impl_->bricks(impl_->view.scene);
}

void Session::prepare(Marcher& marcher, const Wish& wish) {
  View wanted = impl_->viewed(wish);
  PartMarcher parts = impl_->split(marcher, wanted, wish);
  impl_->light(parts, wanted, light_need(marcher, wanted.scene, wish), wish.progress);
  if (!parts.marches_whole() || (wanted.scene.tolerance && may_be_coded(wanted))) return;
  enter(wish.progress, Stage::uploading);
  marcher.hold(impl_->stored(wanted.scene), wanted.scene.filter);
}

const MediumAtlas& Session::atlas(const Scene& scene, const CodeWidths& codes) {
  impl_->whole(scene);
  return *impl_->stored(scene, codes);
}

Drawn Session::draw(Marcher& marcher, const Wish& wish) {
  try {
    return impl_->draw(marcher, wish);
  } catch (const DeviceFull& failure) {
    if (!impl_->kept()) throw;
    return impl_->draw_smaller(marcher, wish, failure);
  }
}

std::vector<Explanation> Session::explain() {
  const View view = impl_->viewed({});
  const MediumAtlas& grids = impl_->whole(view.scene);
  if (!view.scene.tolerance) return psivox::explain(view, grids);
  if (!view.medium.light) return psivox::explain(plan_march(view, grids).march->view, grids);
  std::vector<Explanation> lines = psivox::explain(view, grids);
  for (Explanation& line : lines)
    if (line.what == "sampling" || line.what == "integrator")
      line.text = "chosen for the tolerance, once the light is known";
  return lines;
}

std::optional<glm::dvec3> Session::pick(const Scene& scene, const glm::dvec2& pixel) {
  View view = impl_->viewed({.scene = scene});
  view.medium = impl_->medium();
  return pick_point(view, impl_->whole(view.scene), pixel);
}

CheckedError Session::check_error(const Drawn& drawn, int pixels, const StageProgress& progress) {
  impl_->need_values();
  View view = drawn.view;
  view.medium = impl_->view.medium;
  const Stopwatch watch;
  if (view.medium.light)
    view.medium = impl_->lighting.exact_medium(view, impl_->whole(impl_->view.scene),
                                               checked_rays(view, drawn.image, pixels),
                                               of_stage(progress, Stage::lighting));
  const double light_ms = watch.ms();
  CheckedError error = check_pixels(view, drawn.image, pixels, of_stage(progress, Stage::checking));
  error.light_ms = light_ms;
  error.reference_ms = watch.ms() - light_ms;
  return error;
}

}  // namespace psivox
