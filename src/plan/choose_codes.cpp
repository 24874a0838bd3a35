#include "plan/choose_codes.h"

#include <cmath>
#include <cstdlib>
#include <optional>

#include "field/index_space.h"
#include "march/march_double.h"
#include "plan/brick_effects.h"
#include "plan/trials.h"

namespace psivox {
namespace {

/// Of codes that are chosen first, a step changes the optical depth of a voxel times the light
/// there by this much [tolerances]; and light by this much. Errors of a ray's voxels are
/// independent.
constexpr double depth_step = 1, light_step = 2;

/// Each further trial's codes are so much finer.
constexpr double finer = 0.25;
constexpr int most_trials = 3;

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

/// What the pilot's rays show over an atlas.
Image drawn_in_double(const View& view, const MediumAtlas& atlas, const BrickSteps& steps,
                      const Progress& progress) {
  const View small = pilot_view(view);
  const glm::ivec2 size = small.scene.resolution;
  std::vector<glm::ivec2> pixels;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) pixels.emplace_back(x, y);
  std::vector<MarchedRay> rays(pixels.size());
  PixelMarch(small, atlas, steps).march(pixels, rays, progress);
  Image image{size.x, size.y, {{"", {"R", "G", "B", "A"}, {}}}, {}};
  for (const MarchedRay& ray : rays)
    for (int c = 0; c < 4; ++c) image.layers[0].values.push_back(ray.picture[c]);
  return image;
}

}  // namespace

bool may_be_coded(const View& view) {
  return view.scene.texel == TexelType::automatic && view.scene.attenuates() &&
         !view.medium.gradient;
}

void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance,
                  const std::function<const MediumAtlas&(const CodeWidths&)>& coded,
                  const Progress& progress) {
  const View& view = plan.march->view;
  if (!may_be_coded(view) || !plan.reached || plan.rays == 0) return;
  const std::vector<double> effects = effects_of_values(view, atlas);
  const BrickAtlas* beside = atlas.paired ? &*atlas.luminance : nullptr;
  const glm::dvec3& color = view.medium.color;
  const double brightness = std::max({color.x, color.y, color.z, 1e-30});
  const double most =
      worthwhile * double(atlas.density.size.texel_bytes + (beside ? beside->size.texel_bytes : 0));
  double share = tolerance;
  if (const char* e = std::getenv("HL_STEP")) share *= std::atof(e);
  for (int trial = 0; trial < most_trials; ++trial, share *= finer) {
    std::vector<float> steps;
    for (const double effect : effects)
      steps.push_back(float(std::min(depth_step * share / effect, 1e30)));
    const CodeWidths widths =
        code_widths(atlas.density, steps, beside, float(light_step * share / brightness));
    if (!widths) return;
    const MediumAtlas& codes = coded(widths);
    if (double(codes.density.size.texel_bytes) > most) return;
    const Image drawn = drawn_in_double(view, codes, plan.march->brick_steps, progress);
    const Comparison missed = compare_images(drawn, plan.march->truth);
    if (std::getenv("HL_STEP")) {
      int n[3] = {0, 0, 0};
      for (auto w : *widths) ++n[int(w)];
      fprintf(stderr,
              "codes: share %g bytes %.3f widths %d %d %d float rms %.3g max %.3g coded rms %.3g "
              "max %.3g\n",
              share, double(codes.density.size.texel_bytes) / most * worthwhile, n[0], n[1], n[2],
              plan.chosen.rms / tolerance, plan.chosen.max / tolerance, missed.rms / tolerance,
              missed.max / tolerance);
    }
    if (missed.rms > pilot_safety * tolerance || missed.max > worst_ray * tolerance) continue;
    PlannedMarch march = *plan.march;
    march.code_widths = widths;
    plan.march = std::make_shared<PlannedMarch>(std::move(march));
    plan.chosen.rms = missed.rms;
    plan.chosen.max = missed.max;
    return;
  }
}

}  // namespace psivox
