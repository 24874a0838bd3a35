#include "scene/color.h"

#include <array>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "psivox/error.h"
#include "scene/enum_names.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

struct Knot {
  double u;
  glm::dvec3 light;
};
using Knots = std::vector<Knot>;

/// From matplotlib's tables by tools/make_colormaps.py, as [place of 256, red, green, blue] in sRGB
/// codes: linear radiance between knots is within half an 8-bit step of them. viridis, inferno,
/// magma, plasma: S. van der Walt and N. Smith (CC0); cividis: J. Nunez, C. Anderton, R. Renslow
/// 2018 (CC0); turbo: A. Mikhailov, Google 2019 (Apache 2.0).
Knots from_table(const std::string& name) {
  static const auto tables = nlohmann::json::parse(color_data().at("colormaps.json"));
  Knots knots;
  for (const std::array<double, 4> k : tables.at(name))
    knots.push_back({k[0] / 255, linear_from_srgb({k[1], k[2], k[3]})});
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
  if (map == Colormap::coolwarm) return from_curve(coolwarm, {0, 0.5, 1});
  if (map == Colormap::gray) return from_curve(gray, {0, 1});
  if (map == Colormap::hot) return from_curve(hot, {0, red_full, green_full, 1});
  return from_table(enum_names(map)[std::size_t(map)]);
}

const Knots& knots_of(Colormap map) {
  static const std::vector<Knots> all = [] {
    std::vector<Knots> made;
    for (std::size_t i = 0; i < enum_names(Colormap{}).size(); ++i)
      made.push_back(make_knots(static_cast<Colormap>(i)));
    return made;
  }();
  return all[std::size_t(map)];
}

}  // namespace

glm::dvec3 colormap_color(Colormap map, double u) {
  const Knots& knots = knots_of(map);
  const auto above = std::ranges::upper_bound(knots, u, {}, &Knot::u);
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
