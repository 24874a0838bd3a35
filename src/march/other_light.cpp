// Light on further volumes: each is lit as the first one is, with the others in front of it.

#include <memory>
#include <numeric>

#include "march/light.h"
#include "march/march_double.h"
#include "march/medium_atlas.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

/// The view with a further volume in the first one's place, and the first one in its.
View seen_from(const View& view, std::size_t other) {
  View own = view;
  own.medium = view.medium.others[other];
  own.medium.others = view.medium.others;
  own.medium.others[other] = view.medium;
  own.medium.others[other].others.clear();
  if (other < view.scene.volumes.size())
    own.scene.albedo = scene_of_volume(view.scene, view.scene.volumes[other]).albedo;
  return own;
}

/// The beams of the first volume as they light another, whose albedo is its own.
std::vector<Beam> beams_on(const View& other, std::span<const Beam> beams) {
  std::vector<Beam> own = light_beams(other);
  const auto sky = int(beams.size() - own.size());
  if (sky > 0)
    for (const Beam& beam : sky_beams(other, sky)) own.push_back(beam);
  for (Beam& beam : own) beam.method = {.termination = beams.front().method.termination};
  return own;
}

}  // namespace

LightDepths own_light_depths(const View& view) {
  const auto atlas = std::make_shared<const MediumAtlas>(build_medium_atlas(view));
  return [&view, atlas](std::span<const Beam> beams, const LightBlocks& blocks,
                        const TakeLight& take, const Progress& progress) {
    march_double_light_depths(view, *atlas)(beams, blocks, take, progress);
  };
}

void light_others(const View& dark, std::span<const Beam> beams, const DepthsOf& depths_of,
                  Medium& lit, const Progress& progress) {
  const double count = double(dark.medium.others.size());
  for (std::size_t i = 0; i < dark.medium.others.size(); ++i) {
    const View view = seen_from(dark, i);
    const auto all = visible_blocks(*view.medium.density, density_options(view));
    std::vector<std::size_t> wanted(all.size());
    std::iota(wanted.begin(), wanted.end(), std::size_t{0});
    const auto part = [&](double done) {
      if (progress) progress((double(i) + done) / count);
    };
    lit.others[i] =
        LitLuminance(view, beams_on(view, beams)).medium({all, wanted}, depths_of(view), part);
    lit.others[i].others.clear();
  }
}

}  // namespace psivox
