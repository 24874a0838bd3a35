#include "march/light_pilot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>
#include <optional>
#include <random>

#include "field/field_cursor.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr std::size_t points_per_ray = 16;

/// Rays of the picture that are looked at, about. Where the errors of n voxels average along a ray,
/// the points' noise makes the mean square uncertain by sqrt(2) n / 16 / sqrt(400): a quarter of it
/// for 50 voxels. Of small pictures one ray in 28 will do, 144 at least.
constexpr double most_light_rays = 400, some_light_rays = 144, fewest_light_rays = 64;
/// Rays from which those are drawn, and how many are looked along at once.
constexpr double drawn_from = 576;
constexpr std::size_t at_once = 64;

/// What lies behind this transmittance is not looked at.
constexpr double least_transmittance = 1e-6, most_depth = 14;

/// Points of index space along which to look, from the first on.
struct Line {
  glm::dvec3 first, step;
  double length = 0;  ///< of a step [world units]
  std::size_t points = 0;
};

/// A step that attenuates: the number of its line, the place of its middle and its width in steps
/// of the line, and its optical depth.
struct Met {
  std::uint32_t line;
  float width;
  double place, depth;
};

/// Above this optical depth of a step, the ray sees no farther than a part of it: it is divided, as
/// are those beside it, where the interpolated medium begins and ends.
constexpr double dense = 0.5;

/// Looks along lines, together with the other processes.
class Looks {
 public:
  Looks(const Medium& medium, const LightShare& share)
      : medium_(medium),
        density_(*medium.density),
        function_(without_colors(medium)),
        share_(share) {
    if (medium.gradient) gradient_.emplace(*medium.gradient);
    empty_is_clear_ = !function_ || function_->attenuation(0, 0) == 0;
  }

  /// The function's colour at a point, if this process has it.
  std::optional<glm::dvec3> color(const glm::dvec3& point) {
    if (!share_.voxels.contains(nearest_voxel(point))) return {};
    const double value = this->value(point);
    return std::isnan(value) ? glm::dvec3(0) : medium_.transfer->at(value).color;
  }

  /// What each line meets, up to an optical depth or farther.
  std::vector<std::vector<Met>> met(std::span<const Line> lines, double most) {
    std::vector<Met> own;
    for (std::size_t i = 0; i < lines.size(); ++i)
      look_along(lines[i], std::uint32_t(i), most, own);
    std::vector<std::vector<Met>> of_lines(lines.size());
    for (const std::vector<Met>& some : share_.of_all(own))
      for (const Met& point : some) of_lines[point.line].push_back(point);
    for (std::vector<Met>& line : of_lines) std::ranges::sort(line, std::less{}, &Met::place);
    return of_lines;
  }

 private:
  void look_along(const Line& line, std::uint32_t number, double most, std::vector<Met>& points) {
    double sum = 0, deepest = 0;
    std::size_t divided = 0;  // steps before this one are
    for (std::size_t k = 0; k < line.points && sum < most;) {
      const glm::dvec3 point = line.first + double(k) * line.step;
      const glm::ivec3 voxel = nearest_voxel(point);
      if (!share_.voxels.contains(voxel)) {
        ++k;
        continue;
      }
      const double depth = line.length * attenuation(voxel);
      if (depth > dense) {
        if (k > divided) {
          const bool known = !points.empty() && points.back().line == number &&
                             points.back().place == double(k - 1);
          if (known) {
            sum -= points.back().depth;
            points.pop_back();
          }
          deepest = depth;
          sum += divide(line, number, k - 1, deepest, points);
        }
        divided = k + 2;
        deepest = depth;
      }
      if (k < divided) {
        sum += divide(line, number, k++, deepest, points);
        continue;
      }
      if (depth > 0) points.push_back({number, 1, double(k), depth});
      sum += depth;
      const bool clear = depth == 0 && empty_is_clear_;
      const std::size_t skipped = clear ? density_.empty_steps(point, line.step) : 0;
      k += std::max<std::size_t>(skipped, 1);
    }
  }

  /// Looks along parts of a step, beside which the depth of a step is up to `deepest`. Returns its
  /// optical depth.
  double divide(const Line& line, std::uint32_t number, std::size_t k, double deepest,
                std::vector<Met>& points) {
    const glm::dvec3 middle = line.first + double(k) * line.step;
    if (!share_.voxels.contains(nearest_voxel(middle))) return 0;
    // where the medium begins the depth is deepest x^2 / 2: some parts to a depth of 1
    const int parts = std::clamp(int(std::ceil(6 * std::sqrt(deepest))), 4, 512);
    double sum = 0;
    for (int i = 0; i < parts; ++i) {
      const double place = double(k) - 0.5 + (i + 0.5) / parts;
      const double depth = line.length / parts * attenuation(line.first + place * line.step);
      if (depth > 0) points.push_back({number, 1 / float(parts), place, depth});
      sum += depth;
    }
    return sum;
  }

  /// At a voxel, or at a point of index space.
  template <typename Place>
  double value(const Place& place) {
    return medium_.nearest ? density_.at(nearest_voxel(glm::dvec3(place))) : density_.at(place);
  }

  template <typename Place>
  double attenuation(const Place& place) {
    const double value = this->value(place);
    if (std::isnan(value)) return 0;  // absent
    if (!function_) return medium_.extinction * value;
    const double slope = gradient_ ? gradient_->at(place) : 0;
    return medium_.extinction * function_->attenuation(value, slope);
  }

  const Medium& medium_;
  FieldCursor density_;
  std::shared_ptr<const TransferFunction> function_;
  std::optional<FieldCursor> gradient_;
  bool empty_is_clear_;
  const LightShare& share_;
};

/// The first voxels of about `count` of the blocks of 8^3 in a field's leaves and tiles.
std::vector<glm::ivec3> some_blocks(const Field& field, std::size_t count) {
  const auto across = [](const Tile& tile) { return std::uint64_t(tile.width / 8); };
  std::uint64_t all = field.leaves.size();
  for (const Tile& tile : field.tiles) all += across(tile) * across(tile) * across(tile);
  const std::uint64_t stride = std::max<std::uint64_t>(all / count, 1);
  std::vector<glm::ivec3> blocks;
  std::uint64_t next = 0, first = field.leaves.size();
  for (; next < field.leaves.size(); next += stride) blocks.push_back(field.leaves[next].origin);
  for (const Tile& tile : field.tiles) {
    const std::uint64_t n = across(tile), end = first + n * n * n;
    for (; next < end; next += stride) {
      const std::uint64_t i = next - first;
      blocks.push_back(tile.origin + 8 * glm::ivec3(glm::u64vec3(i / (n * n), i / n % n, i % n)));
    }
    first = end;
  }
  return blocks;
}

/// Numbers from 0 to 1, the same ones each time.
class Uniform {
 public:
  double operator()() { return double(random_()) / 4294967296.0; }

 private:
  std::mt19937 random_{1};
};

/// Lines of some rays of a picture through the medium's domain, a voxel a step, and the rays'
/// directions [world].
struct PictureLines {
  std::vector<Line> lines;
  std::vector<glm::dvec3> directions;

  /// One ray, at a random place, of each part of the picture; `size`: columns and rows of parts.
  PictureLines(const View& view, const glm::ivec2& size, Uniform& uniform) {
    const Field& density = *view.medium.density;
    const glm::dmat4 to_index = glm::inverse(density.world_from_index);
    const glm::dmat3 turn(to_index);
    const Box domain = density.domain();
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const double v = y + uniform(), u = x + uniform();
        const WorldRay ray = camera_ray(view.camera, size, u, v);
        const glm::dvec3 from(to_index * glm::dvec4(ray.origin, 1)), way = turn * ray.direction;
        const glm::dvec2 inside = interval_in(domain.min, domain.max, from, way);
        const double begin = std::max(inside.x, 0.0);
        if (!(inside.y > begin)) continue;
        const double step = 1 / glm::length(way);
        lines.push_back({from + (begin + 0.5 * step) * way, step * way, step,
                         std::size_t(std::ceil((inside.y - begin) / step))});
        directions.push_back(ray.direction);
      }
  }
};

/// Opacity of a ray up to each step that attenuates, until it sees no farther.
std::vector<double> opacities_of(const std::vector<Met>& met) {
  std::vector<double> opacities;
  double T = 1;
  for (std::size_t i = 0; i < met.size() && T > least_transmittance; ++i) {
    T *= std::exp(-met[i].depth);
    opacities.push_back(1 - T);
  }
  return opacities;
}

/// Columns and rows of about `count` rays of the picture.
glm::ivec2 rays_of(const glm::ivec2& picture, double count) {
  const glm::dvec2 size(picture);
  const double width = std::round(std::sqrt(count * size.x / size.y));
  return glm::clamp(glm::ivec2(int(width), int(count / width)), glm::ivec2(1), picture);
}

}  // namespace

LightError sum(const LightError& a, const LightError& b) {
  return {std::hypot(a.rms, b.rms), a.max + b.max};
}

LightPilot::LightPilot(const View& view, Depths exact, const LitLuminance& luminance,
                       const LightShare& share)
    : view_(view), exact_(std::move(exact)), luminance_(luminance), share_(share) {
  // the errors of many beams average
  const double beams = double(luminance.beams().size());
  const double pixels = double(view.scene.resolution.x) * view.scene.resolution.y;
  place_points(std::max(std::clamp(pixels / 28, some_light_rays, most_light_rays) / beams,
                        fewest_light_rays));
  truth_ = exact_light(luminance);
}

void LightPilot::place_points(double rays) {
  Looks looks(view_.medium, share_);
  Uniform uniform;
  const glm::ivec2 size = rays_of(view_.scene.resolution, std::max(drawn_from, rays));
  const PictureLines picture(view_, size, uniform);
  const std::vector<Line>& lines = picture.lines;

  std::vector<double> weights;
  for (std::size_t first = 0; first < lines.size(); first += at_once) {
    const auto some = std::span(lines).subspan(first, std::min(at_once, lines.size() - first));
    for (const std::vector<Met>& met : looks.met(some, most_depth)) {
      const std::vector<double> opacities = opacities_of(met);
      weights.push_back(opacities.empty() ? 0 : opacities.back() * opacities.back());
    }
  }

  const auto all_rays = double(size.x) * double(size.y);
  const auto hits = double(std::ranges::count_if(weights, [](double w) { return w > 0; }));
  const double count =
      std::min(hits, std::max(std::ceil(rays * hits / all_rays), fewest_light_rays));
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0), apart = all / count;
  if (!(all > 0)) return;
  coverage_ = all / all_rays;
  double next = apart * uniform(), sum = 0;
  std::vector<Known> tints;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    sum += weights[n];
    if (!(sum > next)) continue;
    const std::vector<Met> met = looks.met({&lines[n], 1}, most_depth).front();
    const std::vector<double> opacities = opacities_of(met);
    for (; sum > next; next += apart) {
      rays_.push_back({voxels_.size(), opacities.back(), picture.directions[n]});
      for (std::size_t i = 0; i < points_per_ray; ++i) {
        const double wanted = (double(i) + uniform()) / points_per_ray * opacities.back();
        const auto k = std::upper_bound(opacities.begin(), opacities.end() - 1, wanted);
        const Met& seen = met[std::size_t(k - opacities.begin())];
        // one of the cell's corners, each as often as its weight: the mean is the interpolation
        const double place = seen.place + double(seen.width) * (uniform() - 0.5);
        const glm::dvec3 point = lines[n].first + place * lines[n].step;
        if (view_.medium.source == LuminanceSource::transfer) {
          const std::optional<glm::dvec3> color = looks.color(point);
          tints.push_back({color.value_or(glm::dvec3(0)), color.has_value()});
        }
        const double z = uniform(), y = uniform(), x = uniform();
        const Box domain = view_.medium.density->domain();
        voxels_.push_back(glm::clamp(glm::ivec3(glm::floor(point + glm::dvec3(x, y, z))),
                                     domain.min, domain.max));
      }
    }
  }
  tints_ = known(tints);
}

std::vector<glm::dvec3> LightPilot::exact_light(const LitLuminance& luminance) const {
  // what no float32 has beside the beam
  const double no_more = transmittance_of(0x1p-24, view_.scene.scatter_octaves);
  std::vector<Known> light;
  light.reserve(voxels_.size());
  for (const glm::ivec3& voxel : voxels_)
    light.push_back(share_.voxels.contains(voxel) ? Known{luminance.own(voxel), true} : Known{});
  for (std::size_t b = 0; b < luminance.beams().size(); ++b) {
    Beam exact = luminance.beams()[b];
    exact.method = {.termination = no_more};
    const std::vector<double> depths = exact_(exact, voxels_);
    for (std::size_t i = 0; i < voxels_.size(); ++i)
      if (light[i].known) light[i].light += luminance.share(b, voxels_[i], depths[i]);
  }
  return known(light);
}

std::vector<glm::dvec3> LightPilot::known(const std::vector<Known>& own) const {
  std::vector<glm::dvec3> light(own.size());
  for (const std::vector<Known>& some : share_.of_all(own))
    for (std::size_t i = 0; i < light.size(); ++i)
      if (some[i].known) light[i] = some[i].light;
  return light;
}

double LightPilot::mean_cells(double termination) const {
  const Medium& medium = view_.medium;
  const glm::dmat3 to_index(glm::inverse(medium.density->world_from_index));
  // a sample of the medium's voxels, not of those that are seen
  const Box domain = medium.density->domain();
  std::vector<Line> lines;
  for (const glm::ivec3& block : some_blocks(share_.whole ? *share_.whole : *medium.density, 256)) {
    const Beam& beam = luminance_.beams()[lines.size() % luminance_.beams().size()];
    const glm::dvec3 way = to_index * -beam.direction;
    const double step = 1 / glm::length(way);
    const glm::dvec3 from(block + 4);
    const double points = interval_in(domain.min, domain.max, from, way).y / step;
    lines.push_back({from, step * way, step, std::size_t(std::ceil(std::max(points, 0.0)))});
  }
  const double stop = -std::log(termination);
  const auto found = Looks(medium, share_).met(lines, stop);
  double cells = 0;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const glm::dvec3 one = glm::abs(lines[n].step);  // empty nodes are crossed in one piece
    double depth = 0;
    for (std::size_t i = 0; i < found[n].size() && depth < stop; ++i) {
      depth += found[n][i].depth;
      cells += double(found[n][i].width) * (one.x + one.y + one.z);
    }
  }
  return lines.empty() ? 1 : cells / double(lines.size());
}

LightError LightPilot::error(const Medium& lit) const {
  const FieldIndex field(*lit.luminance);
  std::vector<Known> light;
  light.reserve(voxels_.size());
  for (const Ray& ray : rays_) {
    const glm::dvec3 factor = lit.color * phase_factor(lit, ray.direction);
    for (std::size_t i = ray.first; i < ray.first + points_per_ray; ++i) {
      const glm::dvec3 value = field.at(voxels_[i]);
      // beside its own part a process has some of the light, and no other value for it
      const bool has = !share_.together() || field.stores(voxels_[i]);
      light.push_back({factor * (lit.luminance->channels == 3 ? value : glm::dvec3(value.x)), has});
    }
  }
  return error(known(light), [&](const Ray& ray) { return phase_factor(lit, ray.direction); });
}

LightError LightPilot::error(const LitLuminance& luminance) const {
  return error(exact_light(luminance), [](const Ray&) { return 1.0; });
}

LightError LightPilot::error(const std::vector<glm::dvec3>& light,
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

}  // namespace psivox
