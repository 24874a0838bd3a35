#include "draw/light_pilot.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>
#include <random>

#include "field/field_index.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr std::size_t points_per_ray = 16;

/// Rays of the picture that are looked at, about. Where the errors of n voxels average along a ray,
/// the points' noise makes the mean square uncertain by sqrt(2) n / 16 / sqrt(400): a quarter of it
/// for 50 voxels. Of small pictures one ray in 28 will do, 144 at least.
constexpr double most_light_rays = 400, some_light_rays = 144, fewest_light_rays = 64;
/// Rays from which those are drawn.
constexpr double drawn_from = 576;

/// Numbers from 0 to 1, the same ones each time.
class Uniform {
 public:
  double operator()() { return double(random_()) / 4294967296.0; }

 private:
  std::mt19937 random_{1};
};

/// Columns and rows of about `count` rays of the picture.
glm::ivec2 rays_of(const glm::ivec2& picture, double count) {
  const glm::dvec2 size(picture);
  const double width = std::round(std::sqrt(count * size.x / size.y));
  return glm::clamp(glm::ivec2(int(width), int(count / width)), glm::ivec2(1), picture);
}

double opacity_of(const std::vector<Crossed>& cells) {
  double depth = 0;
  for (const Crossed& cell : cells) depth += cell.depth;
  return -std::expm1(-depth);
}

/// Where a ray has an opacity: a distance along it, in a cell that goes on evenly.
double place_of(const std::vector<Crossed>& cells, double opacity) {
  double left = -std::log1p(-opacity);
  for (const Crossed& cell : cells) {
    if (left <= cell.depth) return cell.front + (cell.back - cell.front) * left / cell.depth;
    left -= cell.depth;
  }
  return cells.back().back;
}

}  // namespace

LightError sum(const LightError& a, const LightError& b) {
  return {std::hypot(a.rms, b.rms), a.max + b.max};
}

LightDepths MediumDepths::at(std::size_t volume) const {
  if (volumes_) return volumes_->at(volume);
  if (volume == 0) return source_.depths(view_);
  return source_.depths(seen_from(view_, volume));  // the reference copies the view
}

ExactDepths MediumDepths::exact(const View& seen, std::size_t volume) const {
  if (!volumes_) return source_.exact_depths(seen);
  return [this, volume](const Beam& beam, std::span<const glm::ivec3> voxels) {
    return volumes_->exact(volume, beam, voxels);
  };
}

std::vector<std::vector<Crossed>> MediumDepths::crossed(std::size_t volume, const View& seen,
                                                        std::span<const glm::dvec2> places) const {
  if (volumes_) return crossed_cells(seen, volumes_->atlas(volume), places);
  return source_.crossed(seen, places);
}

BeamsOn beams_of(const std::vector<Beam>& beams) {
  return [&beams](const View& seen, std::size_t volume) { return beams_on(seen, volume, beams); };
}

BeamsOn sky_of(int count) {
  return [count](const View& seen, std::size_t) { return sky_beams(seen, count); };
}

VolumePilot::VolumePilot(View view, std::size_t volume, const MediumDepths& depths,
                         const BeamsOn& beams)
    : view_(std::move(view)),
      volume_(volume),
      depths_(depths),
      luminance_(view_, beams(view_, volume)) {
  // the errors of many beams average
  const auto count = double(luminance_.beams().size());
  const double pixels = double(view_.scene.resolution.x) * view_.scene.resolution.y;
  place_points(std::max(std::clamp(pixels / 28, some_light_rays, most_light_rays) / count,
                        fewest_light_rays));
  truth_ = exact_light(luminance_);
}

void VolumePilot::place_points(double rays) {
  Uniform uniform;
  View small = view_;
  const glm::ivec2 size = rays_of(view_.scene.resolution, std::max(drawn_from, rays));
  small.scene.resolution = size;
  // one ray, at a random place, of each part of the picture
  std::vector<glm::dvec2> places;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const double v = y + uniform(), u = x + uniform();
      places.emplace_back(u, v);
    }
  cells_ = depths_.crossed(volume_, small, places);

  std::vector<double> weights;
  for (const std::vector<Crossed>& cells : cells_)
    weights.push_back(std::pow(opacity_of(cells), 2));
  const auto hits = double(std::ranges::count_if(weights, [](double w) { return w > 0; }));
  const double count =
      std::min(hits, std::max(std::ceil(rays * hits / double(weights.size())), fewest_light_rays));
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0), apart = all / count;
  if (!(all > 0)) return;
  coverage_ = all / double(weights.size());

  const Field& density = *view_.medium.density;
  const FieldIndex values(density);
  const glm::dmat4 to_index = glm::inverse(density.world_from_index);
  std::vector<Known> tints;
  double next = apart * uniform(), sum = 0;
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    sum += weights[n];
    if (!(sum > next)) continue;
    const WorldRay ray = camera_ray(view_.camera, size, places[n].x, places[n].y);
    const double opacity = opacity_of(cells_[n]);
    for (; sum > next; next += apart) {
      rays_.push_back({voxels_.size(), opacity, ray.direction});
      for (std::size_t i = 0; i < points_per_ray; ++i) {
        const double wanted = (double(i) + uniform()) / points_per_ray * opacity;
        const glm::dvec3 point(
            to_index * glm::dvec4(ray.origin + place_of(cells_[n], wanted) * ray.direction, 1));
        if (view_.medium.source == LuminanceSource::transfer) {
          const glm::ivec3 nearest = nearest_voxel(point);
          const double value = view_.medium.nearest ? values.at(nearest).x : values.at(point).x;
          const glm::dvec3 color =
              std::isnan(value) ? glm::dvec3(0) : view_.medium.transfer->at(value).color;
          tints.push_back({color, depths_.share().voxels.contains(nearest)});
        }
        // one of the cell's corners, each as often as its weight: the mean is the interpolation
        const double z = uniform(), y = uniform(), x = uniform();
        const Box domain = density.domain();
        voxels_.push_back(glm::clamp(glm::ivec3(glm::floor(point + glm::dvec3(x, y, z))),
                                     domain.min, domain.max));
      }
    }
  }
  tints_ = known(tints);
}

std::vector<glm::dvec3> VolumePilot::exact_light(const LitLuminance& luminance) const {
  // what no float32 has beside the beam
  const double no_more = transmittance_of(0x1p-24, view_.scene.scatter_octaves);
  const Box& own = depths_.share().voxels;
  const ExactDepths exact_depths = depths_.exact(view_, volume_);
  std::vector<Known> light;
  light.reserve(voxels_.size());
  for (const glm::ivec3& voxel : voxels_)
    light.push_back(own.contains(voxel) ? Known{luminance.own(voxel), true} : Known{});
  for (std::size_t b = 0; b < luminance.beams().size(); ++b) {
    Beam exact = luminance.beams()[b];
    exact.method = {.termination = no_more};
    const std::vector<double> depths = exact_depths(exact, voxels_);
    for (std::size_t i = 0; i < voxels_.size(); ++i)
      if (light[i].known) light[i].light += luminance.share(b, voxels_[i], depths[i]);
  }
  return known(light);
}

std::vector<glm::dvec3> VolumePilot::known(const std::vector<Known>& own) const {
  std::vector<glm::dvec3> light(own.size());
  for (const std::vector<Known>& some : depths_.share().team->gather(own))
    for (std::size_t i = 0; i < light.size(); ++i)
      if (some[i].known) light[i] = some[i].light;
  return light;
}

double VolumePilot::mean_cells(double termination) const {
  // A ray from a voxel towards a light is taken for one towards the camera. A ray has as many
  // voxels as it crosses cells.
  const double stop = -std::log(termination);
  double sum = 0, weight = 0;
  Uniform uniform;
  const double voxel = finest_voxel(*view_.medium.density);
  for (const std::vector<Crossed>& cells : cells_) {
    const auto count = double(cells.size());
    double depth = 0;
    for (auto k = std::ptrdiff_t(uniform() * count); k >= 0 && depth < stop && count > 0; --k) {
      const Crossed& cell = cells[std::size_t(k)];
      // a run of one value counts by its length, as far as a ray sees in it
      const double seen = std::min(1.0, (stop - depth) / cell.depth);
      sum += count * std::max(1.0, seen * (cell.back - cell.front) / voxel);
      depth += cell.depth;
    }
    weight += count;
  }
  return weight > 0 ? sum / weight : 1;
}

LightError VolumePilot::error(const Medium& lit) const {
  const FieldIndex field(*lit.luminance);
  std::vector<Known> light;
  light.reserve(voxels_.size());
  for (const Ray& ray : rays_) {
    const glm::dvec3 factor = lit.color * phase_factor(lit, ray.direction);
    for (std::size_t i = ray.first; i < ray.first + points_per_ray; ++i) {
      const glm::dvec3 value = field.at(voxels_[i]);
      // beside its own part a process has some of the light, and no other value for it
      const bool has = !depths_.share().together() || field.stores(voxels_[i]);
      light.push_back({factor * (lit.luminance->channels == 3 ? value : glm::dvec3(value.x)), has});
    }
  }
  return error(known(light), [&](const Ray& ray) { return phase_factor(lit, ray.direction); });
}

LightError VolumePilot::error(const LitLuminance& luminance) const {
  return error(exact_light(luminance), [](const Ray&) { return 1.0; });
}

LightError VolumePilot::error(const std::vector<glm::dvec3>& light,
                              const std::function<double(const Ray&)>& phase) const {
  double sum = 0, sum_of_squares = 0, max = 0;
  for (const Ray& ray : rays_) {
    const double factor = phase(ray);
    // The mean over pairs of different points is the square of the mean error, free of the points'
    // own noise.
    glm::dvec3 total(0), squares(0);
    for (std::size_t i = ray.first; i < ray.first + points_per_ray; ++i) {
      glm::dvec3 off = light[i] - factor * truth_[i];
      if (!tints_.empty()) off *= tints_[i];
      total += off;
      squares += off * off;
    }
    constexpr double pairs = double(points_per_ray * (points_per_ray - 1));
    const glm::dvec3 square = (total * total - squares) / pairs;
    const double share = coverage_ / double(rays_.size()) * (square.x + square.y + square.z);
    sum += share;
    sum_of_squares += share * share;
    const glm::dvec3 mean = glm::abs(total) * (ray.opacity / double(points_per_ray));
    max = std::max({max, mean.x, mean.y, mean.z});
  }
  // the mean and its standard error: a sample that happens to miss little proves little
  const double squares = std::max(sum, 0.0) + std::sqrt(sum_of_squares);
  return {std::sqrt(squares / 4), max};
}

LightPilot::LightPilot(const View& view, const MediumDepths& depths, const BeamsOn& beams) {
  for (std::size_t i = 0; i < depths.volumes(); ++i) {
    volumes_.emplace_back();
    if (is_to_be_lit(view, i))
      volumes_.back() = std::make_unique<VolumePilot>(seen_from(view, i), i, depths, beams);
  }
}

LightError LightPilot::error(const Medium& lit) const {
  return sum_of([&](const VolumePilot& pilot, std::size_t i) {
    return pilot.error(i == 0 ? lit : lit.others[i - 1]);
  });
}

LightError LightPilot::error(const BeamsOn& beams) const {
  return sum_of([&](const VolumePilot& pilot, std::size_t i) {
    return pilot.error(LitLuminance(pilot.view(), beams(pilot.view(), i)));
  });
}

double LightPilot::coverage() const {
  double sum = 0;
  for (const auto& volume : volumes_)
    if (volume) sum += volume->coverage();
  return sum;
}

LightError LightPilot::sum_of(
    const std::function<LightError(const VolumePilot& pilot, std::size_t volume)>& error) const {
  LightError sum;
  for (std::size_t i = 0; i < volumes_.size(); ++i) {
    if (!volumes_[i]) continue;
    const LightError own = error(*volumes_[i], i);
    sum = {sum.rms + own.rms, std::max(sum.max, own.max)};
  }
  return sum;
}

}  // namespace psivox
