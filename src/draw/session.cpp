#include "psivox/draw.h"

#include <algorithm>
#include <utility>

#include "base/stopwatch.h"
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

namespace psivox {

struct Session::Impl {
  Impl(View given, bool for_one_picture)
      : view(std::move(given)), unlit(view.medium), is_for_one(for_one_picture) {
    if (!view.scene.environment.empty())
      view.environment = std::make_shared<const Environment>(read_environment(view.scene));
    if (view.medium.light) lighting.emplace(view);
  }

  /// Forgets what was made of the fields, and reads those again whose values have gone.
  void start_over();
  /// Whether the volume is drawn whole, or its bricks are there.
  bool is_whole() const;
  /// The whole's bricks, of which nothing goes. Throws Error(memory) if they are too large.
  const MediumAtlas& whole();
  /// The whole's bricks. Values that nothing else needs go as they are made.
  const MediumAtlas& bricks();
  /// What a device stores of them: codes of these widths, the texel type's own codes, or the
  /// bricks. `last`: codes take the place of the bricks' texels.
  std::shared_ptr<const MediumAtlas> stored(TexelType texel, const CodeWidths& codes = {},
                                            bool last = false);
  /// Uploads the bricks as they are.
  void upload_bricks(Marcher& marcher);
  /// Replaces the bricks' luminance, after the light was computed. `luminance`: the view's, moved
  /// in.
  void relight(std::optional<Field> luminance = {});
  void clear_atlas();
  /// Whether fields' values may go as bricks are made of them.
  bool may_take(const Wish& wish) const {
    return is_for_one && !wish.layers.error && !wish.layers.bound;
  }
  /// Moves the values out of one of the medium's fields, which keeps all else.
  Field take(std::shared_ptr<const Field> Medium::*grid);
  /// The view that a wish asks for, with the light that is there.
  View viewed(const Wish& wish);
  /// The marcher over the parts that the volume must be drawn in.
  PartMarcher parts_of(Marcher& marcher, const View& wanted, const Wish& wish);
  /// Keeps some bricks of the density alone, in memory, and lights these.
  void hold(const Box& bricks);
  void light(PartMarcher& parts, const View& wanted, LightNeed need, const StageProgress& progress);
  /// Lets atlases go that lack bricks which a scene's method needs, or have more than it needs.
  void take_method(const Scene& scene);
  /// Lights and uploads for a view, which gets the light.
  void prepare(PartMarcher& parts, View& wanted, const Wish& wish);
  MarchPlan plan(PartMarcher& parts, const View& marched, const Wish& wish);
  Drawn draw(Marcher& marcher, const Wish& wish);
  /// On the CPU, by exact cells, whatever the scene's method.
  Drawn draw_deep(PartMarcher& parts, View wanted, const Wish& wish);
  /// Draws in parts, after the device was too small for the whole.
  Drawn draw_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure);

  View view;
  Medium unlit;                        ///< the medium without its light
  std::optional<Lighting> lighting;    ///< of a medium that a light shines on
  LightError light_error;              ///< of the light that is there
  std::optional<DrawnLight> shone;     ///< its description
  std::optional<double> memory_limit;  ///< found when the device was full [bytes, host and device]
  const bool is_for_one;               ///< the session draws one picture
  bool takes = false;                  ///< fields lose their values as bricks are made of them
  bool lacks_values = false;           ///< a field has lost its values
  bool is_fresh = false;               ///< no picture was drawn since convert()
  Box held = everywhere;               ///< bricks of the density that are kept
  NamedHoldout holdout;
  std::shared_ptr<MediumAtlas> atlas;        ///< the whole's bricks
  CodeWidths widths;                         ///< of the codes
  std::shared_ptr<const MediumAtlas> coded;  ///< made of the bricks last
  PreparationTimes times;                    ///< of this picture so far
};

void Session::Impl::start_over() {
  clear_atlas();
  if (std::exchange(lacks_values, false))
    unlit = make_view(view.scene,
                      read_fields(view.scene, VdbFile(view.scene.input), false, {.allowed = true}))
                .medium;
  view.medium = unlit;
  if (unlit.light) lighting.emplace(view);
}

Field Session::Impl::take(std::shared_ptr<const Field> Medium::*grid) {
  const std::shared_ptr<const Field> field = view.medium.*grid;
  Field values = *field;
  const auto rest = std::make_shared<const Field>(Field{FieldHead(values)});
  for (Medium* medium : {&view.medium, &unlit})
    for (auto* one : {&medium->density, &medium->luminance})
      if (*one == field) *one = rest;
  lacks_values = true;
  return values;
}

void Session::Impl::clear_atlas() {
  atlas.reset();
  coded.reset();
}

const MediumAtlas& Session::Impl::bricks() {
  if (atlas) return *atlas;
  std::optional<Field> density;
  if (takes && !unlit.light &&
      std::ranges::count(fields_of(view.medium), view.medium.density.get()) == 1)
    density = take(&Medium::density);
  const Stopwatch watch;
  atlas = std::make_shared<MediumAtlas>(build_medium_atlas(view, std::move(density)));
  times.atlas_ms += watch.ms();
  return *atlas;
}

std::shared_ptr<const MediumAtlas> Session::Impl::stored(TexelType texel, const CodeWidths& codes,
                                                         bool last) {
  bricks();
  const CodeWidths wanted = codes ? codes : fixed_widths(*atlas, texel);
  if (!wanted) return atlas;
  if (coded && *widths == *wanted) return coded;
  const Stopwatch watch;
  coded.reset();  // before the next take memory
  coded = std::make_shared<MediumAtlas>(
      psivox::coded(last ? std::move(*atlas) : *atlas, *wanted, last));
  widths = wanted;
  if (last) atlas.reset();
  times.atlas_ms += watch.ms();
  return coded;
}

void Session::Impl::upload_bricks(Marcher& marcher) {
  bricks();
  marcher.hold(atlas, Filter::exact);
}

void Session::Impl::relight(std::optional<Field> luminance) {
  coded.reset();
  if (!atlas) return;
  atlas = std::make_shared<MediumAtlas>(std::move(*atlas));  // which no marcher holds yet
  add_luminance(*atlas, view, std::move(luminance));
}

bool Session::Impl::is_whole() const {
  View dark = view;
  dark.medium = unlit;
  return atlas || coded || split_of(dark, {}, {}, memory_limit).whole;
}

const MediumAtlas& Session::Impl::whole() {
  if (!is_whole())
    throw Error(ExitCode::memory,
                "the volume must be drawn in parts; raise --memory-limit, or take --lod 1");
  return bricks();
}

View Session::Impl::viewed(const Wish& wish) {
  const bool stands = std::exchange(is_fresh, false) && may_take(wish);
  if (lacks_values && !stands) start_over();
  takes = false;
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

PartMarcher Session::Impl::parts_of(Marcher& marcher, const View& wanted, const Wish& wish) {
  const bool marches = marcher.marches() && !wanted.scene.shows(Shows::plane);
  Split split;
  if (wish.team->size() > 1 || (marches && !atlas && !coded))
    wish.team->agree([&] {
      View dark = wanted;
      dark.medium = unlit;
      const Copies copies = memory_limit ? Copies{} : copies_of(marcher, dark, may_take(wish));
      split = split_of(dark, wish, copies, memory_limit);
      if (wish.team->size() == 1 || !lighting) return;
      const Box bricks = split.parts.all()[std::size_t(wish.team->rank())].bricks;
      const glm::ivec3 ghost = region_ghost(wanted);
      hold({bricks.min - ghost, bricks.max + ghost});
    });
  return {marcher, std::move(split), *wish.team};
}

void Session::Impl::hold(const Box& bricks) {
  if (held == bricks) return;
  view.medium = unlit;
  const bool margin = density_options(view).with_margin;
  Field part = field_of_bricks(*unlit.density, bricks, margin);
  part.stored_range = glm::vec2(stored_range(*unlit.density));
  view.medium.density = std::make_shared<const Field>(std::move(part));
  lighting.emplace(view, bricks);
  held = bricks;
}

void Session::Impl::light(PartMarcher& parts, const View& wanted, LightNeed need,
                          const StageProgress& progress) {
  if (!lighting) return;
  const MediumAtlas* dark = parts.marches_whole() ? &bricks() : nullptr;
  std::optional<LightSource> source(
      {[&](const View& from) { return parts.light_depths(from); },
       [&](const View& from) { return parts.exact_depths(from, dark); }, parts.crossed(dark), dark,
       parts.light_share()});
  const Stopwatch watch;
  bool served = false;
  parts.team().agree([&] {
    served = lighting->serves(wanted, *source, need);
    if (served) return;
    if (dark) {
      upload_bricks(parts.marcher());
    } else {  // the light that is there may be half of what the memory holds
      view.medium = lighting->dark();
      lighting->forget();
    }
    lighting->compute(wanted, *source, need, of_stage(progress, Stage::lighting));
  });
  light_error = lighting->error();
  shone = lighting->description();
  if (served) return;
  view.medium = lighting->medium();
  if (takes) {
    source.reset();  // it holds the density
    lighting.reset();
    take(&Medium::density);
    relight(take(&Medium::luminance));
  } else {
    relight();
  }
  times.light_ms += watch.ms();
  times.light_cpu_ms += watch.cpu_ms();
}

void Session::Impl::take_method(const Scene& scene) {
  if (needs_every_value(scene) == needs_every_value(view.scene)) return;
  view.scene.integrator = scene.integrator;
  view.scene.sampling = scene.sampling;
  view.scene.step = scene.step;
  clear_atlas();
}

void Session::Impl::prepare(PartMarcher& parts, View& wanted, const Wish& wish) {
  take_method(wanted.scene);
  wanted.medium = {};  // keeps no light that is to be replaced, and no values that go
  light(parts, wanted, light_need(parts.marcher(), wanted.scene, wish), wish.progress);
  if (parts.marches_whole()) bricks();
  if (takes && view.medium.luminance) take(&Medium::luminance);
  wanted.medium = view.medium;
  if (!parts.marches_whole() || wish.layers.deep) return;
  if (wanted.scene.tolerance && may_be_coded(wanted)) return;  // the plan's codes will be uploaded
  enter(wish.progress, Stage::uploading);
  parts.marcher().hold(stored(wanted.scene.texel), wanted.scene.filter);
}

MarchPlan Session::Impl::plan(PartMarcher& parts, const View& marched, const Wish& wish) {
  enter(wish.progress, Stage::choosing);
  const MediumAtlas* grids = parts.whole() ? &bricks() : nullptr;
  const Stopwatch watch;
  MarchPlan result = choose_march(parts, marched, wish, grids, light_error);
  times.plan_ms += watch.ms();
  times.plan_cpu_ms += watch.cpu_ms();
  return result;
}

Drawn Session::Impl::draw(Marcher& marcher, const Wish& wish) {
  View wanted = viewed(wish);
  PartMarcher parts = parts_of(marcher, wanted, wish);
  if (wish.layers.deep) return draw_deep(parts, std::move(wanted), wish);
  const bool slice = wanted.scene.shows(Shows::plane), marches = marcher.marches() && !slice;
  takes = may_take(wish) && marches && parts.whole();
  if (!slice) prepare(parts, wanted, wish);
  std::optional<MarchPlan> chosen = wish.plan;
  // a plan for the whole may have steps of its bricks
  if (marches && wanted.scene.tolerance && !(chosen && parts.whole()))
    chosen = plan(parts, wanted, wish);

  AtlasSize size;
  if (marches && parts.whole()) {
    const auto grids =
        stored(wanted.scene.texel, chosen ? chosen->march->code_widths : nullptr, takes);
    marcher.hold(grids, wanted.scene.filter);
    size = grids->size();
  }
  Picture picture(parts, wanted, wish, std::move(chosen));
  picture.march();
  const std::optional<DrawnLight> light = shone;
  if (marches) picture.confirm_plan();
  if (marches && wish.layers.error) {
    // light four times as exact: its remaining error changes the estimate by 3 %
    if (light_error.rms > 0)
      this->light(parts, wanted, {.rms = light_error.rms / 4}, wish.progress);
    upload_bricks(marcher);
    picture.add_error(view.medium);
  }
  if (marches && wish.layers.bound) picture.add_bound(unlit);
  Drawn drawn = picture.finish();
  drawn.light = light;
  drawn.atlas = size;
  drawn.times = std::exchange(times, {});
  if (!marcher.marches() && wanted.scene.tolerance)
    drawn.notices.emplace_back("--renderer reference ignores --tolerance");
  if (wanted.scene.shows(Shows::surface) && (wanted.scene.sky || !wanted.scene.environment.empty()))
    drawn.notices.emplace_back(
        std::string(wanted.scene.sky ? "--sky does" : "--environment does") +
        " not light an isosurface" +
        (wanted.scene.given.contains("light") ? "" : "; --light X,Y,Z does"));
  if (!parts.whole() && parts.team().size() == 1)
    drawn.notices.push_back("the volume is drawn in " + std::to_string(parts.split().own.count()) +
                            (parts.split().own.count() == 1 ? " part" : " parts") +
                            ", so that its atlas keeps within the memory");
  return drawn;
}

Drawn Session::Impl::draw_deep(PartMarcher& parts, View wanted, const Wish& wish) {
  check_deep(wanted.scene, parts);
  prepare(parts, wanted, wish);
  const MediumAtlas& grids = bricks();
  Drawn drawn = deep_picture(wanted, grids, unlit.light ? light_share(wanted.scene) : 0,
                             of_stage(wish.progress, Stage::marching));
  drawn.light = shone;
  drawn.atlas = grids.size();
  drawn.times = std::exchange(times, {});
  return drawn;
}

Drawn Session::Impl::draw_smaller(Marcher& marcher, const Wish& wish, const DeviceFull& failure) {
  double bytes = double((atlas ? atlas : coded)->size().bytes());
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
  if (impl_->is_fresh) return;
  if (impl_->lacks_values) impl_->start_over();
  impl_->takes = impl_->is_for_one;
  if (impl_->is_whole()) impl_->bricks();
  impl_->is_fresh = true;
}

void Session::prepare(Marcher& marcher, const Wish& wish) {
  View wanted = impl_->viewed(wish);
  PartMarcher parts = impl_->parts_of(marcher, wanted, wish);
  impl_->prepare(parts, wanted, wish);
}

const MediumAtlas& Session::atlas(TexelType texel, const CodeWidths& codes) {
  convert();
  impl_->whole();
  return *impl_->stored(texel, codes);
}

Drawn Session::draw(Marcher& marcher, const Wish& wish) {
  try {
    return impl_->draw(marcher, wish);
  } catch (const DeviceFull& failure) {
    if (!impl_->atlas && !impl_->coded) throw;
    return impl_->draw_smaller(marcher, wish, failure);
  }
}

std::vector<Explanation> Session::explain() {
  const View view = impl_->viewed({});
  const MediumAtlas& grids = impl_->whole();
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
  return pick_point(view, impl_->whole(), pixel);
}

CheckedError Session::check_error(const Image& picture, int pixels, const StageProgress& progress) {
  View view = impl_->viewed({});
  const Stopwatch watch;
  if (impl_->lighting)
    view.medium =
        impl_->lighting->exact_medium(view, impl_->whole(), checked_rays(view, picture, pixels),
                                      of_stage(progress, Stage::lighting));
  const double light_ms = watch.ms();
  CheckedError error = check_pixels(view, picture, pixels, of_stage(progress, Stage::checking));
  error.light_ms = light_ms;
  error.reference_ms = watch.ms() - light_ms;
  return error;
}

}  // namespace psivox
