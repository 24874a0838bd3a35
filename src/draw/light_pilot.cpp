#include "draw/light_pilot.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "field/field_index.h"
#include "plan/pilot.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr std::size_t points_per_ray = 16;

/// Rays of the picture that are looked at, about. Where the errors of n voxels average along a ray,
/// the points' noise makes the mean square uncertain by sqrt(2) n / 16 / sqrt(400): a quarter of it
/// for 50 voxels. Of small pictures one ray in 28 will do, 144 at least.
constexpr double most_light_rays = 400, some_light_rays = 144, fewest_light_rays = 64;
/// Rays from which those are drawn, so that a small opaque thing is among them. Many beams' light
/// at the points costs far more than these rays.
constexpr double drawn_from = 576, drawn_for_many = 2304;
constexpr double many_beams = 16;

/// Numbers from 0 to 1, the same ones each time.
class Uniform {
 public:
  double operator()() { return double(random_()) / 4294967296.0; }

 private:
  std::mt19937 random_{1};
};

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

/// The blocks that hold some voxels, each once.
std::vector<glm::ivec3> blocks_with(std::span<const glm::ivec3> voxels) {
  std::vector<glm::ivec3> blocks;
  for (const glm::ivec3& voxel : voxels) blocks.push_back(voxel & ~7);
  std::ranges::sort(blocks, comes_before);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

/// Luminance at a voxel, or its factor, where this process knows it.
struct Known {
  glm::dvec3 light{0};
  bool known = false;
};

/// That of all voxels, which the members of a team know together.
std::vector<glm::dvec3> known(const std::vector<Known>& own, const LightShare& share) {
  std::vector<glm::dvec3> light(own.size());
  for (const std::vector<Known>& some : share.team->gather(own))
    for (std::size_t i = 0; i < light.size(); ++i)
      if (some[i].known) light[i] = some[i].light;
  return light;
}

}  // namespace

LightError sum(const LightError& a, const LightError& b) {
  return {std::hypot(a.rms, b.rms), a.max + b.max};
}

BeamsOn beams_of(const std::vector<Beam>& beams) {
  return [&beams](const View& seen, std::size_t volume) { return beams_on(seen, volume, beams); };
}

BeamsOn sky_of(int count) {
  return [count](const View& seen, std::size_t) { return sky_beams(seen, count); };
}

void set_method(std::vector<Beam>& beams, const LightMethod& method) {
  for (Beam& beam : beams) beam.method = method;
}

struct LightPilot::Volume {
  struct Ray {
    std::size_t first = 0;  ///< of its points
    double opacity = 0;
    glm::dvec3 direction{0};
  };

  Volume(View view, std::size_t volume, const MediumDepths& depths, const BeamsOn& beams);

  /// Draws about `wanted_rays` from so many, and places points on each.
  void place_points(double wanted_rays, double from);
  std::vector<glm::dvec3> exact_light(const LitLuminance& luminance) const;
  /// Of the light at the voxels, and the factor of each ray that is in it.
  LightError error(const std::vector<glm::dvec3>& light, const auto& phase) const;
  LightError error(const Medium& lit) const;

  View view;
  std::size_t number;
  const MediumDepths& depths;
  std::vector<std::vector<Crossed>> cells{};  ///< of the rays that were looked along
  std::vector<Ray> rays{};                    ///< drawn from these
  double coverage = 0;
  std::vector<glm::ivec3> voxels{};  ///< points_per_ray of each ray
  std::vector<glm::dvec3> tints{};   ///< factor of the light there, if the function gives colours
  std::vector<glm::dvec3> truth{};   ///< luminance there
};

LightPilot::Volume::Volume(View from, std::size_t volume, const MediumDepths& medium_depths,
                           const BeamsOn& beams)
    : view(std::move(from)), number(volume), depths(medium_depths) {
  const LitLuminance luminance(view, beams(view, volume));
  // the errors of many beams average
  const auto count = double(luminance.beams().size());
  const double pixels = double(view.scene.resolution.x) * view.scene.resolution.y;
  place_points(std::max(std::clamp(pixels / 28, some_light_rays, most_light_rays) / count,
                        fewest_light_rays),
               count < many_beams ? drawn_from : drawn_for_many);
  truth = exact_light(luminance);
}

void LightPilot::Volume::place_points(double wanted_rays, double from) {
  Uniform uniform;
  View small = view;
  const glm::ivec2 size = rays_over(view.scene.resolution, std::max(from, wanted_rays));
  small.scene.resolution = size;
  // one ray, at a random place, of each part of the picture
  std::vector<glm::dvec2> places;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const double v = y + uniform(), u = x + uniform();
      places.emplace_back(u, v);
    }
  cells = depths.crossed(number, small, places);

  std::vector<double> weights;
  double all = 0, hits = 0;
  for (const std::vector<Crossed>& crossed : cells) {
    weights.push_back(std::pow(opacity_of(crossed), 2));
    all += weights.back();
    hits += weights.back() > 0;
  }
  if (!(all > 0)) return;
  const double share = hits / double(weights.size());
  const double count = std::min(hits, std::max(std::ceil(wanted_rays * share), fewest_light_rays));
  coverage = all / double(weights.size());

  const Field& density = *view.medium.density;
  const FieldIndex values(density);
  const glm::dmat4 to_index = glm::inverse(density.world_from_index);
  std::vector<Known> own_tints;
  const double apart = all / count;
  double next = apart * uniform(), sum = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    sum += weights[n];
    if (!(sum > next)) continue;
    const WorldRay ray = camera_ray(view.camera, size, places[n].x, places[n].y);
    const double opacity = opacity_of(cells[n]);
    for (; sum > next; next += apart) {
      rays.push_back({voxels.size(), opacity, ray.direction});
      for (std::size_t i = 0; i < points_per_ray; ++i) {
        const double wanted = (double(i) + uniform()) / points_per_ray * opacity;
        const glm::dvec3 point(
            to_index * glm::dvec4(ray.origin + place_of(cells[n], wanted) * ray.direction, 1));
        if (view.medium.source == LuminanceSource::transfer) {
          const glm::ivec3 nearest = nearest_voxel(point);
          const double value = view.medium.nearest ? values.at(nearest).x : values.at(point).x;
          const glm::dvec3 color =
              std::isnan(value) ? glm::dvec3(0) : view.medium.transfer->at(value).color;
          own_tints.push_back({color, depths.share().voxels.contains(nearest)});
        }
        // one of the cell's corners, each as often as its weight: the mean is the interpolation
        const double z = uniform(), y = uniform(), x = uniform();
        const Box domain = density.domain();
        voxels.push_back(glm::clamp(glm::ivec3(glm::floor(point + glm::dvec3(x, y, z))), domain.min,
                                    domain.max));
      }
    }
  }
  tints = known(own_tints, depths.share());
}

std::vector<glm::dvec3> LightPilot::Volume::exact_light(const LitLuminance& luminance) const {
  // what no float32 has beside the beam
  const double no_more = transmittance_of(0x1p-24, view.scene.scatter_octaves);
  const ExactDepths exact_depths = depths.exact(view, number);
  std::vector<Known> light;
  for (const glm::ivec3& voxel : voxels)
    light.push_back({luminance.own(voxel), depths.share().voxels.contains(voxel)});
  for (std::size_t b = 0; b < luminance.beams().size(); ++b) {
    Beam exact = luminance.beams()[b];
    exact.method = {.termination = no_more};
    const std::vector<double> found = exact_depths(exact, voxels);
    for (std::size_t i = 0; i < voxels.size(); ++i)
      if (light[i].known) light[i].light += luminance.share(b, voxels[i], found[i]);
  }
  return known(light, depths.share());
}

LightError LightPilot::Volume::error(const Medium& lit) const {
  const FieldIndex field(*lit.luminance);
  std::vector<Known> light;
  for (const Ray& ray : rays) {
    const glm::dvec3 factor = lit.color * phase_factor(lit, ray.direction);
    for (std::size_t i = ray.first; i < ray.first + points_per_ray; ++i) {
      const glm::dvec3 value = field.at(voxels[i]);
      // beside its own part a process has some of the light, and no other value for it
      const bool has = !depths.share().together() || field.stores(voxels[i]);
      light.push_back({factor * (lit.luminance->channels == 3 ? value : glm::dvec3(value.x)), has});
    }
  }
  return error(known(light, depths.share()),
               [&](const Ray& ray) { return phase_factor(lit, ray.direction); });
}

LightError LightPilot::Volume::error(const std::vector<glm::dvec3>& light,
                                     const auto& phase) const {
  double sum = 0, sum_of_squares = 0, max = 0;
  for (const Ray& ray : rays) {
    const double factor = phase(ray);
    // The mean over pairs of different points is the square of the mean error, free of the points'
    // own noise.
    glm::dvec3 total(0), squares(0);
    for (std::size_t i = ray.first; i < ray.first + points_per_ray; ++i) {
      glm::dvec3 off = light[i] - factor * truth[i];
      if (!tints.empty()) off *= tints[i];
      total += off;
      squares += off * off;
    }
    constexpr double pairs = double(points_per_ray * (points_per_ray - 1));
    const glm::dvec3 square = (total * total - squares) / pairs;
    const double share = coverage / double(rays.size()) * (square.x + square.y + square.z);
    sum += share;
    sum_of_squares += share * share;
    const glm::dvec3 mean = glm::abs(total) * (ray.opacity / double(points_per_ray));
    max = std::max({max, mean.x, mean.y, mean.z});
  }
  // the mean and its standard error: a sample that happens to miss little proves little
  const double squares = std::max(sum, 0.0) + std::sqrt(sum_of_squares);
  return {std::sqrt(squares / 4), max};
}

LightPilot::LightPilot(const View& view, const MediumDepths& depths, BeamsOn beams)
    : depths_(depths), beams_(std::move(beams)) {
  for (std::size_t i = 0; i < depths.volumes(); ++i)
    if (is_to_be_lit(view, i))
      volumes_.push_back(std::make_unique<Volume>(seen_from(view, i), i, depths, beams_));
}

LightPilot::~LightPilot() = default;

LightError LightPilot::error(const Medium& lit) const {
  return sum_of([&](const Volume& volume) {
    return volume.error(volume.number == 0 ? lit : lit.others[volume.number - 1]);
  });
}

LightError LightPilot::error(const BeamsOn& beams) const {
  return sum_of([&](const Volume& volume) {
    const LitLuminance luminance(volume.view, beams(volume.view, volume.number));
    return volume.error(volume.exact_light(luminance), [](const auto&) { return 1.0; });
  });
}

LightError LightPilot::error(const LightPilot& other) const {
  std::size_t i = 0;
  return sum_of([&](const Volume& volume) {
    return volume.error(other.volumes_[i++]->truth, [](const auto&) { return 1.0; });
  });
}

LightError LightPilot::error(const LightMethod& method) const {
  return sum_of([&](const Volume& volume) {
    std::vector<Beam> beams = beams_(volume.view, volume.number);
    set_method(beams, method);
    return volume.error(LitLuminance(volume.view, beams)
                            .medium(blocks_with(volume.voxels), depths_.at(volume.number)));
  });
}

double LightPilot::coverage() const {
  double sum = 0;
  for (const auto& volume : volumes_) sum += volume->coverage;
  return sum;
}

double LightPilot::transmittance(double light) const {
  return transmittance_of(light, volumes_.front()->view.scene.scatter_octaves);
}

double LightPilot::mean_cells(double termination) const {
  // A ray from a voxel towards a light is taken for one towards the camera that has evenly as many
  // voxels as it crosses cells. A run of one value counts by its length.
  const Volume& first = *volumes_.front();
  const double stop = -std::log(termination), voxel = finest_voxel(*first.view.medium.density);
  double sum = 0, weight = 0;
  for (const std::vector<Crossed>& cells : first.cells) {
    double count = 0, depth = 0;
    for (const Crossed& cell : cells) {
      count += std::max(1.0, (cell.back - cell.front) / voxel);
      depth += cell.depth;
    }
    const double seen = depth > stop ? stop / depth : 1;
    sum += count * count * (seen - seen * seen / 2);
    weight += count;
  }
  return weight > 0 ? sum / weight : 1;
}

LightError LightPilot::sum_of(const std::function<LightError(const Volume& volume)>& error) const {
  LightError sum;
  for (const auto& volume : volumes_) {
    const LightError own = error(*volume);
    sum = {sum.rms + own.rms, std::max(sum.max, own.max)};
  }
  return sum;
}

}  // namespace psivox
