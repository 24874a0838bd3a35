#include "look/flame.h"

#include <algorithm>

#include "look/draft.h"

namespace psivox {
namespace {

constexpr double least_kelvin = 200, coldest = 1000, hottest = 2500;
/// Radiance of the flame's brightest hundredth, in its brightest channel.
constexpr double brightest = 0.9, bright_part = 0.01;

}  // namespace

void set_flame(Scene& scene, const VdbFile& file, const std::string& grid) {
  const Field flame = file.read(grid, {.role = GridRole::data});
  const double greatest = flame.active_range ? double(flame.active_range->y) : 1;
  scene.emission_grid = grid;
  scene.emission_color = EmissionColor::black_body;
  if (greatest <= least_kelvin) {
    scene.temperature_scale = (hottest - coldest) / std::max(greatest, 1e-6);
    scene.temperature_offset = coldest;
  }
  Scene alone = scene;
  alone.emission_scale = 1;
  alone.lights.clear();
  alone.luminance = glm::dvec3(0);
  const double level = make_draft(alone, read_fields(alone, file)).level(bright_part);
  if (level > 0) scene.emission_scale = brightest / level;
}

}  // namespace psivox
