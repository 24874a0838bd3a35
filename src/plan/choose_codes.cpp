#include "plan/plan.h"

#include <algorithm>
#include <cmath>

#include "atlas/brick_code.h"
#include "field/index_space.h"
#include "plan/brick_effects.h"
#include "plan/budget.h"

namespace psivox {
namespace {

/// Each further trial's steps are narrower by what the trial before missed, within these factors,
/// and reach this part of what may be missed.
constexpr double narrower = 1.0 / 4, narrowest = 1.0 / 32, aimed = 0.8;
constexpr int most_trials = 3;

/// Codes are dropped if they take more than this part of the float32 texels' bytes. Beside light,
/// codes slow the march, so there they must save more bytes.
constexpr double worthwhile = 0.75, worthwhile_in_light = 0.55;

/// Look-ups of a picture for each texel from which on codes are chosen. To choose them takes about
/// as long as they save in the upload; what they save in the march comes on top. Processor time of
/// the whole process by that of float32: 1.05 at 0.01 look-ups a texel, 0.98 at 0.1, 0.9 at 0.2.
constexpr double paying_look_ups = 0.1;

/// Part of the memory that grids may take from which on it is scarce.
constexpr double scarce = 0.25;

/// By slot: how much one voxel changes the picture if the brick's values change by 1.
std::vector<double> effects_of_values(const PlannedMarch& planned, const MediumAtlas& atlas) {
  const Medium& medium = planned.view.medium;
  const double scale = medium.extinction * finest_voxel(*medium.density);
  double brightness = greatest_of(medium.color);
  if (medium.lit_colors) brightness *= greatest_of(*atlas.luminance);
  const FunctionBends bends(medium.transfer.get());
  std::vector<double> effects;
  for (std::size_t i = 0; i < planned.through.size(); ++i) {
    const BrickStats& brick = atlas.density.bricks[i];
    const FunctionBend bend = bends.between(double(brick.min), double(brick.max));
    double light = 0;
    if (medium.source == LuminanceSource::density) light = brightness;
    if (medium.source == LuminanceSource::transfer || medium.lit_colors)
      light = brightness * bend.color_slope;
    effects.push_back(scale * bend.slope * planned.through[i] +
                      std::min(1.0, scale * bend.most) * light);
  }
  return effects;
}

/// Whether the picture's march pays for the choice of codes, or the host's and the device's copies
/// of float32 take much of the memory.
bool are_worthwhile(const MarchPlan& plan, const Scene& scene, double bytes) {
  const glm::dvec2 size(scene.resolution);
  const double look_ups = size.x * size.y * scene.pixel_samples * plan.chosen.samples;
  return look_ups >= paying_look_ups * bytes / sizeof(float) ||
         2 * bytes >= scarce * double(grid_memory(scene));
}

}  // namespace

bool may_be_coded(const View& view) {
  return view.scene.texel == TexelType::automatic && view.scene.filter == Filter::exact &&
         view.scene.attenuates() && !view.medium.gradient;
}

void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance, bool fewest_bytes,
                  const Progress& progress) {
  const MethodView& method = *plan.march;
  const BrickAtlas* beside = atlas.paired ? &*atlas.luminance : nullptr;
  const auto bytes =
      double(atlas.density.size.texel_bytes + (beside ? beside->size.texel_bytes : 0));
  if (!plan.reached || plan.rays == 0) return;
  if (!fewest_bytes && !are_worthwhile(plan, method.view.scene, bytes)) return;
  const std::vector<double> effects = effects_of_values(*plan.march, atlas);
  double brightness = greatest_of(method.view.medium.color);
  if (method.view.medium.lit_colors) brightness *= greatest_of(*method.view.medium.transfer);
  brightness = std::max(brightness, 1e-30);
  const double most = bytes * (beside && !fewest_bytes ? worthwhile_in_light : worthwhile);
  const budget::Limits limits = budget::coded(tolerance);
  const budget::Limits of_codes{budget::beside(plan.chosen.rms, limits.rms), limits.max};
  double share = tolerance;
  for (int trial = 0; trial < most_trials; ++trial) {
    std::vector<float> steps;
    for (const double effect : effects)
      steps.push_back(float(std::min(budget::code_depth * share / effect, 1e30)));
    const CodeWidths widths =
        code_widths(atlas.density, steps, beside, float(budget::code_light * share / brightness));
    if (!widths || double(coded_bytes(*widths, beside)) > most) return;
    const BrickCodes codes = brick_codes(atlas.density, *widths, beside);
    const RayErrors missed = plan.march->pilot->march(
        method, atlas, progress, [&](const RayErrors& errors) { return errors.max <= limits.max; },
        &codes);
    if (limits.keeps(missed.rms(), missed.max)) {
      PlannedMarch march = *plan.march;
      march.code_widths = widths;
      plan.march = std::make_shared<PlannedMarch>(std::move(march));
      plan.chosen.rms = missed.rms();
      plan.chosen.max = missed.max;
      return;
    }
    // errors grow as the steps do
    const double excess =
        of_codes.excess(budget::beside(plan.chosen.rms, missed.rms()), missed.max);
    share *= std::clamp(aimed / excess, narrowest, narrower);
  }
}

}  // namespace psivox
