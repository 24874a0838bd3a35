#include "plan/plan.h"

#include <algorithm>
#include <cmath>

#include "atlas/brick_code.h"
#include "field/index_space.h"
#include "plan/brick_effects.h"

namespace psivox {
namespace {

/// In the first trial, a step of code changes a voxel's optical depth times the light there by at
/// most `depth_step` tolerances, and light by at most `light_step`. Errors of a ray's voxels are
/// independent where values vary by more than a step. Inside a smooth cloud they do not, and a row
/// of a brick is off by up to four steps. One pixel in a thousand is to be off by 5 tolerances at
/// most: in 80 pictures it was off by 4.5 at 8, and by 5.6 at 9.7. At 6.8 the error of smoke at
/// 1e-3 jumps by 0.18 tolerances at brick borders in the mean, at 8 by 0.22, where all borders that
/// rays cross are in line.
constexpr double depth_step = 6.8, light_step = 10.2;

/// Each further trial's steps are narrower by what the trial before missed, within these factors,
/// and reach this part of what may be missed.
constexpr double narrower = 1.0 / 4, narrowest = 1.0 / 32, aimed = 0.8;
constexpr int most_trials = 3;

/// What the pilot's rays may show with codes [tolerances]: a method may take nearly all that any
/// may (pilot_safety, worst_ray), and codes a little more.
constexpr double coded_rms = 0.85, coded_ray = 4.5;

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

/// How much narrower the next trial's steps are: errors grow as the steps do, and those of the
/// method and of codes add up as squares.
double next_step(const RayErrors& missed, double of_method, double most_rms, double most_ray) {
  const auto square = [](double x) { return x * x; };
  const double of_codes = square(missed.rms()) - square(of_method);
  const double left = square(most_rms) - square(of_method);
  const double part =
      std::min(std::sqrt(std::max(left, 0.0) / std::max(of_codes, 1e-300)), most_ray / missed.max);
  return part > 0 ? std::clamp(aimed * part, narrowest, narrower) : narrowest;
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
  const double most_rms = coded_rms * tolerance, most_ray = coded_ray * tolerance;
  double share = tolerance;
  for (int trial = 0; trial < most_trials; ++trial) {
    std::vector<float> steps;
    for (const double effect : effects)
      steps.push_back(float(std::min(depth_step * share / effect, 1e30)));
    const CodeWidths widths =
        code_widths(atlas.density, steps, beside, float(light_step * share / brightness));
    if (!widths || double(coded_bytes(*widths, beside)) > most) return;
    const BrickCodes codes = brick_codes(atlas.density, *widths, beside);
    const RayErrors missed = plan.march->pilot->march(
        method, atlas, progress, [&](const RayErrors& errors) { return errors.max <= most_ray; },
        &codes);
    if (missed.rms() <= most_rms && missed.max <= most_ray) {
      PlannedMarch march = *plan.march;
      march.code_widths = widths;
      plan.march = std::make_shared<PlannedMarch>(std::move(march));
      plan.chosen.rms = missed.rms();
      plan.chosen.max = missed.max;
      return;
    }
    share *= next_step(missed, plan.chosen.rms, most_rms, most_ray);
  }
}

}  // namespace psivox
