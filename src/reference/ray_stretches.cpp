#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "cell_walk.h"
#include "ray_radiance.h"

namespace psivox {
namespace {

void move_on(std::optional<GridWalk>& walk, double s, double& end) {
  if (!walk) return;
  walk->reach(s);
  end = std::min(end, walk->end());
}

double largest_attenuation(const Medium& medium, const GridWalk& density,
                           const std::optional<GridWalk>& gradient) {
  if (!density.in_domain()) return 0;
  if (!medium.transfer) return std::max(density.high(), 0.0);
  const glm::dvec2 gradients =
      gradient ? glm::dvec2(gradient->low(), gradient->high()) : glm::dvec2();
  return medium.transfer->max_attenuation(glm::dvec2(density.low(), density.high()), gradients);
}

/// Error of the optical depth from the rounded position of the domain's faces, if there is medium
/// next to them.
double face_error(const Medium& medium, const IndexRay& ray) {
  if (!medium.transfer || !ray.hits()) return 0;
  const double tau =
      medium.extinction * medium.transfer->max_attenuation(glm::dvec2(0), glm::dvec2(0, infinity));
  const double slowest = max_component(glm::abs(ray.D));
  return 4 * epsilon * tau * extent(*medium.density) / std::max(slowest, 1e-300);
}

}  // namespace

struct RayIntegrator::Stretches {
  std::optional<GridWalk> density, luminance, emission, gradient;
  glm::dvec3 color{1};  ///< factor of the luminance along this ray
};

/// Sets parts_ to the parts of the density's values from a to b.
void RayIntegrator::classify_stretch(const Stretches& at, double a, double b) {
  const TransferFunction* function = medium_->medium.transfer.get();
  const Cubic value = at.density->along(a, b);
  if (at.gradient)
    classify(*function, value, at.gradient->along(a, b), parts_);
  else
    classify(function, value, parts_);
}

/// Reads the luminance of another grid and the emission along [a,b], then cuts them with the
/// density's parts.
void RayIntegrator::add_stretch(const Stretches& at, double a, double b, RaySum& sum) {
  const Medium& medium = medium_->medium;
  const bool glows = at.emission && at.emission->in_cell() && !at.emission->all_zero();
  const bool attenuates = largest_attenuation(medium, *at.density, at.gradient) > 0;
  if (!glows && !attenuates) return;

  Piece whole;
  whole.channels = 3;
  whole.glows = glows;
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (at.luminance)
      whole.L[i] =
          scaled(at.luminance->along(a, b, medium_->luminance->field().channels == 3 ? c : 0),
                 at.color[c]);
    if (glows)
      whole.glow[i] = scaled(at.emission->along(a, b, medium.emission->channels == 3 ? c : 0),
                             medium.emission_scale * (b - a));
  }
  const Cubic value = at.density->along(a, b);
  for (int c = 0; c < 3; ++c) {
    Cubic& L = whole.L[static_cast<std::size_t>(c)];
    if (medium.source == LuminanceSource::density) L = scaled(value, at.color[c]);
    if (medium.source == LuminanceSource::constant) L = constant_cubic(at.color[c]);
  }
  if (glows) {
    const IndexRay& ray = at.emission->ray();
    whole.glow_share = (b - a) / (ray.s_end - ray.s_begin);
  }
  if (!attenuates) {
    sum.add(whole, accuracy_);
    return;
  }

  classify_stretch(at, a, b);
  for (const ClassifiedPart& p : parts_) {
    const double u = p.end - p.begin;
    Piece piece = whole;
    if (u < 1) {
      for (std::size_t c = 0; c < 3; ++c) {
        piece.L[c] = part(whole.L[c], p.begin, p.end);
        if (glows) piece.glow[c] = scaled(part(whole.glow[c], p.begin, p.end), u);
      }
      piece.glow_share *= u;
    }
    if (medium.source == LuminanceSource::transfer) {
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        piece.L[i] = scaled(p.color[i], at.color[c]);
      }
      piece.L_error = p.color_error * max_component(glm::abs(at.color));
    }
    const double x = medium.extinction * (b - a) * u;
    piece.x = scaled(p.attenuation, x);
    piece.x_error = p.attenuation_error * x;
    sum.add(piece, accuracy_);
  }
}

RayRadiance RayIntegrator::radiance_by_stretches(const WorldRay& ray, double t0, double t1) {
  const Medium& medium = medium_->medium;
  assert(medium.source != LuminanceSource::transfer || medium.transfer);
  const double t_middle = nearest_to_middle(*medium.density, ray);
  Stretches at;
  at.color = medium.color * phase_factor(medium, ray.direction);
  at.density.emplace(medium_->density, density_cache_,
                     make_index_ray(*medium.density, ray, t_middle, t0, t1));
  double begin = infinity, end = -infinity;
  auto span = [&](const IndexRay& r) {
    if (!r.hits()) return;
    begin = std::min(begin, r.s_begin);
    end = std::max(end, r.s_end);
  };
  span(at.density->ray());
  if (medium_->gradient)
    at.gradient.emplace(*medium_->gradient, *gradient_cache_, at.density->ray());
  if (medium_->luminance)
    at.luminance.emplace(*medium_->luminance, *luminance_cache_,
                         make_index_ray(*medium.luminance, ray, t_middle, t0, t1));
  if (medium_->emission) {
    at.emission.emplace(*medium_->emission, *emission_cache_,
                        make_index_ray(*medium.emission, ray, t_middle, t0, t1));
    span(at.emission->ray());
  }

  RaySum sum;
  sum.depth_error = face_error(medium, at.density->ray());
  bool stopped = false;
  double counted = -infinity;
  for (double s = begin; s < end && !stopped;) {
    double to = end;
    move_on(at.density, s, to);
    move_on(at.luminance, s, to);
    move_on(at.emission, s, to);
    move_on(at.gradient, s, to);
    if (at.density->in_cell() && !at.density->all_zero() && at.density->begin() > counted) {
      counted = at.density->begin();
      ++sum.cells;
    }
    add_stretch(at, s, to, sum);
    stopped = sum.T <= accuracy_.T_stop;
    s = to;
  }

  const double extents = extent(*medium.density) +
                         (medium_->luminance ? extent(*medium.luminance) : 0) +
                         (medium_->emission ? extent(*medium.emission) : 0);
  return {sum.radiance + medium.ambient * sum.opacity(), sum.optical_depth,
          sum.error + sum.rounding(extents) +
              max_component(medium.ambient) * sum.opacity_rounding(extents) +
              (stopped ? sum.T * medium_->behind_max : 0),
          sum.cells};
}

RayDepth RayIntegrator::depth_by_stretches(const WorldRay& ray, double t0, double t1) {
  const Medium& medium = medium_->medium;
  const double t_middle = nearest_to_middle(*medium.density, ray);
  Stretches at;
  at.density.emplace(medium_->density, density_cache_,
                     make_index_ray(*medium.density, ray, t_middle, t0, t1));
  if (medium_->gradient)
    at.gradient.emplace(*medium_->gradient, *gradient_cache_, at.density->ray());
  RayDepth result;
  double sum = 0, error = 0, counted = -infinity;
  std::uint64_t terms = 0;
  const IndexRay& index_ray = at.density->ray();
  for (double s = index_ray.s_begin; s < index_ray.s_end;) {
    double to = index_ray.s_end;
    move_on(at.density, s, to);
    move_on(at.gradient, s, to);
    const double from = s;
    s = to;
    if (at.density->begin() > counted) {
      counted = at.density->begin();
      result.cells += at.density->in_cell() && !at.density->all_zero();
    }
    if (!(largest_attenuation(medium, *at.density, at.gradient) > 0)) continue;
    classify_stretch(at, from, to);
    for (const ClassifiedPart& p : parts_) {
      sum += mean(p.attenuation) * (p.end - p.begin) * (to - from);
      error += p.attenuation_error * (p.end - p.begin) * (to - from);
      ++terms;
    }
  }
  result.depth = medium.extinction * sum;
  result.error =
      medium.extinction * error + face_error(medium, index_ray) +
      (16 + static_cast<double>(terms) + extent(*medium.density)) * epsilon * result.depth;
  return result;
}

}  // namespace psivox
