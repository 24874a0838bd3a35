#include "ray_radiance.h"
#include "scene/transfer_function.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>

namespace psivox {
namespace {

bool all_zero(const std::array<double, 8>& corners) {
  return std::all_of(corners.begin(), corners.end(), [](double v) { return v == 0; });
}

std::optional<FieldLookup> lookup_of(const std::shared_ptr<const Field>& field) {
  if (!field) return std::nullopt;
  return FieldLookup(*field);
}

bool has_luminance_grid(const Medium& medium) {
  return medium.source == LuminanceSource::scalar || medium.source == LuminanceSource::vector;
}

/// Upper bound on the length of a path through a field's domain [world units].
double longest_way(const Field& field) {
  const glm::dvec3 size = glm::dvec3(field.domain().max) - glm::dvec3(field.domain().min);
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += glm::length(glm::dvec3(field.world_from_index[i])) * size[i];
  return sum;
}

double max_color(const TransferFunction& function) {
  double most = 0;
  for (const TransferPoint& point : function.points())
    most = std::max(most, max_component(point.color));
  return most;
}

}  // namespace

RayMedium::RayMedium(const Medium& m)
    : medium(m),
      density(*medium.density),
      luminance(has_luminance_grid(medium) ? lookup_of(medium.luminance) : std::nullopt),
      emission(lookup_of(medium.emission)),
      gradient(lookup_of(medium.gradient)),
      color(m.color) {
  L_max = max_component(glm::abs(color));
  if (luminance)
    L_max *= luminance->max_magnitude();
  else if (medium.source == LuminanceSource::density)
    L_max *= density.max_magnitude();
  else if (medium.source == LuminanceSource::transfer)
    L_max *= max_color(*medium.transfer);
  const double g = std::abs(medium.phase_g);
  L_max *= (1 + g) / ((1 - g) * (1 - g));  // the greatest value of the phase function
  behind_max = L_max + max_component(medium.ambient);
  if (emission)
    behind_max +=
        std::abs(medium.emission_scale) * emission->max_magnitude() * longest_way(*medium.emission);
  for (const Medium& other : m.others) {
    others.emplace_back(other);
    behind_max += others.back().behind_max;
  }
}

// The rounding of any sum hides a transparency below 1e-21; near 1e-308 it has no digits itself.
RayIntegrator::RayIntegrator(const RayMedium& medium, double tolerance)
    : medium_(&medium),
      by_stretches_(medium.medium.transfer || medium.medium.emission || !medium.others.empty()),
      accuracy_{tolerance, std::max(tolerance, 1e-20) / (10 * std::max(1.0, medium.behind_max))},
      density_cache_(medium.density) {
  // Pieces of one grid's cells are summed first and then multiplied by the colour, so the colour
  // divides the tolerance.
  if (!by_stretches_)
    accuracy_.tolerance /= std::max(max_component(glm::abs(medium.color)), 1e-300);
  if (medium.luminance) luminance_cache_.emplace(*medium.luminance);
  if (medium.emission) emission_cache_.emplace(*medium.emission);
  if (medium.gradient) gradient_cache_.emplace(*medium.gradient);
  for (const RayMedium& other : medium.others) others_.emplace_back(other, tolerance);
}

RayRadiance RayIntegrator::radiance(const WorldRay& ray, double t0, double t1) {
  if (by_stretches_) return radiance_by_stretches(ray, t0, t1);
  const Medium& medium = medium_->medium;
  const double t_middle = nearest_to_middle(*medium.density, ray);
  const IndexRay density_ray = make_index_ray(*medium.density, ray, t_middle, t0, t1);
  IndexRay luminance_ray;
  if (medium_->luminance) luminance_ray = make_index_ray(*medium.luminance, ray, t_middle, t0, t1);

  RaySum sum;
  bool stopped = false;
  walk_cells(medium_->density, density_cache_, density_ray, [&](const CellPiece& cell) {
    const std::array<double, 8> corners = cell.block.corners(cell.cell, 0);
    if (all_zero(corners)) return true;
    ++sum.cells;
    if (medium_->luminance)
      add_across_grid(cell, corners, density_ray, luminance_ray, sum);
    else
      add_whole(cell, corners, density_ray, sum);
    stopped = sum.T <= accuracy_.T_stop;
    return !stopped;
  });

  if (medium.source == LuminanceSource::constant) {
    sum.radiance = glm::dvec3(sum.opacity());
    sum.L_max = 1;
  } else if (medium.source != LuminanceSource::vector) {
    sum.radiance = glm::dvec3(sum.radiance.x);
  }
  const double extents =
      extent(*medium.density) + (medium_->luminance ? extent(*medium.luminance) : 0);

  const glm::dvec3 color = medium_->color * phase_factor(medium, ray.direction);
  RayRadiance result;
  result.radiance = color * sum.radiance + medium.ambient * sum.opacity();
  result.optical_depth = sum.optical_depth;
  const double opacity_error = sum.opacity_rounding(extents);
  result.error = max_component(glm::abs(color)) * (sum.error + sum.rounding(extents)) +
                 max_component(medium.ambient) * opacity_error +
                 (stopped ? sum.T * medium_->behind_max : 0);
  result.error = std::max(result.error, opacity_error + (stopped ? sum.T : 0));
  result.cells = sum.cells;
  return result;
}

/// Adds a cell as one piece: luminance is constant or the density grid's own.
void RayIntegrator::add_whole(const CellPiece& cell, const std::array<double, 8>& corners,
                              const IndexRay& ray, RaySum& sum) const {
  const Cubic value =
      cubic_along(corners, ray.in_cell(cell.cell, cell.begin), ray.in_cell(cell.cell, cell.end));
  Piece piece;
  piece.x = scaled(value, medium_->medium.extinction * (cell.end - cell.begin));
  if (medium_->medium.source == LuminanceSource::constant) {
    sum.pass(piece.optical_depth());
    return;
  }
  piece.channels = 1;
  piece.L[0] = value;
  sum.add(piece, accuracy_);
}

/// Adds a piece for each cell of the grid that gives the luminance, so that both grids are cubics
/// in each piece. Outside that grid's domain the luminance is 0.
void RayIntegrator::add_across_grid(const CellPiece& cell, const std::array<double, 8>& corners,
                                    const IndexRay& density_ray, const IndexRay& luminance_ray,
                                    RaySum& sum) {
  Piece piece;
  piece.channels = medium_->luminance->field().channels;
  auto add = [&](double a, double b, const glm::ivec3* luminance_cell) {
    if (!(a < b)) return;
    const Cubic value =
        cubic_along(corners, density_ray.in_cell(cell.cell, a), density_ray.in_cell(cell.cell, b));
    piece.x = scaled(value, medium_->medium.extinction * (b - a));
    if (!luminance_cell) {
      sum.pass(piece.optical_depth());
      return;
    }
    const CellBlock& block = luminance_cache_->at(
        {luminance_cell->x >> 3, luminance_cell->y >> 3, luminance_cell->z >> 3});
    for (int c = 0; c < piece.channels; ++c)
      piece.L[static_cast<std::size_t>(c)] =
          cubic_along(block.corners(*luminance_cell, c), luminance_ray.in_cell(*luminance_cell, a),
                      luminance_ray.in_cell(*luminance_cell, b));
    sum.add(piece, accuracy_);
  };
  const double a = std::max(cell.begin, luminance_ray.s_begin);
  const double b = std::min(cell.end, luminance_ray.s_end);
  if (!(a < b)) {
    add(cell.begin, cell.end, nullptr);
    return;
  }
  add(cell.begin, a, nullptr);
  for (CubeSteps step(luminance_ray, 1, a, b); !step.done(); step.next())
    add(step.begin(), step.end(), &step.key());
  add(b, cell.end, nullptr);
}

RayDepth RayIntegrator::whole_depth(const WorldRay& ray, double t0, double t1) {
  if (medium_->medium.transfer) return depth_by_stretches(ray, t0, t1);
  RayDepth all = depth_in_cells(ray, t0, t1);
  for (RayIntegrator& other : others_) {
    const RayDepth more = other.whole_depth(ray, t0, t1);
    all.depth += more.depth;
    all.error += more.error;
    all.cells += more.cells;
  }
  return all;
}

RayDepth RayIntegrator::depth_in_cells(const WorldRay& ray, double t0, double t1) {
  const Field& field = medium_->density.field();
  const IndexRay density_ray = make_index_ray(field, ray, nearest_to_middle(field, ray), t0, t1);
  double sum = 0;
  RayDepth result;
  walk_cells(medium_->density, density_cache_, density_ray, [&](const CellPiece& cell) {
    const std::array<double, 8> corners = cell.block.corners(cell.cell, 0);
    const Cubic value = cubic_along(corners, density_ray.in_cell(cell.cell, cell.begin),
                                    density_ray.in_cell(cell.cell, cell.end));
    sum += mean(value) * (cell.end - cell.begin);
    result.cells += !all_zero(corners);
    return true;
  });
  result.depth = medium_->medium.extinction * sum;
  result.error = (16 + static_cast<double>(result.cells) + extent(field)) *
                 std::numeric_limits<double>::epsilon() * result.depth;
  return result;
}

double RayIntegrator::optical_depth(const WorldRay& ray, double t0, double t1) {
  return whole_depth(ray, t0, t1).depth;
}

RayRadiance ray_radiance(const Medium& medium, const WorldRay& ray, double tolerance) {
  const RayMedium ready(medium);
  return RayIntegrator(ready, tolerance).radiance(ray);
}

double optical_depth(const Field& field, double extinction, const WorldRay& ray, double t0,
                     double t1) {
  Medium medium;
  medium.density = {std::shared_ptr<const Field>(), &field};
  medium.extinction = extinction;
  const RayMedium ready(medium);
  return RayIntegrator(ready, 0).optical_depth(ray, t0, t1);
}

}  // namespace psivox
