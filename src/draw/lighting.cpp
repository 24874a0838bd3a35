#include "draw/lighting.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "draw/light_trials.h"
#include "field/field_index.h"
#include "field/index_space.h"
#include "march/light_lattice.h"
#include "plan/budget.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

/// Directions of a sky for any light, and for a trial of methods.
constexpr int coarse_sky_count = 8, tried_sky_count = 16;

bool exact(const Beam& beam) { return beam.method == LightMethod{}; }

/// Whether they are the same lights, by whatever methods.
bool same_light(const std::vector<Beam>& a, const std::vector<Beam>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Beam& x, const Beam& y) {
    return x.direction == y.direction && x.radiance == y.radiance;
  });
}

bool same_place(const Camera& a, const Camera& b) {
  return a.position == b.position && a.forward == b.forward && a.orthographic == b.orthographic;
}

/// Blocks of the density whose light is seen.
std::vector<glm::ivec3> blocks_of(const View& view, const MediumAtlas* atlas, const Box& bricks) {
  AtlasOptions options = density_options(view);
  options.region = bricks;
  const Field& density = *view.medium.density;
  if (atlas)
    if (auto blocks = visible_blocks(density, options, atlas->density)) return std::move(*blocks);
  return visible_blocks(density, options);
}

/// Blocks whose voxels a field's values along rays are interpolated from.
std::unordered_set<glm::ivec3, VoxelHash> blocks_along(const Field& field,
                                                       std::span<const WorldRay> rays) {
  std::unordered_set<glm::ivec3, VoxelHash> blocks;
  const glm::dmat4 to_index = glm::inverse(field.world_from_index);
  const Box domain = field.domain();
  for (const WorldRay& ray : rays) {
    const glm::dvec3 from(to_index * glm::dvec4(ray.origin, 1));
    const glm::dvec3 way = glm::normalize(glm::dmat3(to_index) * ray.direction);
    const glm::dvec2 in = interval_in(domain.min, domain.max, from, way);
    // a point is half a voxel away at most: from its cell's neighbours too
    for (double t = std::max(in.x, 0.0); t <= in.y + 1; ++t) {
      const glm::ivec3 cell(glm::floor(from + t * way));
      for (int i = 0; i < 8; ++i) blocks.insert((cell - 1 + 3 * cube_corner(i)) & ~7);
    }
  }
  return blocks;
}

}  // namespace

double light_share(const Scene& scene) {
  return scene.sky || !scene.environment.empty() ? budget::sky : budget::lights;
}

View Lighting::typical_view(const View& view) const {
  if (LitLuminance(view, light_beams(view)).sees_camera()) return view;
  View typical = view;
  typical.scene.resolution = {640, 360};
  typical.camera = make_camera(Scene{}, *view.subject);
  return typical;
}

double Lighting::closer(double coverage) const {
  return sky_coverage_ > 0 ? std::sqrt(std::max(coverage / sky_coverage_, 1.0)) : 1;
}

DrawnLight Lighting::description() const {
  return {light_method_text(beams_.front().method), int(beams_.size()), error_.rms, error_.max};
}

bool Lighting::serves(const View& view, const LightSource& source, LightNeed need) {
  if (!medium_) return false;
  const std::vector<Beam> lights = light_beams(view);
  if (!same_light(lights, {beams_.begin(), beams_.begin() + std::ptrdiff_t(lights.size())}))
    return false;
  const LitLuminance luminance(view, beams_);
  if (luminance.sees_camera() && !same_place(view.camera, camera_)) return false;
  if (std::all_of(beams_.begin(), beams_.end(), exact)) return true;
  if (need.exact) return false;
  if (need.rms == 0) return true;
  if (coarse_) return false;  // it may suffice, but a preview must not change later pictures
  const MediumDepths depths(view, source);
  const LightPilot pilot(view, depths, beams_of(beams_));
  error_ = sum(pilot.error(*medium_), {closer(pilot.coverage()) * sky_error_.rms, sky_error_.max});
  return error_.rms <= need.rms;
}

void Lighting::compute(const View& view, const Box& bricks, const LightSource& source,
                       LightNeed need, const Progress& progress) {
  Lighting next;  // `progress` may throw
  next.blocks_ = blocks_of(view, source.atlas, bricks);
  next.replace(view, source, need, progress);
  *this = std::move(next);
}

Medium Lighting::exact_medium(const View& view, const MediumAtlas& atlas,
                              std::span<const WorldRay> rays, const Progress& progress) const {
  if (medium_ && std::all_of(beams_.begin(), beams_.end(), exact)) return *medium_;
  const VolumeDepths depths(view, &atlas);
  const auto crossed = blocks_along(*view.medium.density, rays);
  return lit(
             view, [&](std::size_t volume) { return depths.at(volume); }, progress,
             [&](const glm::ivec3& block) { return crossed.contains(block); })
      .medium;
}

void Lighting::replace(const View& view, const LightSource& source, LightNeed need,
                       const Progress& progress) {
  const MediumDepths depths(view, source);
  camera_ = view.camera;
  beams_ = light_beams(view);
  coarse_ = !need.exact && need.rms == 0;
  if (need.exact || need.rms == 0) {
    add_sky(view, need.exact ? exact_sky_count : coarse_sky_count);
    set_method(beams_, {.spacing = need.exact ? 0.0 : double(widest_spacing)});
    return sum_up(view, depths, progress);
  }
  const BeamsOn some = sky_of(tried_sky_count);
  if (some(view, 0).empty()) return settle_lights(view, depths, need.rms, progress);
  LightError lights_error;
  double sky_rms = need.rms, begin = 0;
  if (!beams_.empty()) {
    const double lights_rms = budget::beside_sky * need.rms;
    settle_lights(view, depths, lights_rms, part_of(progress, 0, 0.2));
    lights_error = error_;
    sky_rms = budget::beside(lights_rms, need.rms);
    begin = 0.2;
  }
  if (progress) progress(begin);
  const auto tried_on = [&](const View& from) {
    SkyTrial directions(from, depths);
    const LightPilot pilot(from, depths, some);
    sky_coverage_ = directions.coverage();
    return choose_light(pilot, sky_rms, &directions, [&](const LightMethod& method) {
      return method.spacing > 0 ? pilot.error(method) : LightError{};
    });
  };
  const View typical = typical_view(view);
  LightChoice sky = tried_on(typical);
  if (view.camera != typical.camera) {  // this picture may show more of the medium
    const double coverage = LightPilot(view, depths, sky_of(1)).coverage();
    sky.miss = sky.miss * closer(coverage);
    sky_coverage_ = std::max(sky_coverage_, coverage);
    if (sky.miss.rms > sky_rms) sky = tried_on(view);
  }
  const std::size_t lights = beams_.size();
  add_sky(view, sky.count);
  for (std::size_t b = lights; b < beams_.size(); ++b) beams_[b].method = sky.method;
  sum_up(view, depths, part_of(progress, begin + 0.2, 0.8 - begin));
  sky_error_ = sky.miss;
  error_ = sum(lights_error, sky_error_);
}

void Lighting::settle_lights(const View& view, const MediumDepths& depths, double rms,
                             const Progress& progress) {
  const View typical = typical_view(view);
  const LightPilot pilot(typical, depths, beams_of(beams_));
  std::optional<LightPilot> own;  // of a picture that is not the typical one
  if (view.camera != typical.camera) own.emplace(view, depths, beams_of(beams_));
  choose_light(pilot, rms, nullptr, [&](const LightMethod& method) {
    set_method(beams_, method);
    sum_up(view, depths, progress);
    LightError off = pilot.error(*medium_);
    error_ = own ? own->error(*medium_) : off;
    off.rms = std::max(off.rms, budget::light_safety * error_.rms);
    return off;
  });
}

void Lighting::add_sky(const View& view, int count) {
  for (const Beam& beam : sky_beams(view, count)) beams_.push_back(beam);
}

void Lighting::sum_up(const View& view, const MediumDepths& depths, const Progress& progress) {
  medium_.reset();  // not beside the next
  medium_ = lit_medium(
      view, beams_, blocks_, [&](std::size_t volume) { return depths.at(volume); }, progress);
}

}  // namespace psivox
