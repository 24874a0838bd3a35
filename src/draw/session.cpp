#include "psivox/draw.h"

#include <algorithm>
#include <utility>

#include "base/stopwatch.h"
#include "draw/kept.h"
#include "draw/part_marcher.h"
#include "draw/picture.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "image/scene_pictures.h"
#include "march/grids.h"
#include "march/march_parameters.h"
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
  Impl(View given, bool for_one_picture)
      : view(std::move(given)), dark(view.medium), is_for_one(for_one_picture) {
    if (!view.scene.environment.empty())
      view.environment = std::make_shared<const Environment>(read_environment(view.scene));
  }

  View in_dark(View of) const {
    of.medium = dark;
    return of;
  }

  // --- the stages
  /// The view that a wish asks for, with the light that is there. `stands`: what is kept is enough
  /// to draw it, without the values that were taken.
  View viewed(const Wish& wish, bool stands = false);
  /// The marcher over the parts that the volume must be drawn in.
  PartMarcher split(Marcher& marcher, const View& wanted, const Wish& wish);
  /// The whole's bricks without light, for a scene's method.
  std::shared_ptr<MediumAtlas> bricks(const Scene& scene);
  /// Gives a view its medium, in light that meets the need. Makes the bricks of a whole.
  void light(PartMarcher& parts, View& wanted, LightNeed need, const StageProgress& progress);
  Lighting& light_of_dark() {
    if (!lighting) lighting.emplace(in_dark(view));
    return *lighting;
  }
  /// The whole's bricks with their light.
  std::shared_ptr<MediumAtlas> lit_bricks(const Scene& scene);
  MarchPlan plan(PartMarcher& parts, const View& lit, const Wish& wish);
  /// What a device stores of the whole: codes of these widths, codes of the scene's texel type, or
  /// the bricks.
  std::shared_ptr<const MediumAtlas> stored(const Scene& scene, const CodeWidths& codes = {});
  /// All stages.
  Drawn draw(Marcher& marcher, const Wish& wish);

  // --- memory
  /// Whether stages may take the memory of what they are made from.
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
  /// Keeps some bricks of the density alone, in memory, and lights these.
  void keep_alone(const Box& bricks);
  /// Bricks or codes of the whole; null: there are none.
  const MediumAtlas* kept() const;
  /// Whether the volume is drawn whole.
  bool is_whole() const;
  /// The bricks for a scene's method, all of whose values stay. Throws Error(memory) if they are
  /// too large.
  const MediumAtlas& whole(const Scene& scene);
  /// Draws in parts, after the device was too small for the whole.
  Drawn draw_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure);

  View view;    ///< with its light, once that is computed
  Medium dark;  ///< the view's without its light
  NamedHoldout holdout;
  Box held = everywhere;  ///< bricks of the density that are kept
  Kept<bool, MediumAtlas> dark_bricks;
  std::optional<Lighting> lighting;      ///< of a medium that a light shines on
  LightError light_error;                ///< of the light that is there
  std::optional<DrawnLight> light_text;  ///< its description
  int lights = 0;                        ///< that were computed
  Kept<std::pair<bool, int>, MediumAtlas> lit;
  Kept<std::vector<CodeWidth>, MediumAtlas> codes;  ///< of the bricks made last
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
      const View unlit = in_dark(wanted);
      const Copies copies = memory_limit ? Copies{} : copies_of(marcher, unlit, may_take(wish));
      split = split_of(unlit, wish, copies, memory_limit);
      if (wish.team->size() == 1 || !dark.light) return;
      const Box own = split.parts.all()[std::size_t(wish.team->rank())].bricks;
      const glm::ivec3 ghost = region_ghost(unlit);
      keep_alone({own.min - ghost, own.max + ghost});
    });
  takes = may_take(wish) && marches && split.whole;
  return {marcher, std::move(split), *wish.team};
}

std::shared_ptr<MediumAtlas> Session::Impl::bricks(const Scene& scene) {
  return dark_bricks.of(needs_every_value(scene), [&] {
    need_values();
    codes.forget();
    const Stopwatch watch;
    std::optional<Field> density;
    if (!dark.light && std::ranges::count(fields_of(dark), dark.density.get()) == 1)
      density = taken(&Medium::density);
    View unlit = in_dark(view);
    unlit.scene = scene;
    MediumAtlas made = build_medium_atlas(unlit, std::move(density));
    times.atlas_ms += watch.ms();
    return made;
  });
}

void Session::Impl::light(PartMarcher& parts, View& wanted, LightNeed need,
                          const StageProgress& progress) {
  wanted.medium = {};  // keeps no light that is to be replaced, and no values that are taken
  const auto whole = parts.marches_whole() ? bricks(wanted.scene) : nullptr;
  if (dark.light) {
    const Stopwatch watch;
    bool serves = false;
    parts.team().agree([&] {
      const LightSource source = parts.light_source(whole.get());
      serves = light_of_dark().serves(wanted, source, need);
      if (serves) return;
      if (whole) {
        parts.marcher().hold(whole, Filter::exact);
      } else {  // the light that is there may be half of what the memory holds
        view.medium = lighting->dark();
        lighting->forget();
      }
      lighting->compute(wanted, source, need, of_stage(progress, Stage::lighting));
    });
    light_error = lighting->error();
    light_text = lighting->description();
    if (!serves) {
      view.medium = lighting->medium();
      codes.forget();
      ++lights;
      if (takes) lighting.reset();
    }
    if (whole) lit_bricks(wanted.scene);
    if (!serves) {
      times.light_ms += watch.ms();
      times.light_cpu_ms += watch.cpu_ms();
    }
  }
  taken(&Medium::luminance);
  wanted.medium = view.medium;
}

std::shared_ptr<MediumAtlas> Session::Impl::lit_bricks(const Scene& scene) {
  if (lights == 0) return bricks(scene);
  return lit.of({needs_every_value(scene), lights}, [&] {
    const auto unlit = bricks(scene);
    if (takes) dark_bricks.forget();
    taken(&Medium::density);
    MediumAtlas made = takes ? std::move(*unlit) : *unlit;
    add_luminance(made, view, taken(&Medium::luminance));
    return made;
  });
}

MarchPlan Session::Impl::plan(PartMarcher& parts, const View& marched, const Wish& wish) {
  enter(wish.progress, Stage::choosing);
  const auto grids = parts.whole() ? lit_bricks(marched.scene) : nullptr;
  const Stopwatch watch;
  MarchPlan result = choose_march(parts, marched, wish, grids.get(), light_error);
  times.plan_ms += watch.ms();
  times.plan_cpu_ms += watch.cpu_ms();
  return result;
}

std::shared_ptr<const MediumAtlas> Session::Impl::stored(const Scene& scene,
                                                         const CodeWidths& planned) {
  const CodeWidths widths = planned ? planned : fixed_widths(*lit_bricks(scene), scene.texel);
  if (!widths) return lit_bricks(scene);
  return codes.of(*widths, [&] {
    const auto grids = lit_bricks(scene);
    if (takes) dark_bricks.forget(), lit.forget();
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
  const bool marches = marcher.marches() && !slice, whole = marches && parts.whole();
  if (deep) check_deep(wanted.scene, parts);
  if (!slice) light(parts, wanted, light_need(marcher, wanted.scene, wish), wish.progress);

  std::optional<MarchPlan> chosen = wish.plan;
  // a plan for the whole may have steps of its bricks
  if (marches && !deep && wanted.scene.tolerance && !(chosen && parts.whole()))
    chosen = plan(parts, wanted, wish);
  std::shared_ptr<const MediumAtlas> grids;
  if (whole && !deep) enter(wish.progress, Stage::uploading);
  if (whole)
    grids = deep ? lit_bricks(wanted.scene)
                 : stored(wanted.scene, chosen ? chosen->march->code_widths : nullptr);

  Picture picture(parts, wanted, wish, std::move(chosen));
  picture.march(grids);
  Drawn& drawn = picture.drawn();
  if (!slice) drawn.light = light_text;
  if (grids) drawn.atlas = grids->size();
  if (marches && !deep) {
    picture.confirm_plan();
    if (wish.layers.error) {
      // light four times as exact: its remaining error changes the estimate by 3 %
      View better = wanted;
      if (light_error.rms > 0) light(parts, better, {.rms = light_error.rms / 4}, wish.progress);
      marcher.hold(lit_bricks(wanted.scene), Filter::exact);
      picture.add_error(better.medium);
    }
    if (wish.layers.bound) picture.add_bound(dark);
  }
  picture.finish();
  drawn.times = std::exchange(times, {});
  return std::move(drawn);
}

std::optional<Field> Session::Impl::taken(std::shared_ptr<const Field> Medium::*grid) {
  const std::shared_ptr<const Field> field = view.medium.*grid;
  if (!takes || !field) return {};
  Field values = *field;
  const auto rest = std::make_shared<const Field>(Field{FieldHead(values)});
  for (Medium* medium : {&view.medium, &dark})
    for (auto* one : {&medium->density, &medium->luminance})
      if (*one == field) *one = rest;
  lacks_values = true;
  return values;
}

bool Session::Impl::stands(const Marcher& marcher, const Wish& wish) const {
  return may_take(wish) && marcher.marches() && !view.scene.shows(Shows::plane) &&
         (dark_bricks.get() || lit.get()) && (!dark.light || lighting);
}

void Session::Impl::start_over() {
  dark_bricks.forget();
  lit.forget();
  codes.forget();
  lighting.reset();
  lights = 0;
  held = everywhere;
  if (std::exchange(lacks_values, false))
    dark = make_view(view.scene,
                     read_fields(view.scene, VdbFile(view.scene.input), false, {.allowed = true}))
               .medium;
  view.medium = dark;
}

void Session::Impl::keep_alone(const Box& bricks) {
  if (held == bricks) return;
  view.medium = dark;
  const bool margin = density_options(view).with_margin;
  Field part = field_of_bricks(*dark.density, bricks, margin);
  part.stored_range = glm::vec2(stored_range(*dark.density));
  view.medium.density = std::make_shared<const Field>(std::move(part));
  lighting.emplace(view, bricks);
  held = bricks;
}

const MediumAtlas* Session::Impl::kept() const {
  for (const MediumAtlas* atlas : {lit.get().get(), dark_bricks.get().get(), codes.get().get()})
    if (atlas) return atlas;
  return nullptr;
}

bool Session::Impl::is_whole() const {
  return kept() || split_of(in_dark(view), {}, {}, memory_limit).whole;
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
                         read_fields(complete, VdbFile(scene.input), false, {.allowed = true}));
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
  const View view = impl_->viewed({.scene = scene});
  return pick_point(view, impl_->whole(view.scene), pixel);
}

CheckedError Session::check_error(const Image& picture, int pixels, const StageProgress& progress) {
  View view = impl_->viewed({});
  const Stopwatch watch;
  if (impl_->dark.light)
    view.medium = impl_->light_of_dark().exact_medium(view, impl_->whole(view.scene),
                                                      checked_rays(view, picture, pixels),
                                                      of_stage(progress, Stage::lighting));
  const double light_ms = watch.ms();
  CheckedError error = check_pixels(view, picture, pixels, of_stage(progress, Stage::checking));
  error.light_ms = light_ms;
  error.reference_ms = watch.ms() - light_ms;
  return error;
}

}  // namespace psivox
