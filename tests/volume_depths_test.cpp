// Light through several volumes: the depths through each alone, from the voxels of another.

#include "march/volume_depths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "light_cases.h"
#include "march_cases.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Noise beside blobs, and a second volume.
View two_volumes(const glm::dvec3& light, Field second) {
  const Scene scene = lit_scene(light);
  View view = view_of(scene, mixed());
  Medium other = view_of(scene, std::move(second)).medium;
  other.extinction *= 0.7;
  view.medium.others.push_back(std::move(other));
  return view;
}

/// Blobs, smaller, turned and moved.
Field placed_blobs(const glm::dvec3& by) {
  const glm::dmat4 turned = glm::rotate(glm::translate(glm::dmat4(1), by), 0.7, {1, 2, -0.5});
  return blobs({0, 0, 0}, glm::scale(turned, {0.8, 0.6, 0.7}));
}

/// Depths from the voxels of a volume of a view; 0: the first.
struct Seen {
  View view;
  std::vector<glm::ivec3> blocks;

  Seen(const View& of, std::size_t volume) : view(seen_from(of, volume)), blocks(blocks_of(view)) {}
  std::vector<double> depths(const LightDepths& from, const LightMethod& method = {}) const {
    return depths_of(view, from, blocks, method);
  }
  Difference difference(const std::vector<double>& a, const std::vector<double>& b) const {
    return difference_of(view, blocks, a, b);
  }
};

struct Placed {
  const char* name;
  glm::dvec3 light, by;
};

const Placed cases[] = {{"one inside the other", {-0.3, -1, 0.2}, {10, 10, 10}},
                        {"side by side", {-1, 0.1, 0.2}, {50, 5, 0}},
                        {"one behind the other", {0.2, 1, -0.1}, {0, 45, 0}}};

TEST(VolumeDepths, OfRaysAreTheReferences) {
  for (const Placed& place : cases) {
    const View view = two_volumes(place.light, placed_blobs(place.by));
    const VolumeDepths depths(view);
    for (const std::size_t volume : {std::size_t{0}, std::size_t{1}}) {
      const Seen seen(view, volume);
      const Difference d = seen.difference(seen.depths(depths.at(volume)),
                                           seen.depths(reference_light_depths(view, volume)));
      // what another volume hides is kept in float32: the depth's rounding, e^-depth x depth 2^-24
      EXPECT_LE(d.max, std::exp(-1) * 0x1p-24) << place.name << ' ' << volume;
    }
  }
}

TEST(VolumeDepths, ATwinHidesAsMuchAsTheVolumeItself) {
  for (const double spacing : {2.0, 1.0, 0.5})
    for (const Placed& place : cases) {
      View view = two_volumes(place.light, mixed());
      view.medium.others.front().extinction = view.medium.extinction;
      const MediumAtlas atlas = build_medium_atlas(view);
      const std::vector<glm::ivec3> blocks = blocks_of(view);
      const VolumeDepths depths(view, &atlas);
      const LightMethod method{.spacing = spacing};
      std::vector<double> twice =
          depths_of(view, march_double_light_depths(view, atlas), blocks, method);
      for (double& depth : twice) depth *= 2;
      const Difference d =
          difference_of(view, blocks, depths_of(view, depths.at(0), blocks, method), twice);
      // columns are interpolated alike at a voxel and at its twin; what is left is float32, as
      // above
      EXPECT_LE(d.max, 0x1p-24) << place.name << ' ' << spacing;
    }
}

TEST(VolumeDepths, OfColumnsConverge) {
  for (const Placed& place : cases) {
    const View view = two_volumes(place.light, placed_blobs(place.by));
    const VolumeDepths depths(view);
    for (const std::size_t volume : {std::size_t{0}, std::size_t{1}}) {
      const Seen seen(view, volume);
      const std::vector<double> exact = seen.depths(depths.at(volume));
      double before = HUGE_VAL;
      for (const double spacing : {2.0, 1.0, 0.5, 0.25}) {
        const Difference d =
            seen.difference(seen.depths(depths.at(volume), {.spacing = spacing}), exact);
        std::printf("  %s, volume %d, spacing %g: rms %.2e, max %.2e\n", place.name, int(volume),
                    spacing, d.rms, d.max);
        // as of one volume (light_lattice_test.cpp). Slices stay a voxel apart, which is what is
        // left of a quarter voxel where the volumes overlap
        if (spacing > 0.25 || place.by != cases[0].by)
          EXPECT_LE(d.rms, 0.6 * before) << place.name << ' ' << volume;
        else
          EXPECT_LE(d.rms, before);
        before = d.rms;
      }
    }
  }
}

}  // namespace
}  // namespace psivox
