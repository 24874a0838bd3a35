#include "look/flame.h"

#include <algorithm>
#include <utility>

#include "look/draft.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

constexpr const char* glowing_names[] = {"flame", "flames", "fire", "temperature",
                                         "heat",  "temp",   "fuel"};
constexpr std::size_t flames = 3;
constexpr double least_kelvin = 200, coldest = 800, hottest = 2300;
/// Radiance of the flame's brightest hundredth, in its brightest channel.
constexpr double brightest = 4, bright_part = 0.01;
/// Solvers leave rounding where nothing burns.
constexpr float no_flame = 1e-5f;

}  // namespace

std::span<const char* const> flame_names(bool hot) {
  return std::span(glowing_names).first(hot ? std::size(glowing_names) : flames);
}

Flame find_flame(const VdbFile& file, const std::string& density) {
  for (const std::string grid : flame_names(true)) {
    if (grid == density || file.channels(grid) != 1) continue;
    const Field field = file.read(grid, {.role = GridRole::data, .empty = true});
    if (field.active_voxels && field.active_range && field.active_range->y > no_flame)
      return {grid, double(field.active_range->y)};
    // a flame's grid says that nothing burns
    if (std::ranges::count(flame_names(false), grid)) return {};
  }
  return {};
}

void set_flame(const Scene& asked, const VdbFile& file, const Flame& flame, Scene& scene) {
  Scene glowing = scene;
  const auto set = [&](const char* name, auto Scene::*member, const auto& value) {
    if (!is_given(asked, name)) glowing.*member = value;
  };
  set("emission-grid", &Scene::emission_grid, flame.grid);
  set("emission-color", &Scene::emission_color, EmissionColor::black_body);
  if (flame.greatest <= least_kelvin) {
    set("temperature-scale", &Scene::temperature_scale, (hottest - coldest) / flame.greatest);
    set("temperature-offset", &Scene::temperature_offset, coldest);
  }
  Scene alone = glowing;
  alone.emission_scale = 1;  // the radiance is proportional to it
  alone.lights.clear();
  alone.sky.reset();
  for (const char* part : {"environment", "environment-rotation", "environment-scale"})
    set_default(alone, *find_parameter(part));
  alone.luminance = glm::dvec3(0);
  const MediumFields fields = read_fields(alone, file);
  double level = glow_level(draft_picture(alone, fields), bright_part);
  if (level == 0) {  // the smoke hides it
    alone.extinction = 0;
    level = glow_level(draft_picture(alone, fields), bright_part);
  }
  if (level == 0) return;
  set("emission-scale", &Scene::emission_scale, brightest / level);
  scene = std::move(glowing);
}

}  // namespace psivox
