#include "plan/choose_codes.h"

#include <cmath>
#include <numeric>
#include <optional>

#include "base/statistics.h"
#include "field/index_space.h"
#include "march/march_double.h"
#include "plan/brick_effects.h"

namespace psivox {
namespace {

/// Of codes that are chosen first, a step changes the optical depth of a voxel times the light
/// there by this much [tolerances]; and light by this much. Errors of a ray's voxels are
/// independent.
constexpr double depth_step = 3, light_step = 3;

/// Each further trial's codes are so much finer.
constexpr double finer = 1.0 / 3;
constexpr int most_trials = 3;

/// What the pilot's rays may show with codes [tolerances]: a method may take nearly all that any
/// may (pilot_safety, worst_ray), and codes a little more.
constexpr double coded_rms = 0.85, coded_ray = 4.5;

/// Rays that are marched before what they show is looked at.
constexpr std::size_t batch = 128;

/// Part of the float32 texels' bytes above which they stay.
constexpr double worthwhile = 0.75;

/// How much of a picture a change of a brick's values by 1 changes in a voxel, by slot.
std::vector<double> effects_of_values(const View& view, const MediumAtlas& atlas) {
  const Medium& medium = view.medium;
  const Peak peak(view, atlas);
  const double scale = medium.extinction * finest_voxel(*medium.density);
  const double brightness = std::max({medium.color.x, medium.color.y, medium.color.z});
  std::optional<FunctionBends> bends;
  if (medium.transfer) bends.emplace(*medium.transfer);
  std::vector<double> effects;
  for (const BrickStats& brick : atlas.density.bricks) {
    const double min = brick.min, max = brick.max;
    FunctionBend bend{.most = max};
    if (bends) bend = bends->between(min, max);
    double light = 0;
    if (medium.source == LuminanceSource::density) light = brightness;
    if (medium.source == LuminanceSource::transfer) light = brightness * bend.color_slope;
    effects.push_back(scale * bend.slope * std::max(1.0, peak.at(min, max)) +
                      std::min(1.0, scale * bend.most) * light);
  }
  return effects;
}

/// Errors of the pilot's rays over an atlas, by all channels. It ends with the first batch in which
/// a ray is beyond `most`.
ErrorSum errors_over(const MediumAtlas& atlas, const PlannedMarch& planned, double most,
                     const Progress& progress) {
  const Image& truth = planned.truth;
  const std::size_t count = std::size_t(truth.width) * std::size_t(truth.height);
  std::vector<glm::ivec2> pixels;
  // a stride that has no divisor in common with the count, so that a batch is spread
  std::size_t stride = std::max<std::size_t>(std::size_t(0.618 * double(count)), 1);
  while (std::gcd(stride, count) != 1) ++stride;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * stride % count;
    pixels.emplace_back(at % std::size_t(truth.width), at / std::size_t(truth.width));
  }
  const PixelMarch march(pilot_view(planned.view), atlas, planned.brick_steps);
  std::vector<MarchedRay> rays(std::min(batch, count));
  ErrorSum sum;
  for (std::size_t first = 0; first < count && sum.max <= most; first += batch) {
    const std::size_t some = std::min(batch, count - first);
    const std::span<const glm::ivec2> these = std::span(pixels).subspan(first, some);
    march.march(these, std::span(rays).first(some), progress);
    for (std::size_t i = 0; i < some; ++i) {
      const std::size_t at = std::size_t(these[i].y * truth.width + these[i].x);
      for (int c = 0; c < 4; ++c)
        sum.add(double(rays[i].picture[c]) - double(truth.rgba()[4 * at + std::size_t(c)]), at);
    }
  }
  return sum;
}

}  // namespace

bool may_be_coded(const View& view) {
  return view.scene.texel == TexelType::automatic && view.scene.filter == Filter::exact &&
         view.scene.attenuates() && !view.medium.gradient;
}

void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance,
                  const std::function<const MediumAtlas&(const CodeWidths&)>& coded,
                  const Progress& progress) {
  const View& view = plan.march->view;
  if (!plan.reached || plan.rays == 0) return;
  const std::vector<double> effects = effects_of_values(view, atlas);
  const BrickAtlas* beside = atlas.paired ? &*atlas.luminance : nullptr;
  const glm::dvec3& color = view.medium.color;
  const double brightness = std::max({color.x, color.y, color.z, 1e-30});
  const double most =
      worthwhile * double(atlas.density.size.texel_bytes + (beside ? beside->size.texel_bytes : 0));
  double share = tolerance;
  for (int trial = 0; trial < most_trials; ++trial, share *= finer) {
    std::vector<float> steps;
    for (const double effect : effects)
      steps.push_back(float(std::min(depth_step * share / effect, 1e30)));
    const CodeWidths widths =
        code_widths(atlas.density, steps, beside, float(light_step * share / brightness));
    if (!widths) return;
    const MediumAtlas& codes = coded(widths);
    if (double(codes.density.size.texel_bytes) > most) return;
    const ErrorSum missed = errors_over(codes, *plan.march, coded_ray * tolerance, progress);
    // also where a ray is no number
    if (!(missed.rms() <= coded_rms * tolerance && missed.max <= coded_ray * tolerance)) continue;
    PlannedMarch march = *plan.march;
    march.code_widths = widths;
    plan.march = std::make_shared<PlannedMarch>(std::move(march));
    plan.chosen.rms = missed.rms();
    plan.chosen.max = missed.max;
    return;
  }
}

}  // namespace psivox
