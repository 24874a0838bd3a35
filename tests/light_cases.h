#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "made_fields.h"
#include "march/light.h"
#include "march/march_double.h"
#include "march/medium_atlas.h"
#include "scratch.h"

// Shared by the tests of light.

namespace psivox {

inline Scene lit_scene(const glm::dvec3& direction, int side = 48) {
  Scene scene = small_scene(side);
  scene.lights = {{direction, {1, 1, 1}}};
  return scene;
}

inline std::vector<glm::ivec3> blocks_of(const View& view) {
  return visible_blocks(*view.medium.density, density_options(view));
}

/// Of transmittances.
struct Difference {
  double max = 0, rms = 0;
};

/// Optical depths at the voxels of `blocks`, 512 a block: towards the view's first light, or the
/// sky's first direction, by a method.
inline std::vector<double> depths_of(const View& view, const LightDepths& depths,
                                     std::span<const glm::ivec3> blocks,
                                     const LightMethod& method = {}) {
  Beam beam = light_beams(view).front();
  beam.method = method;
  std::vector<double> result(512 * blocks.size());
  depths({&beam, 1}, blocks,
         [&](std::size_t, std::size_t block, std::span<const double> part) {
           std::copy(part.begin(), part.end(), result.begin() + std::ptrdiff_t(512 * block));
         },
         {});
  return result;
}

/// Difference of transmittances at the voxels of the domain.
inline Difference difference_of(const View& view, const std::vector<glm::ivec3>& blocks,
                                const std::vector<double>& a, const std::vector<double>& b) {
  const Box domain = view.medium.density->domain();
  Difference d;
  double count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int n = int(i % 512);
    const glm::ivec3 at = blocks[i / 512] + glm::ivec3(n >> 6, (n >> 3) & 7, n & 7);
    if (glm::clamp(at, domain.min, domain.max) != at) continue;
    const double off = std::abs(std::exp(-a[i]) - std::exp(-b[i]));
    d.max = std::max(d.max, off);
    d.rms += off * off;
    count += 1;
  }
  d.rms = std::sqrt(d.rms / std::max(count, 1.0));
  return d;
}

/// A function whose attenuation turns at several values, in a file.
inline std::string function_file() {
  return test::write_bytes("function.json", R"({"points": [
    {"value": 0, "attenuation": 0, "color": [1, 1, 1]},
    {"value": 0.2, "attenuation": 1, "color": [1, 0.5, 0.25]},
    {"value": 0.5, "attenuation": 0.3, "color": [0.5, 1, 0.5]},
    {"value": 0.50001, "attenuation": 2, "color": [0, 1, 1]},
    {"value": 1, "attenuation": 0.5, "color": [1, 0, 1]}]})")
      .string();
}

inline View lit_in_double(const View& view) {
  const MediumAtlas atlas = build_medium_atlas(view);
  return lit(view, march_double_light_depths(view, atlas));
}

}  // namespace psivox
