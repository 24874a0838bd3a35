#include "medium/density_function.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/label_function.h"
#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox {

std::optional<glm::dvec2> resolved_range(const Scene& scene, const Field& density) {
  if (!scene.windows()) return std::nullopt;
  if (scene.range) {
    glm::dvec2 range = scene.range->ends;
    for (int i = 0; i < 2; ++i)
      range[i] = scene.range->percent[i] ? active_percentile(density, range[i])
                                         : density.scale.scaled(range[i]);
    if (range.x < range.y) return range;
    const Parameter& p = *find_parameter("range");
    // of two percentages it is the file that makes them one value
    const bool of_file = scene.range->percent == glm::bvec2(true);
    throw Error(of_file ? ExitCode::input : ExitCode::usage,
                "--range " + parameter_text(scene, p) + " goes from " + number_text(range.x) +
                    " to " + number_text(range.y) + " in grid " + in_quotes(density.name) +
                    "; MIN must be below MAX");
  }
  glm::dvec2 range = active_range(density);
  if (scene.shows(Shows::value) && !scene.colormap && range.y > 0) {
    const bool greatest = scene.mode == Mode::mip || scene.mode == Mode::lmip;
    return glm::dvec2(greatest ? 0 : std::min(range.x, 0.0), range.y);
  }
  if (density.of_vectors) {  // 0 is at the map's middle or beginning
    range.y = std::max(range.y, -range.x);
    range.x = range.x < 0 ? -range.y : 0;
  }
  if (range.x < range.y) return range;
  if (range.x == 0) return glm::dvec2(0, 1);
  return glm::dvec2(std::min(range.x, 0.0), std::max(range.x, 0.0));
}

void check_gradient_rules(const Scene& scene) {
  const auto fail = [&](const std::string& what, const std::string& instead) {
    throw Error(ExitCode::usage, "--transfer-function " + in_quotes(scene.transfer_function) +
                                     " has gradients: " + what + "; " + instead);
  };
  if (scene.shows(Shows::value))
    fail("a greatest value has none", "take --mode alpha, back-to-front, xray or isosurface");
  const bool voxels = scene.classification == Classification::pre;
  const Integrator rule = scene.resolved_integrator();
  if (is_transfer_rule(rule) || (is_cell_rule(rule) && !voxels))
    fail("--integrator " + std::string(info(rule).name) + " integrates a function of one variable",
         "take psi-weighted or another rule of segments");
  if (scene.split_knots && !voxels)
    fail("--split-knots finds knots of values alone", "leave it out and raise --segments");
}

namespace {

/// The map of a component, whose sign is a direction: its magnitude attenuates. The map has a point
/// at 0.
TransferFunction by_magnitude(const TransferFunction& map) {
  std::vector<TransferPoint> points = map.points();
  for (TransferPoint& point : points) point.attenuation = std::abs(point.value);
  return TransferFunction(std::move(points));
}

/// The magnitude of a component that has values on both sides of 0, or below it.
std::shared_ptr<const TransferFunction> magnitude_of(const Field& component) {
  const glm::dvec2 stored = stored_range(component);
  if (stored.x >= 0) return nullptr;
  std::vector<TransferPoint> points = {{stored.x, -stored.x}, {0, 0}};
  if (stored.y > 0) points.push_back({stored.y, stored.y});
  return std::make_shared<const TransferFunction>(std::move(points), /*has_color=*/false);
}

}  // namespace

std::shared_ptr<const TransferFunction> density_function(const Scene& scene, const Field& density) {
  if (scene.windows() && scene.colormap == Colormap::labels)
    return std::make_shared<const TransferFunction>(label_function(density));
  if (scene.windows()) {
    TransferFunction function =
        window_function(scene, *resolved_range(scene, density), stored_range(density));
    if (density.of_vectors && scene.colormap && !scene.opacity) function = by_magnitude(function);
    return std::make_shared<const TransferFunction>(std::move(function));
  }
  if (scene.transfer_function.empty())
    return density.of_vectors && scene.attenuates() ? magnitude_of(density) : nullptr;
  auto function = std::make_shared<const TransferFunction>(
      scaled_function(read_transfer_function(scene.transfer_function), density.scale));
  if (function->has_color() && !(scene.luminance_grid.empty() && scene.temperature_grid.empty()))
    throw Error(ExitCode::usage,
                "--transfer-function " + in_quotes(scene.transfer_function) +
                    " has colours, which are the luminance; leave them out of it, or leave out " +
                    (scene.luminance_grid.empty() ? "--temperature-grid" : "--luminance-grid"));
  if (function->has_gradient()) check_gradient_rules(scene);
  return function;
}

double otsu_threshold(const Field& density) {
  constexpr int bins = 1024;
  const glm::dvec2 range = stored_range(density);
  if (!(range.x < range.y)) return 0.5 * range.y;
  std::array<double, bins> counts{};
  double stored = 0;
  const auto take = [&](float value, double voxels) {
    stored += voxels;
    if (std::isnan(value)) return;  // absent
    const double place = (double(value) - range.x) / (range.y - range.x) * bins;
    counts[std::size_t(std::clamp(place, 0.0, bins - 1.0))] += voxels;
  };
  for_active(density, [&](float value, std::uint64_t voxels) { take(value, double(voxels)); });
  // where nothing is stored the value is 0; no more of it than of all else, or it is all that
  // counts
  take(0, std::clamp(double(count_of(density.active_box)) - stored, 0.0, stored));
  double all = 0, sum = 0;
  for (int i = 0; i < bins; ++i) {
    all += counts[std::size_t(i)];
    sum += counts[std::size_t(i)] * i;
  }
  double below = 0, sum_below = 0, most = -1, first = 0, last = 0;
  for (int i = 0; i + 1 < bins; ++i) {
    below += counts[std::size_t(i)];
    sum_below += counts[std::size_t(i)] * i;
    if (below == 0 || below == all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double variance = below * (all - below) * apart * apart;
    if (variance > most * (1 + 1e-12)) first = i;
    if (variance >= most * (1 - 1e-12)) last = i;
    most = std::max(most, variance);
  }
  if (most < 0) return 0.5 * (range.x + range.y);
  return range.x + (range.y - range.x) * (0.5 * (first + last) + 1) / bins;
}

std::vector<ShownSurface> resolved_isovalue(const Scene& scene, const Field& density) {
  std::vector<ShownSurface> surfaces = scene.isovalue;
  std::ranges::sort(surfaces, {}, &ShownSurface::value);
  if (surfaces.empty()) {
    const bool distances = density.half_width > 0;
    surfaces.push_back({distances ? 0 : density.scale.value_of(otsu_threshold(density))});
  }
  for (const ShownSurface& surface : surfaces)
    if (density.half_width > 0 && std::abs(surface.value) >= density.half_width)
      throw Error(ExitCode::usage, "--isovalue " + number_text(surface.value) + ": level set " +
                                       in_quotes(density.name) + " has distances below " +
                                       formatted("%.6g", density.half_width) +
                                       " only, either side");
  return surfaces;
}

double field_isovalue(double isovalue, const Field& density) {
  return density.half_width > 0 ? density.half_width - isovalue : density.scale.scaled(isovalue);
}

}  // namespace psivox
