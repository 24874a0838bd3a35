#include "psivox/draw.h"

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "draw/picture.h"
#include "gl/gl_renderer.h"
#include "march/march_double.h"
#include "psivox/parameters.h"
#include "reference/reference.h"

// Opens marchers, and says what a wish may ask of a picture.

namespace psivox {

std::shared_ptr<Marcher> open_gpu(const ContextOptions& options) {
  return std::make_shared<GlRenderer>(options);
}

std::shared_ptr<Marcher> open_double() { return std::make_shared<DoubleMarcher>(); }

std::shared_ptr<Marcher> open_reference() { return std::make_shared<ReferenceMarcher>(); }

std::shared_ptr<Marcher> open_marcher(const Scene& scene) {
  switch (scene.renderer) {
    case RendererKind::reference:
      return open_reference();
    case RendererKind::march_double:
      return open_double();
    case RendererKind::gl:
      break;
  }
  return open_gpu({.device = scene.device});
}

void release(Marcher& marcher) { marcher.release(); }

std::string description(const Marcher& marcher) { return marcher.description(); }

namespace {

constexpr std::pair<const char*, bool Layers::*> layer_members[] = {
    {"depth", &Layers::depth}, {"transmittance", &Layers::transmittance},
    {"steps", &Layers::steps}, {"samples", &Layers::samples},
    {"error", &Layers::error}, {"bound", &Layers::bound},
    {"deep", &Layers::deep}};

}  // namespace

bool Layers::has(std::string_view name) const {
  return std::ranges::any_of(
      layer_members, [&](const auto& row) { return row.first == name && this->*row.second; });
}

LightNeed light_need(const Marcher& marcher, const Scene& scene, const Wish& wish) {
  if (wish.any_light) return {};
  if (wish.exact || !marcher.marches() || scene.light_quality == LightQuality::exact)
    return {.exact = true};
  if (scene.tolerance) return {.rms = light_share(scene) * *scene.tolerance};
  return {.exact = true};
}

const std::vector<std::string>& layer_names() {
  static const std::vector<std::string> names =
      names_in(layer_members, [](const auto& row) { return row.first; });
  return names;
}

Layers layers_of(const std::vector<std::string>& names) {
  Layers layers;
  for (const auto& [name, member] : layer_members)
    layers.*member = std::find(names.begin(), names.end(), name) != names.end();
  return layers;
}

std::string layer_obstacle(const std::string& layer, const Scene& scene) {
  if (layer == "depth" && info(scene.mode).from_back)
    return "--aov depth is where a ray's transmittance falls below 1/2 from the camera on, which "
           "--mode back-to-front does not follow; take --mode alpha";
  if (layer == "error" && scene.shows(Shows::plane))
    return "--mode slice does not march: it has no error to estimate";
  if (layer == "bound" && !scene.attenuates())
    return "--aov bound is of integrals; take --mode alpha, back-to-front or xray";
  if (layer == "bound" && scene.lit() && (scene.sky || !scene.environment.empty()))
    return "--aov bound cannot bound what a sky's directions miss; take --aov error, or leave out "
           "--sky and --environment";
  if (layer == "deep" && (!scene.composites() || info(scene.mode).from_back))
    return "--aov deep holds the medium in front of each depth; take --mode alpha";
  if (layer == "deep" && scene.background)
    return "--aov deep holds the medium alone; leave out --background";
  const bool reference = scene.renderer == RendererKind::reference;
  if (reference && layer != "transmittance" && layer != "error")
    return "--aov " + layer + " is not available with --renderer " +
           parameter_text(scene, "renderer");
  return {};
}

const char* stage_text(Stage stage) {
  switch (stage) {
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

Progress of_stage(const StageProgress& progress, Stage stage) {
  if (!progress) return {};
  return [&progress, stage](double fraction) { progress(stage, fraction); };
}

void enter(const StageProgress& progress, Stage stage) {
  if (progress) progress(stage, 0);
}

StageProgress over_stages(Progress bar) {
  if (!bar) return {};
  return [bar = std::move(bar), before = 0.0](Stage stage, double fraction) mutable {
    if (stage == Stage::checking) return bar(1);
    if (stage == Stage::lighting) before = 0.5;
    bar(stage == Stage::lighting   ? before * fraction
        : stage == Stage::marching ? before + (1 - before) * fraction
                                   : before);
  };
}

}  // namespace psivox
