#include "draw/lighting.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "field/index_space.h"
#include "march/light_lattice.h"
#include "march/march_double.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Spacings of columns, from coarse to fine [voxels]: for any light and the first trial, for light
/// of a known error (a wider one may leave a few pixels far off), and the least.
constexpr double coarsest = widest_spacing, coarse = 2, finest = 0.25;

/// The spacing of the lattice with twice the columns; 1 after the square root of 2, exactly.
double next_spacing(double spacing) {
  return std::exp2((std::round(2 * std::log2(spacing)) - 1) / 2);
}

/// Part of the error that the next lattice leaves, above a voxel and below: half the spacing left
/// 0.23 and 0.13 on smoke and clouds (docs/notes/light.md). What is computed by it is compared
/// again.
constexpr double left_above = 0.5, left_below = 0.4;

/// Directions of a sky for any light, and for a trial of methods.
constexpr int coarse_sky_count = 8, tried_sky_count = 16;

/// The estimated error of the light may reach this fraction of what the light may miss, since the
/// pilot is a sample. For lattices wider than a voxel, whose errors are larger in few pixels, it is
/// divided by the square of the spacing.
constexpr double light_safety = 0.8;
/// A lattice is computed only if its expected error is at most this part of that limit: computing
/// one in vain costs more than columns closer than needed.
constexpr double sure = 0.75;

/// Rays that are exact end at this part of what the light may miss.
constexpr double termination_share = 0.5;

void set_method(std::vector<Beam>& beams, const LightMethod& method) {
  for (Beam& beam : beams) beam.method = method;
}

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

/// Whether pictures of any size by them show the same.
bool same_frame(const Camera& a, const Camera& b) {
  return same_place(a, b) && a.up == b.up && a.half_width == b.half_width &&
         a.half_height == b.half_height;
}

/// Places of the blocks that hold the pilot's voxels, in ascending order.
std::vector<std::size_t> blocks_with(std::span<const glm::ivec3> voxels,
                                     const std::vector<glm::ivec3>& blocks) {
  std::vector<std::size_t> places;
  for (const glm::ivec3& voxel : voxels) {
    const glm::ivec3 origin = voxel & ~7;
    const auto found = std::lower_bound(blocks.begin(), blocks.end(), origin, comes_before);
    if (found != blocks.end() && *found == origin)
      places.push_back(std::size_t(found - blocks.begin()));
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
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

/// Methods for some beams, by what they miss and cost.
class LightTrials {
 public:
  LightTrials(const View& view, const LightSource& source, const std::vector<glm::ivec3>& blocks,
              std::vector<Beam> beams, double rms)
      : view_(view),
        blocks_(blocks),
        beams_(std::move(beams)),
        rms_(rms),
        luminance_(view, beams_),
        pilot_(view, source.exact_depths(view), luminance_, source.share) {}

  /// What `lit` misses, as estimated.
  LightError miss(const Medium& lit) const { return pilot_.error(lit); }
  bool enough(double miss, double spacing) const {
    return miss <= light_safety / std::max(1.0, spacing * spacing) * rms_;
  }

  /// The method to begin with: the coarsest lattice that is expected to be enough, but not below a
  /// voxel from so coarse a trial, or exact rays where they cost less.
  LightMethod first(const LightDepths& depths) {
    if (!view_.medium.others.empty()) return from(coarse, 0);
    const LightError off = miss({.spacing = coarsest}, depths);
    LightMethod method = from(coarse, off.rms * left_at(coarse / coarsest));
    if (method.spacing > 0) method.spacing = std::max(method.spacing, 1.0);
    first_miss_ = method.spacing == 0 ? LightError{} : off * left_at(method.spacing / coarsest);
    return method;
  }
  /// The method that misses little enough, as tried.
  LightMethod settled(const LightDepths& depths) {
    LightMethod method = first(depths);
    while (method.spacing > 0) {
      first_miss_ = miss(method, depths);
      if (enough(first_miss_.rms, method.spacing)) break;
      method = after(method, first_miss_.rms);
    }
    if (method.spacing == 0) first_miss_ = {};
    return method;
  }
  /// What the method of first() is expected to miss, or that of settled() does.
  const LightError& first_miss() const { return first_miss_; }

  /// The next method after one that missed too much.
  LightMethod after(const LightMethod& method, double miss) {
    const double left = method.spacing > 1 ? left_above : left_below;
    return from(next_spacing(method.spacing), left * miss);
  }

 private:
  /// Part of the error that is left at this part of a spacing, above a voxel.
  static double left_at(double part) { return std::pow(left_above, -2 * std::log2(part)); }

  LightError miss(const LightMethod& method, const LightDepths& depths) const {
    std::vector<Beam> beams = beams_;
    set_method(beams, method);
    const std::vector<std::size_t> wanted = blocks_with(pilot_.voxels(), blocks_);
    return miss(LitLuminance(view_, beams).medium({blocks_, wanted}, depths));
  }

  /// The coarsest lattice, from `spacing` down, that is expected to be enough; exact rays if none
  /// is or if they cost less. The lattice of `spacing` is expected to miss `miss`.
  LightMethod from(double spacing, double miss) {
    const LightMethod rays{
        .termination = transmittance_of(termination_share * rms_, view_.scene.scatter_octaves)};
    if (!exact_look_ups_) exact_look_ups_ = exact_look_ups(rays.termination);
    const bool columns = view_.medium.others.empty();  // they cross one volume
    for (; columns && spacing >= finest; spacing = next_spacing(spacing)) {
      if (lattice_look_ups(spacing) > *exact_look_ups_) break;
      if (enough(miss / sure, spacing)) return {.spacing = spacing};
      miss *= spacing > 1 ? left_above : left_below;
    }
    return rays;
  }

  /// Look-ups of a lattice for a voxel, for one beam.
  static double lattice_look_ups(double spacing) {
    // two a slice of voxels; bricks at the rim are half empty, and a look-up's time each for the
    // rest
    const double across = 1 / (spacing * spacing), along = std::max(2.0, 1 / spacing);
    return (1 + 0.5 * std::min(spacing, 1.0)) * across * along + 1;
  }

  /// Time of a ray from each voxel, in look-ups of a lattice.
  double exact_look_ups(double termination) const {
    return cell_cost * pilot_.mean_cells(termination);
  }

  /// Time of a cell that a ray crosses, in look-ups of a lattice, on llvmpipe
  /// (docs/performance.md).
  static constexpr double cell_cost = 1.5;

  const View& view_;
  const std::vector<glm::ivec3>& blocks_;
  std::vector<Beam> beams_;
  double rms_;
  LightError first_miss_;
  std::optional<double> exact_look_ups_;
  LitLuminance luminance_;
  LightPilot pilot_;
};

/// Number of a sky's directions. Over clouds and smoke the error falls as one over their number
/// (docs/notes/light.md), so that a trial with few tells how many it takes. Of fewer the error may
/// be far larger, where few directions miss the phase function's peak: these are tried.
class SkyTrial {
 public:
  SkyTrial(const View& view, const LightSource& source, double rms) {
    const double most = light_safety * rms;
    const LitLuminance many(view, sky_beams(view, 256));
    const LightPilot pilot(view, source.exact_depths(view), many, source.share);
    coverage_ = pilot.coverage();
    const auto miss_of = [&](int count) {
      return pilot.error(LitLuminance(view, sky_beams(view, count)));
    };
    miss_ = miss_of(few_count);
    const double wanted = std::clamp(std::ceil(few_count * miss_.rms / most), 8.0, 1024.0);
    if (wanted >= few_count) {
      count_ = int(wanted);
      miss_ = miss_ * (few_count / wanted);
      return;
    }
    for (int count = int(wanted); count < few_count; count *= 2)
      if (const LightError miss = miss_of(count); miss.rms <= most) {
        count_ = count;
        miss_ = miss;
        return;
      }
  }
  int count() const { return count_; }
  const LightError& miss() const { return miss_; }
  double coverage() const { return coverage_; }

 private:
  static constexpr int few_count = 32;
  int count_ = few_count;
  LightError miss_;
  double coverage_ = 0;
};

}  // namespace

View Lighting::seen(const View& wanted) const {
  View view = view_;
  view.camera = wanted.camera;
  view.scene.resolution = wanted.scene.resolution;
  return view;
}

View Lighting::typical_view(const View& view) const {
  if (LitLuminance(view, light_beams(view)).sees_camera()) return view;
  View typical = view;
  typical.scene.resolution = {640, 360};
  typical.camera = make_camera(Scene{}, *view.subject);
  return typical;
}

DrawnLight Lighting::description() const {
  return {light_method_text(beams_.front().method), int(beams_.size()), error_.rms, error_.max};
}

bool Lighting::serves(const View& wanted, const LightSource& source, LightNeed need) {
  if (!medium_) return false;
  const View view = seen(wanted);
  const std::vector<Beam> lights = light_beams(view);
  if (!same_light(lights, {beams_.begin(), beams_.begin() + std::ptrdiff_t(lights.size())}))
    return false;
  const LitLuminance luminance(view, beams_);
  if (luminance.sees_camera() && !same_place(view.camera, camera_)) return false;
  if (std::all_of(beams_.begin(), beams_.end(), exact)) return true;
  if (need.exact) return false;
  if (need.rms == 0) return true;
  if (coarse_) return false;  // it may suffice, but a preview must not change later pictures
  const LightPilot pilot(view, source.exact_depths(view), luminance, source.share);
  // a closer camera sees more of what the sky's directions miss
  const double closer =
      sky_coverage_ > 0 ? std::sqrt(std::max(pilot.coverage() / sky_coverage_, 1.0)) : 1;
  error_ = sum(pilot.error(*medium_), {closer * sky_error_.rms, sky_error_.max});
  return error_.rms <= need.rms;
}

void Lighting::compute(const View& wanted, const LightSource& source, LightNeed need,
                       const Progress& progress) {
  Lighting next = *this;  // `progress` may throw
  next.replace(wanted, source, need, progress);
  *this = std::move(next);
}

Medium Lighting::exact_medium(const View& wanted, const MediumAtlas& atlas) const {
  if (medium_ && std::all_of(beams_.begin(), beams_.end(), exact)) return *medium_;
  const View view = seen(wanted);
  return lit(view, march_double_light_depths(view, atlas)).medium;
}

void Lighting::replace(const View& wanted, const LightSource& source, LightNeed need,
                       const Progress& progress) {
  const View view = seen(wanted);
  if (blocks_.empty()) blocks_ = blocks_of(view, source.atlas, bricks_);
  const LightDepths depths = source.depths(view);
  depths_of_others_ = source.atlas ? DepthsOf(own_light_depths) : source.depths;
  camera_ = view.camera;
  beams_ = light_beams(view);
  sky_error_ = error_ = {};
  sky_coverage_ = 0;
  coarse_ = !need.exact && need.rms == 0;
  if (need.exact || need.rms == 0) {
    add_sky(view, need.exact ? exact_sky_count : coarse_sky_count);
    const bool columns = !need.exact && view.medium.others.empty();
    set_method(beams_, {.spacing = columns ? coarsest : 0});
    return sum_up(view, source, depths, progress);
  }
  const std::vector<Beam> some = sky_beams(view, tried_sky_count);
  if (some.empty()) return settle_lights(view, source, depths, need.rms, progress);
  const double part = beams_.empty() ? need.rms : need.rms * std::sqrt(0.5);
  LightError lights_error;
  if (!beams_.empty()) {
    LightSource before_sky = source;
    before_sky.values_are_seen = {};
    settle_lights(view, before_sky, depths, part, progress);
    lights_error = error_;
  }
  // the sky's share, in quadrature: for the number of its directions, and for the depths of each.
  // Both suit the typical picture and this one, which may show more of the medium
  std::vector<View> views{typical_view(view)};
  if (!same_frame(view.camera, views.front().camera)) views.push_back(view);
  int count = 0;
  LightMethod method{.spacing = HUGE_VAL};
  LightError of_count, of_method;
  for (const View& from : views) {
    const SkyTrial trial(from, source, 0.6 * part);
    if (trial.count() >= count) {
      count = trial.count();
      of_count = trial.miss();
      sky_coverage_ = trial.coverage();
    }
    LightTrials trials(from, source, blocks_, some, 0.8 * part);
    if (const LightMethod settled = trials.settled(depths); settled.spacing <= method.spacing) {
      method = settled;
      of_method = trials.first_miss();
    }
  }
  const std::size_t lights = beams_.size();
  add_sky(view, count);
  for (std::size_t b = lights; b < beams_.size(); ++b) beams_[b].method = method;
  sum_up(view, source, depths, progress);
  sky_error_ = sum(of_count, of_method);
  error_ = sum(lights_error, sky_error_);
}

void Lighting::settle_lights(const View& view, const LightSource& source, const LightDepths& depths,
                             double rms, const Progress& progress) {
  const View typical = typical_view(view);
  const LitLuminance luminance(view, beams_);
  std::optional<LightPilot> own;  // the trials' pilot serves the typical picture
  if (!same_frame(view.camera, typical.camera))
    own.emplace(view, source.exact_depths(view), luminance, source.share);
  LightTrials trials(typical, source, blocks_, beams_, rms);
  LightMethod method = trials.first(depths);
  while (true) {
    set_method(beams_, method);
    sum_up(view, source, depths, progress);
    const LightError typical_miss = trials.miss(*medium_);
    error_ = own ? own->error(*medium_) : typical_miss;
    if (method.spacing == 0 ||
        (trials.enough(typical_miss.rms, method.spacing) && error_.rms <= rms))
      return;
    method = trials.after(method, std::max(typical_miss.rms, light_safety * error_.rms));
  }
}

void Lighting::add_sky(const View& view, int count) {
  for (const Beam& beam : sky_beams(view, count)) beams_.push_back(beam);
}

void Lighting::sum_up(const View& view, const LightSource& source, const LightDepths& depths,
                      const Progress& progress) {
  std::vector<std::size_t> all(blocks_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  medium_.reset();  // not beside the next
  const LitLuminance luminance(view, beams_);
  if (source.values_are_seen && !luminance.reads_density() && view.medium.others.empty())
    source.values_are_seen();
  medium_ = luminance.medium({blocks_, all}, depths, progress);
  light_others(view, beams_, depths_of_others_, *medium_, progress);
}

}  // namespace psivox
