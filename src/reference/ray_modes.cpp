#include "ray_radiance.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "cell_walk.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// A ray through the density grid, from its first stretch inside the domain to its last.
class DensityWalk {
 public:
  DensityWalk(const RayMedium& medium, BlockCache& cache, const WorldRay& ray,
              const glm::dvec2& part)
      : t_middle(nearest_to_middle(*medium.medium.density, ray)),
        grid(cache,
             make_index_ray(*medium.medium.density, ray, t_middle, part.x, part.y,
                            medium.medium.nearest),
             medium.medium.nearest) {
    next();
  }

  bool done() const { return !grid.in_domain(); }
  void next() {
    grid.next();
    cells += grid.in_cell() && !grid.all_zero();
  }
  Cubic value() const { return grid.along(grid.begin(), grid.end()); }
  double s(double u) const { return grid.begin() + u * (grid.end() - grid.begin()); }

  const double t_middle;
  GridWalk grid;
  std::uint64_t cells = 0;
};

/// The first greatest value along the ray; under LMIP, the first local maximum of at least a
/// threshold.
struct Maximum {
  double fall;  ///< that ends a maximum: what rounding makes of a plateau or of a face does not
  std::optional<double> threshold{};
  double value = -infinity;
  double s = 0;
  bool done = false;

  void see(double v, double at) {
    if (done) return;
    if (threshold && value >= *threshold && v < value - fall) done = true;
    if (done || v <= value) return;
    value = v;
    s = at;
  }
};

/// The radiance that shows a maximum.
glm::dvec3 shown(const Medium& medium, double value) {
  if (medium.source == LuminanceSource::transfer)
    return medium.color * medium.transfer->at(value).color;
  return medium.color * value;
}

/// The field's trilinear interpolant at a point of its domain, given from the voxel `anchor`.
double interpolated(BlockCache& cache, const Box& domain, const glm::ivec3& anchor,
                    const glm::dvec3& at, int channel = 0) {
  const glm::ivec3 cell =
      glm::clamp(anchor + glm::ivec3(glm::floor(at)), domain.min, domain.max - 1);
  const glm::dvec3 u = at - glm::dvec3(cell - anchor);
  const std::array<double, 8> corners = cache.at(cell >> 3).corners(cell, channel);
  double value = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 w = glm::mix(1.0 - u, u, glm::dvec3(cube_corner(i)));
    value += corners[std::size_t(i)] * w.x * w.y * w.z;
  }
  return value;
}

/// Central differences over two voxels along each axis [value/voxel]; at the domain's faces and
/// beside absent values shorter.
glm::dvec3 gradient(BlockCache& cache, const Box& domain, const IndexRay& ray, double s) {
  const glm::dvec3 low(domain.min - ray.anchor), high(domain.max - ray.anchor);
  const glm::dvec3 at = glm::clamp(ray.P + s * ray.D, low, high);
  glm::dvec3 g;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 before = at, after = at;
    before[axis] = std::max(at[axis] - 1, low[axis]);
    after[axis] = std::min(at[axis] + 1, high[axis]);
    const double here = interpolated(cache, domain, ray.anchor, at);
    const auto value = [&](glm::dvec3& place) {
      const double there = interpolated(cache, domain, ray.anchor, place);
      if (!std::isnan(there)) return there;
      place = at;
      return here;
    };
    const double behind = value(after), front = value(before), way = after[axis] - before[axis];
    g[axis] = way > 0 ? (behind - front) / way : 0;
  }
  return g;
}

/// Shades a surface from either side: 0.8 from the lights, 0.2 from all directions. `rises`: the
/// value does along the ray.
glm::dvec3 shade(const View& view, const glm::dvec3& gradient, const glm::dvec3& direction,
                 bool rises) {
  const glm::dmat3 m(view.medium.density->world_from_index);
  glm::dvec3 normal = glm::transpose(glm::inverse(m)) * gradient;
  const double size = glm::length(normal);
  if (!(size > 0)) return glm::dvec3(0.2);
  normal /= rises ? -size : size;
  std::vector<ParallelLight> lights = surface_lights(view);
  if (lights.empty()) lights.push_back({direction, glm::dvec3(1)});
  glm::dvec3 light(0);
  for (const ParallelLight& l : lights)
    light += l.radiance * std::max(0.0, -dot(normal, l.direction));
  return 0.2 + 0.8 * light;
}

/// The luminance of a grid at a place of a ray in it; 0 outside its domain.
glm::dvec3 luminance_at(BlockCache& cache, const Field& field, const IndexRay& ray, double s) {
  glm::dvec3 L(0);
  if (!(s >= ray.s_begin && s <= ray.s_end)) return L;
  for (int c = 0; c < 3; ++c)
    L[c] = interpolated(cache, field.domain(), ray.anchor, ray.P + s * ray.D,
                        field.channels == 3 ? c : 0);
  return L;
}

/// Where the values of a stretch pass through a surface's.
struct Passage {
  const Surface* surface;
  double u;  ///< 0 to 1
  bool rises;
};

/// The passages of a stretch in order. `below` remembers the ray's side of each surface, because
/// rounding may lose a passage in a face.
std::vector<Passage> passages(const Cubic& value, const std::vector<Surface>& surfaces,
                              std::vector<bool>& below) {
  const MonotoneEnds ends = monotone_ends(value);
  std::vector<Passage> all;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const double isovalue = surfaces[k].isovalue;
    if (below.size() == k) below.push_back(value[0] < isovalue);
    for (std::size_t i = 0; i <= ends.parts; ++i) {
      const bool now = evaluate(value, ends.u[i]) < isovalue;
      if (now == below[k]) continue;
      all.push_back(
          {&surfaces[k], i == 0 ? 0 : crossing(value, isovalue, ends.u[i - 1], ends.u[i]), !now});
      below[k] = now;
    }
  }
  std::ranges::stable_sort(all, {}, &Passage::u);
  return all;
}

}  // namespace

RayModes::RayModes(const View& view, const RayMedium& medium, double tolerance)
    : view_(&view), medium_(&medium), integrator_(medium, tolerance), clip_(clip_of(view.scene)) {
  if (view.scene.shows(Shows::value) || view.scene.shows(Shows::surface))
    cache_.emplace(medium.density);
  if (view.scene.shows(Shows::surface) && medium.luminance) colors_.emplace(*medium.luminance);
}

RayPicture RayModes::picture(const WorldRay& ray, double end) {
  part_ = clip_interval(clip_, ray);
  part_.y = std::min(part_.y, end);
  if (!(part_.x < part_.y)) return {};
  switch (info(view_->scene.mode).shows) {
    case Shows::light:
      return radiance(ray);
    case Shows::depth:
      return depth(ray);
    case Shows::value:
      return maximum(ray);
    case Shows::surface:
      return surface(ray);
    case Shows::plane:  // draw_slice draws it
      break;
  }
  return {};
}

RayPicture RayModes::radiance(const WorldRay& ray) {
  const RayRadiance r = integrator_.radiance(ray, part_.x, part_.y);
  return {r.radiance, -std::expm1(-r.optical_depth), r.error, infinity, r.cells};
}

RayPicture RayModes::depth(const WorldRay& ray) {
  const RayRadiance d = integrator_.whole_depth(ray, part_.x, part_.y);
  const glm::dvec3& color = view_->medium.color;
  return {color * d.optical_depth, -std::expm1(-d.optical_depth),
          std::max(1.0, max_component(glm::abs(color))) * d.error, infinity, d.cells};
}

RayPicture RayModes::maximum(const WorldRay& ray) {
  const Medium& medium = view_->medium;
  const Mode mode = view_->scene.mode;
  const double sign = mode == Mode::minip ? -1 : 1;  // the least value is the greatest below 0
  Maximum greatest{.fall = medium.least_value};
  if (mode == Mode::lmip)
    greatest.threshold = medium.density->scale.scaled(view_->scene.lmip_threshold);
  double size = 0, integral = 0, length = 0;
  DensityWalk walk(*medium_, *cache_, ray, part_);
  for (; !walk.done() && !greatest.done; walk.next()) {
    if (walk.grid.absent()) {
      greatest.see(-infinity, walk.s(0));  // a local maximum ends there
      continue;
    }
    const Cubic value = walk.value();
    size = std::max({size, std::abs(walk.grid.low()), std::abs(walk.grid.high())});
    const MonotoneEnds ends = monotone_ends(value);
    for (std::size_t i = 0; i <= ends.parts; ++i)
      greatest.see(sign * evaluate(value, ends.u[i]), walk.s(ends.u[i]));
    const double part = walk.s(1) - walk.s(0);
    integral += part * (value[0] + value[1] + value[2] + value[3]) / 4;
    length += part;
  }
  RayPicture result;
  result.cells = walk.cells;
  if (!(greatest.value > -infinity)) return result;
  const double found = mode == Mode::mean ? integral / length : sign * greatest.value;
  const double value = std::abs(found) < medium.least_value ? 0 : found;
  const double attenuation = medium.transfer ? medium.transfer->at(value).attenuation : value;
  if (!(attenuation > 0)) return result;
  result.radiance = shown(medium, found);
  result.opacity = 1;
  if (mode != Mode::mean) result.depth = walk.t_middle + greatest.s;
  const double off = 16 * epsilon * size;
  result.error = max_component(glm::max(glm::abs(shown(medium, found + off) - result.radiance),
                                        glm::abs(shown(medium, found - off) - result.radiance)));
  return result;
}

RayPicture RayModes::surface(const WorldRay& ray) {
  const Medium& medium = view_->medium;
  RayPicture result;
  std::vector<bool> below;
  double through = 1;
  DensityWalk walk(*medium_, *cache_, ray, part_);
  for (; !walk.done() && through > 0; walk.next()) {
    if (walk.grid.absent()) {
      below.clear();
      continue;
    }
    const Cubic value = walk.value();
    const IndexRay colors =
        colors_ ? make_index_ray(*medium.luminance, ray, walk.t_middle, -infinity, infinity)
                : IndexRay();
    for (const Passage& passage : passages(value, medium.surfaces, below)) {
      const auto& [isovalue, color, opacity] = *passage.surface;
      const auto lit_at = [&, own = color](double v) {
        const double s = walk.s(std::clamp(v, 0.0, 1.0));
        const glm::dvec3 L =
            colors_ ? own * luminance_at(*colors_, *medium.luminance, colors, s) : own;
        if (!walk.grid.in_cell()) return 0.2 * L;
        const glm::dvec3 g = gradient(*cache_, medium.density->domain(), walk.grid.ray(), s);
        return L * shade(*view_, g, ray.direction, passage.rises);
      };
      const glm::dvec3 light = lit_at(passage.u);
      const double weight = through * opacity;
      result.radiance += weight * light;
      // The root is off by the value's rounding over its slope. The normal is off by its turn over
      // that distance.
      const double rounding =
          16 * epsilon *
          std::max({std::abs(walk.grid.low()), std::abs(walk.grid.high()), std::abs(isovalue)});
      const double step = 1e-6;
      const double slope = std::abs(evaluate(value, std::min(1.0, passage.u + step)) -
                                    evaluate(value, std::max(0.0, passage.u - step))) /
                           (2 * step);
      const double off = slope > 0 ? std::min(1.0, rounding / slope) : 1.0;
      result.error += weight * (max_component(glm::max(glm::abs(lit_at(passage.u + off) - light),
                                                       glm::abs(lit_at(passage.u - off) - light))) +
                                64 * epsilon * max_component(glm::abs(color)) *
                                    std::max(1.0, max_component(light)));
      through -= weight;
      if (through < 0.5 && result.depth == infinity)
        result.depth = walk.t_middle + walk.s(passage.u);
      if (!(through > 0)) break;
    }
  }
  result.opacity = 1 - through;
  result.cells = walk.cells;
  return result;
}

}  // namespace psivox
