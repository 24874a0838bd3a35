#include "ray_radiance.h"

#include <cassert>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <list>

#include "field/value_range.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

std::optional<FieldIndex> index_of(const std::shared_ptr<const Field>& field) {
  if (!field) return std::nullopt;
  return FieldIndex(*field);
}

/// Upper bound on the length of a path through a field's domain [world units].
double longest_way(const Field& field) {
  const glm::dvec3 size = glm::dvec3(field.domain().max) - glm::dvec3(field.domain().min);
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += glm::length(glm::dvec3(field.world_from_index[i])) * size[i];
  return sum;
}

/// Largest magnitude of a value in any channel.
double max_magnitude(const Field& field) {
  const glm::dvec2 range = range_of_all(field);
  return std::max(-range.x, range.y);
}

double largest_attenuation(const Medium& medium, const GridWalk& density,
                           const std::optional<GridWalk>& gradient) {
  if (!density.in_domain() || density.absent()) return 0;
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

bool emits(const GridWalk& emission) { return emission.in_cell() && !emission.all_zero(); }

/// Of all grids along which a ray goes.
double extents_of(const Medium& medium) {
  double sum = extent(*medium.density);
  if (medium.luminance) sum += extent(*medium.luminance);
  for (const Emission& emission : medium.emission) sum += extent(*emission.field);
  for (const Medium& other : medium.others) sum += extents_of(other);
  return sum;
}

}  // namespace

RayMedium::RayMedium(const Medium& m)
    : medium(m),
      density(*medium.density),
      luminance(index_of(medium.luminance)),
      gradient(index_of(medium.gradient)) {
  double L_max = max_component(glm::abs(medium.color));
  if (luminance)
    L_max *= max_magnitude(*medium.luminance);
  else if (medium.source == LuminanceSource::density)
    L_max *= max_magnitude(*medium.density);
  if (medium.source == LuminanceSource::transfer || medium.lit_colors)
    L_max *= max_component(medium.transfer->max_color(-infinity, infinity));
  const double g = std::abs(medium.phase_g);
  L_max *= (1 + g) / ((1 - g) * (1 - g));  // the greatest value of the phase function
  behind_max = L_max + max_component(medium.ambient);
  for (const auto& [field, scale, _] : medium.emission) {
    emission.emplace_back(*field);
    behind_max += std::abs(scale) * max_magnitude(*field) * longest_way(*field);
  }
  for (const Medium& other : m.others) {
    others.emplace_back(other);
    behind_max += others.back().behind_max;
  }
}

// The rounding of any sum hides a transparency below 1e-21; near 1e-308 it has no digits itself.
RayIntegrator::RayIntegrator(const RayMedium& medium, double tolerance)
    : medium_(&medium),
      accuracy_{tolerance, std::max(tolerance, 1e-20) / (10 * std::max(1.0, medium.behind_max))},
      density_cache_(medium.density) {
  if (medium.luminance) luminance_cache_.emplace(*medium.luminance);
  if (medium.gradient) gradient_cache_.emplace(*medium.gradient);
  for (const FieldIndex& emission : medium.emission) emission_caches_.emplace_back(emission);
  for (const RayMedium& other : medium.others) {
    others_.emplace_back(other, tolerance);
    others_.back().color_at_end_ = false;
    others_.back().channels_ = 3;
  }
  const Medium& m = medium.medium;
  color_at_end_ = !m.transfer && m.emission.empty() && m.others.empty();
  if (!color_at_end_) return;
  channels_ = m.source == LuminanceSource::constant ? 0 : m.luminance ? m.luminance->channels : 1;
  accuracy_.tolerance /= std::max(max_component(glm::abs(m.color)), 1e-300);
}

struct RayIntegrator::Stretches {
  std::optional<GridWalk> density, luminance, gradient;
  std::list<GridWalk> emission;
  glm::dvec3 color{1};          ///< factor of the luminance along this ray
  glm::dvec3 more{0};           ///< added to it, of a further volume
  std::list<Stretches> others;  ///< of further volumes
  double entered = -infinity;   ///< where the density's last cell began

  /// Whether the density has a new cell, which is not all 0.
  bool enters_cell() {
    if (!(density->begin() > entered)) return false;
    entered = density->begin();
    return density->in_cell() && !density->all_zero();
  }

  /// Moves all walks to s; `end` becomes where the first of them leaves a cell.
  void move_on(double s, double& end) {
    const auto move = [&](GridWalk& walk) {
      walk.reach(s);
      end = std::min(end, walk.end());
    };
    for (std::optional<GridWalk>* const walk : {&density, &luminance, &gradient})
      if (*walk) move(**walk);
    for (GridWalk& walk : emission) move(walk);
    for (Stretches& other : others) other.move_on(s, end);
  }

  /// The part of the ray in any of the volumes.
  void span(double& begin, double& end) const {
    const auto add = [&](const IndexRay& ray) {
      if (!ray.hits()) return;
      begin = std::min(begin, ray.s_begin);
      end = std::max(end, ray.s_end);
    };
    add(density->ray());
    for (const GridWalk& walk : emission) add(walk.ray());
    for (const Stretches& other : others) other.span(begin, end);
  }

  bool glows() const { return std::ranges::any_of(emission, emits); }
};

void RayIntegrator::begin(const WorldRay& ray, double t_middle, double t0, double t1,
                          Stretches& at) {
  const Medium& medium = medium_->medium;
  if (!color_at_end_) at.color = medium.color * phase_factor(medium, ray.direction);
  const auto in = [&](const Field& field, bool nearest = false) {
    return make_index_ray(field, ray, t_middle, t0, t1, nearest);
  };
  at.density.emplace(density_cache_, in(*medium.density, medium.nearest), medium.nearest);
  if (medium_->gradient) at.gradient.emplace(*gradient_cache_, at.density->ray(), medium.nearest);
  if (const bool nearest = medium.nearest && medium.lit; medium_->luminance)
    at.luminance.emplace(*luminance_cache_, in(*medium.luminance, nearest), nearest);
  for (std::size_t i = 0; i < emission_caches_.size(); ++i)
    at.emission.emplace_back(emission_caches_[i], in(*medium.emission[i].field));
  for (RayIntegrator& other : others_) {
    Stretches& own = at.others.emplace_back();
    other.begin(ray, t_middle, t0, t1, own);
    own.more = other.medium_->medium.ambient - medium.ambient;
  }
}

/// Sets parts_ to the parts of the density's values from a to b.
void RayIntegrator::classify_stretch(const Stretches& at, double a, double b, const Cubic& value) {
  const TransferFunction& function = *medium_->medium.transfer;
  if (at.gradient)
    classify(function, value, at.gradient->along(a, b), parts_);
  else
    classify(function, value, parts_);
}

/// Reads the luminance and the emission along [a,b], where the density has that value.
void RayIntegrator::read_stretch(const Stretches& at, double a, double b, const Cubic& value,
                                 Piece& piece) const {
  const Medium& medium = medium_->medium;
  piece.channels = channels_;
  for (int c = 0; c < channels_; ++c) {
    Cubic& L = piece.L[std::size_t(c)];
    if (at.luminance)
      L = scaled(at.luminance->along(a, b, medium.luminance->channels == 3 ? c : 0), at.color[c]);
    if (medium.source == LuminanceSource::density) L = scaled(value, at.color[c]);
    if (medium.source == LuminanceSource::constant) L = constant_cubic(at.color[c]);
  }
  for (std::size_t i = 0; const GridWalk& walk : at.emission) {
    const auto& [field, scale, _] = medium.emission[i++];
    if (!emits(walk)) continue;
    for (int c = 0; c < channels_; ++c)
      add_cubic(piece.glow[std::size_t(c)],
                scaled(walk.along(a, b, field->channels == 3 ? c : 0), scale * (b - a)));
    const double way = walk.ray().s_end - walk.ray().s_begin;
    const double share = (b - a) / way / double(at.emission.size());
    piece.glow_share = piece.glows ? std::min(piece.glow_share, share) : share;
    piece.glows = true;
  }
}

/// Adds the volumes along [a,b], of which none has a function.
void RayIntegrator::add_volumes(const Stretches& at, double a, double b, RaySum& sum) const {
  Piece all;
  all.channels = 3;
  all.glow_share = 1;
  const auto add = [&](const RayIntegrator& volume, const Stretches& own) {
    Piece piece;
    const Cubic value = own.density->along(a, b);
    volume.read_stretch(own, a, b, value, piece);
    for (std::size_t c = 0; c < 3 && piece.glows; ++c) add_cubic(all.glow[c], piece.glow[c]);
    if (piece.glows)  // several may glow
      all.glow_share = std::min(all.glow_share, piece.glow_share / double(1 + others_.size()));
    all.glows = all.glows || piece.glows;
    const Medium& medium = volume.medium_->medium;
    if (!(largest_attenuation(medium, *own.density, own.gradient) > 0)) return;
    Source source{scaled(value, medium.extinction * (b - a)), piece.L};
    for (std::size_t k = 0; k < 4; ++k) {
      all.x[k] += source.x[k];
      for (int c = 0; c < 3; ++c) source.L[std::size_t(c)][k] += own.more[c];
    }
    all.sources.push_back(source);
  };
  add(*this, at);
  auto volume = others_.begin();
  for (const Stretches& own : at.others) add(*volume++, own);
  if (all.glows || !all.sources.empty()) sum.add(all, accuracy_);
}

/// Reads the luminance of another grid and the emission along [a,b], then cuts them with the
/// density's parts.
void RayIntegrator::add_stretch(const Stretches& at, double a, double b, RaySum& sum) {
  if (!others_.empty()) return add_volumes(at, a, b, sum);
  const Medium& medium = medium_->medium;
  const bool glows = at.glows();
  const bool attenuates = largest_attenuation(medium, *at.density, at.gradient) > 0;
  if (!glows && !attenuates) return;

  const double x = medium.extinction * (b - a);
  const Cubic value = at.density->along(a, b);
  if (channels_ == 0) return sum.pass(x * mean(value));
  Piece whole;
  read_stretch(at, a, b, value, whole);
  if (!attenuates || !medium.transfer) {
    if (attenuates) whole.x = scaled(value, x);
    return sum.add(whole, accuracy_);
  }

  classify_stretch(at, a, b, value);
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
      for (int c = 0; c < 3; ++c)
        piece.L[std::size_t(c)] = scaled(p.color[std::size_t(c)], at.color[c]);
      piece.L_error = p.color_error * max_component(glm::abs(at.color));
    }
    if (medium.lit_colors) {
      double L_max = 0;
      for (const Cubic& L : piece.L) L_max = std::max(L_max, max_magnitude(L));
      piece.tint = p.color;
      piece.L_error = p.color_error * L_max;
    }
    piece.x = scaled(p.attenuation, x * u);
    piece.x_error = p.attenuation_error * (x * u);
    sum.add(piece, accuracy_);
  }
}

RayRadiance RayIntegrator::radiance(const WorldRay& ray, double t0, double t1) {
  const Medium& medium = medium_->medium;
  assert(medium.source != LuminanceSource::transfer || medium.transfer);
  const double t_middle = nearest_to_middle(*medium.density, ray);
  Stretches at;
  this->begin(ray, t_middle, t0, t1, at);
  double begin = infinity, end = -infinity;
  at.span(begin, end);

  RaySum sum;
  sum.depth_error = face_error(medium, at.density->ray());
  bool stopped = false;
  for (double s = begin, to; s < end && !stopped; s = to) {
    to = end;
    at.move_on(s, to);
    sum.cells += at.enters_cell();
    add_stretch(at, s, to, sum);
    stopped = sum.T <= accuracy_.T_stop;
  }

  if (color_at_end_) sum.multiply(channels_, medium.color * phase_factor(medium, ray.direction));
  const double extents = extents_of(medium);
  const double opacity_error = sum.opacity_rounding(extents);
  return {
      sum.radiance + medium.ambient * sum.opacity(), sum.optical_depth,
      std::max(sum.error + sum.rounding(extents) + max_component(medium.ambient) * opacity_error +
                   (stopped ? sum.T * medium_->behind_max : 0),
               opacity_error + (stopped ? sum.T : 0)),
      sum.cells};
}

RayRadiance RayIntegrator::whole_depth(const WorldRay& ray, double t0, double t1) {
  const Medium& medium = medium_->medium;
  const double t_middle = nearest_to_middle(*medium.density, ray);
  Stretches at;
  at.density.emplace(density_cache_,
                     make_index_ray(*medium.density, ray, t_middle, t0, t1, medium.nearest),
                     medium.nearest);
  if (medium_->gradient) at.gradient.emplace(*gradient_cache_, at.density->ray(), medium.nearest);
  RayRadiance result;
  double sum = 0, error = 0;
  std::uint64_t terms = 0;
  const IndexRay& index_ray = at.density->ray();
  for (double from = index_ray.s_begin, to; from < index_ray.s_end; from = to) {
    to = index_ray.s_end;
    at.move_on(from, to);
    result.cells += at.enters_cell();
    if (!(largest_attenuation(medium, *at.density, at.gradient) > 0)) continue;
    const Cubic value = at.density->along(from, to);
    if (!medium.transfer) {
      sum += mean(value) * (to - from);
      ++terms;
      continue;
    }
    classify_stretch(at, from, to, value);
    for (const ClassifiedPart& p : parts_) {
      sum += mean(p.attenuation) * (p.end - p.begin) * (to - from);
      error += p.attenuation_error * (p.end - p.begin) * (to - from);
      ++terms;
    }
  }
  result.optical_depth = medium.extinction * sum;
  result.error = medium.extinction * error + face_error(medium, index_ray) +
                 (16 + double(terms) + extent(*medium.density)) * epsilon * result.optical_depth;
  for (RayIntegrator& other : others_) {
    const RayRadiance more = other.whole_depth(ray, t0, t1);
    result.optical_depth += more.optical_depth;
    result.error += more.error;
    result.cells += more.cells;
  }
  return result;
}

}  // namespace psivox
