#include "psivox/colormap.h"

#include <span>

#include "psivox/error.h"
#include "psivox/text.h"
#include "psivox/transfer_function.h"
#include "scene/color_space.h"
#include "scene/colormap_tables.h"
#include "scene/value_window.h"

namespace psivox {
namespace {

struct Knot {
  double u;
  glm::dvec3 light;
};
using Knots = std::vector<Knot>;

Knots from_table(std::span<const ColormapKnot> table) {
  Knots knots;
  for (const ColormapKnot& k : table)
    knots.push_back({k.place / 255.0, linear_from_srgb({k.red, k.green, k.blue})});
  return knots;
}

/// A curve of sRGB codes over u, smooth between consecutive `places`, which ascend from 0 to 1.
template <typename Curve>
Knots from_curve(const Curve& curve, std::initializer_list<double> places) {
  Knots knots{{0, linear_from_srgb(curve(0))}};
  for (const double* place = places.begin(); place + 1 != places.end(); ++place)
    for (const double u : color_knots(curve, place[0], place[1]))
      knots.push_back({u, linear_from_srgb(curve(u))});
  return knots;
}

/// Moreland's "cool to warm", ParaView's default.
glm::dvec3 coolwarm(double u) {
  return mix_diverging(glm::dvec3(59, 76, 192) / 255.0, glm::dvec3(180, 4, 38) / 255.0, u);
}

glm::dvec3 gray(double u) { return glm::dvec3(u); }

/// matplotlib's map: red, then green, then blue rise to 1.
constexpr double red_full = 0.365079, green_full = 0.746032;
glm::dvec3 hot(double u) {
  const auto rise = [u](double from, double to) {
    return std::clamp((u - from) / (to - from), 0., 1.);
  };
  return {0.0416 + (1 - 0.0416) * rise(0, red_full), rise(red_full, green_full),
          rise(green_full, 1)};
}

Knots make_knots(Colormap map) {
  switch (map) {
    case Colormap::viridis:
      return from_table(viridis_knots);
    case Colormap::inferno:
      return from_table(inferno_knots);
    case Colormap::magma:
      return from_table(magma_knots);
    case Colormap::plasma:
      return from_table(plasma_knots);
    case Colormap::cividis:
      return from_table(cividis_knots);
    case Colormap::turbo:
      return from_table(turbo_knots);
    case Colormap::coolwarm:
      return from_curve(coolwarm, {0, 0.5, 1});
    case Colormap::gray:
      return from_curve(gray, {0, 1});
    case Colormap::hot:
      return from_curve(hot, {0, red_full, green_full, 1});
  }
  throw Error(ExitCode::usage, "no such colour map");
}

constexpr int map_count = static_cast<int>(Colormap::hot) + 1;

const Knots& knots_of(Colormap map) {
  static const std::vector<Knots> all = [] {
    std::vector<Knots> made;
    made.reserve(map_count);
    for (int i = 0; i < map_count; ++i) made.push_back(make_knots(static_cast<Colormap>(i)));
    return made;
  }();
  return all[static_cast<std::size_t>(map)];
}

}  // namespace

glm::dvec3 colormap_color(Colormap map, double u) {
  const Knots& knots = knots_of(map);
  const auto above = std::upper_bound(knots.begin(), knots.end(), u,
                                      [](double place, const Knot& k) { return place < k.u; });
  if (above == knots.begin()) return knots.front().light;
  if (above == knots.end()) return knots.back().light;
  const Knot &a = above[-1], &b = *above;
  return glm::mix(a.light, b.light, (u - a.u) / (b.u - a.u));
}

std::vector<double> colormap_knots(Colormap map) {
  std::vector<double> places;
  for (const Knot& k : knots_of(map)) places.push_back(k.u);
  return places;
}

TransferFunction colormap_function(Colormap map, double range_min, double range_max,
                                   double data_min, double data_max) {
  if (!(range_min < range_max))
    throw Error(ExitCode::input, "colour map over " + number_text(range_min) + " to " +
                                     number_text(range_max) +
                                     ": the first must be below the second");
  Scene scene;
  scene.colormap = map;
  return window_function(scene, {range_min, range_max}, {data_min, data_max});
}

}  // namespace psivox
