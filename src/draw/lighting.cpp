#include "draw/lighting.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "field/index_space.h"
#include "march/light_lattice.h"
#include "march/volume_depths.h"

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

/// Beams on a view's volume, the first of what is `seen` from it.
using BeamsOn = std::function<std::vector<Beam>(const View& seen, std::size_t volume)>;

/// The beams of the first volume, on each.
BeamsOn beams_of(const std::vector<Beam>& beams) {
  return [&beams](const View& seen, std::size_t volume) { return beams_on(seen, volume, beams); };
}

/// Progress of a part of the work, which begins there and is so large.
Progress part_of(const Progress& progress, double begin, double size) {
  return [&progress, begin, size](double done) {
    if (progress) progress(begin + size * done);
  };
}

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

/// Blocks of the density whose light is seen.
std::vector<glm::ivec3> blocks_of(const View& view, const MediumAtlas* atlas, const Box& bricks) {
  AtlasOptions options = density_options(view);
  options.region = bricks;
  const Field& density = *view.medium.density;
  if (atlas)
    if (auto blocks = visible_blocks(density, options, atlas->density)) return std::move(*blocks);
  return visible_blocks(density, options);
}

}  // namespace

/// Depths through the whole medium of a view, from voxels of each of its volumes.
class MediumDepths {
 public:
  /// View and source must outlive it.
  MediumDepths(const View& view, const LightSource& source) : view_(view), source_(source) {
    if (!view.medium.others.empty() && source.atlas)
      volumes_.emplace(view, source.atlas, source.depths);
  }

  LightDepths at(std::size_t volume) const {
    if (volumes_) return volumes_->at(volume);
    if (volume == 0) return source_.depths(view_);
    return source_.depths(seen_from(view_, volume));  // the reference's own copy it
  }
  /// Exact, from voxels of a volume of the medium by any camera.
  LightPilot::Depths exact(const View& seen, std::size_t volume) const {
    if (!volumes_) return source_.exact_depths(seen);
    return [this, volume](const Beam& beam, std::span<const glm::ivec3> voxels) {
      return volumes_->exact(volume, beam, voxels);
    };
  }
  const LightShare& share() const { return source_.share; }
  std::size_t volumes() const { return 1 + view_.medium.others.size(); }

 private:
  const View& view_;
  const LightSource& source_;
  std::optional<VolumeDepths> volumes_;
};

namespace {

/// A volume's medium in a lit one.
const Medium& volume_of(const Medium& medium, std::size_t volume) {
  return volume == 0 ? medium : medium.others[volume - 1];
}

BeamsOn sky_of(int count) {
  return [count](const View& seen, std::size_t) { return sky_beams(seen, count); };
}

/// Pilots of all volumes of a medium. What a picture misses in the light of each adds up, at most;
/// the largest errors are rarely in one pixel.
class LightPilots {
 public:
  /// View and depths must outlive them.
  LightPilots(const View& view, const MediumDepths& depths, const BeamsOn& beams) {
    for (std::size_t i = 0; i < depths.volumes(); ++i) {
      volumes_.emplace_back();
      if (is_to_be_lit(view, i))
        volumes_.back() = std::make_unique<Volume>(seen_from(view, i), i, depths, beams);
    }
  }

  bool has(std::size_t volume) const { return volumes_[volume] != nullptr; }
  const View& view(std::size_t volume) const { return volumes_[volume]->view; }
  const LightPilot& of(std::size_t volume) const { return volumes_[volume]->pilot; }

  /// What a lit medium misses.
  LightError error(const Medium& lit) const {
    return sum_of([&](std::size_t i) { return of(i).error(volume_of(lit, i)); });
  }
  /// What other beams miss, in exact light.
  LightError error(const BeamsOn& beams) const {
    return sum_of(
        [&](std::size_t i) { return of(i).error(LitLuminance(view(i), beams(view(i), i))); });
  }
  /// LightPilot::coverage() of all.
  double coverage() const {
    double sum = 0;
    for (const auto& volume : volumes_)
      if (volume) sum += volume->pilot.coverage();
    return sum;
  }
  LightError sum_of(const std::function<LightError(std::size_t volume)>& error) const {
    LightError sum;
    for (std::size_t i = 0; i < volumes_.size(); ++i) {
      if (!has(i)) continue;
      const LightError own = error(i);
      sum = {sum.rms + own.rms, std::max(sum.max, own.max)};
    }
    return sum;
  }

 private:
  struct Volume {
    Volume(View seen, std::size_t i, const MediumDepths& depths, const BeamsOn& beams)
        : view(std::move(seen)),
          luminance(view, beams(view, i)),
          pilot(view, depths.exact(view, i), luminance, depths.share()) {}
    View view;
    LitLuminance luminance;
    LightPilot pilot;
  };

  std::vector<std::unique_ptr<Volume>> volumes_;
};

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

/// Methods for some beams, by what they miss and cost.
class LightTrials {
 public:
  /// `blocks`: of the first volume.
  LightTrials(const View& view, const MediumDepths& depths, const std::vector<glm::ivec3>& blocks,
              BeamsOn beams, double rms)
      : octaves_(view.scene.scatter_octaves),
        depths_(depths),
        blocks_{blocks},
        beams_(std::move(beams)),
        rms_(rms),
        pilots_(view, depths, beams_) {
    for (std::size_t i = 1; i < depths.volumes(); ++i) {
      blocks_.emplace_back();
      if (pilots_.has(i)) blocks_.back() = blocks_of(pilots_.view(i), nullptr, everywhere);
    }
  }

  /// What `lit` misses, as estimated.
  LightError miss(const Medium& lit) const { return pilots_.error(lit); }
  bool enough(double miss, double spacing) const {
    return miss <= light_safety / std::max(1.0, spacing * spacing) * rms_;
  }

  /// The method to begin with: the coarsest lattice that is expected to be enough, but not below a
  /// voxel from so coarse a trial, or exact rays where they cost less.
  LightMethod first() {
    const LightError off = miss({.spacing = coarsest});
    LightMethod method = from(coarse, off.rms * left_at(coarse / coarsest));
    if (method.spacing > 0) method.spacing = std::max(method.spacing, 1.0);
    first_miss_ = method.spacing == 0 ? LightError{} : off * left_at(method.spacing / coarsest);
    return method;
  }
  /// The method that misses little enough, as tried.
  LightMethod settled() {
    LightMethod method = first();
    while (method.spacing > 0) {
      first_miss_ = miss(method);
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

  LightError miss(const LightMethod& method) const {
    return pilots_.sum_of([&](std::size_t i) {
      const View& view = pilots_.view(i);
      std::vector<Beam> beams = beams_(view, i);
      set_method(beams, method);
      const LightPilot& pilot = pilots_.of(i);
      const std::vector<std::size_t> wanted = blocks_with(pilot.voxels(), blocks_[i]);
      return pilot.error(LitLuminance(view, beams).medium({blocks_[i], wanted}, depths_.at(i)));
    });
  }

  /// The coarsest lattice, from `spacing` down, that is expected to be enough; exact rays if none
  /// is or if they cost less. The lattice of `spacing` is expected to miss `miss`.
  LightMethod from(double spacing, double miss) {
    const LightMethod rays{.termination = transmittance_of(termination_share * rms_, octaves_)};
    if (!exact_look_ups_) exact_look_ups_ = exact_look_ups(rays.termination);
    for (; spacing >= finest; spacing = next_spacing(spacing)) {
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
    return cell_cost * pilots_.of(0).mean_cells(termination);
  }

  /// Time of a cell that a ray crosses, in look-ups of a lattice, on llvmpipe
  /// (docs/performance.md).
  static constexpr double cell_cost = 1.5;

  int octaves_;
  const MediumDepths& depths_;
  std::vector<std::vector<glm::ivec3>> blocks_;  ///< of each volume
  BeamsOn beams_;
  double rms_;
  LightError first_miss_;
  std::optional<double> exact_look_ups_;
  LightPilots pilots_;
};

/// Number of a sky's directions. Over clouds and smoke the error falls as one over their number
/// (docs/notes/light.md), so that a trial with few tells how many it takes. Of fewer the error may
/// be far larger, where few directions miss the phase function's peak: these are tried.
class SkyTrial {
 public:
  SkyTrial(const View& view, const MediumDepths& depths, double rms) {
    const double most = light_safety * rms;
    const LightPilots pilots(view, depths, sky_of(256));
    coverage_ = pilots.coverage();
    const auto miss_of = [&](int count) { return pilots.error(sky_of(count)); };
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
  const MediumDepths depths(view, source);
  const LightPilots pilots(view, depths, beams_of(beams_));
  // a closer camera sees more of what the sky's directions miss
  const double closer =
      sky_coverage_ > 0 ? std::sqrt(std::max(pilots.coverage() / sky_coverage_, 1.0)) : 1;
  error_ = sum(pilots.error(*medium_), {closer * sky_error_.rms, sky_error_.max});
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
  const VolumeDepths depths(view, &atlas);
  return lit(view, [&](std::size_t volume) { return depths.at(volume); }).medium;
}

void Lighting::replace(const View& wanted, const LightSource& source, LightNeed need,
                       const Progress& progress) {
  const View view = seen(wanted);
  if (blocks_.empty()) blocks_ = blocks_of(view, source.atlas, bricks_);
  const MediumDepths depths(view, source);
  camera_ = view.camera;
  beams_ = light_beams(view);
  sky_error_ = error_ = {};
  sky_coverage_ = 0;
  coarse_ = !need.exact && need.rms == 0;
  if (need.exact || need.rms == 0) {
    add_sky(view, need.exact ? exact_sky_count : coarse_sky_count);
    set_method(beams_, {.spacing = need.exact ? 0 : coarsest});
    return sum_up(view, source, depths, progress);
  }
  const BeamsOn some = sky_of(tried_sky_count);
  if (some(view, 0).empty()) return settle_lights(view, source, depths, need.rms, progress);
  const double part = beams_.empty() ? need.rms : need.rms * std::sqrt(0.5);
  LightError lights_error;
  if (!beams_.empty()) {
    LightSource before_sky = source;
    before_sky.values_are_seen = {};
    settle_lights(view, before_sky, depths, part, part_of(progress, 0, 0.5));
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
    const SkyTrial trial(from, depths, 0.6 * part);
    if (trial.count() >= count) {
      count = trial.count();
      of_count = trial.miss();
      sky_coverage_ = trial.coverage();
    }
    LightTrials trials(from, depths, blocks_, some, 0.8 * part);
    if (const LightMethod settled = trials.settled(); settled.spacing <= method.spacing) {
      method = settled;
      of_method = trials.first_miss();
    }
  }
  const std::size_t lights = beams_.size();
  add_sky(view, count);
  for (std::size_t b = lights; b < beams_.size(); ++b) beams_[b].method = method;
  sum_up(view, source, depths, lights > 0 ? part_of(progress, 0.5, 0.5) : progress);
  sky_error_ = sum(of_count, of_method);
  error_ = sum(lights_error, sky_error_);
}

void Lighting::settle_lights(const View& view, const LightSource& source,
                             const MediumDepths& depths, double rms, const Progress& progress) {
  const View typical = typical_view(view);
  std::optional<LightPilots> own;  // the trials' pilots serve the typical picture
  if (!same_frame(view.camera, typical.camera)) own.emplace(view, depths, beams_of(beams_));
  LightTrials trials(typical, depths, blocks_, beams_of(beams_), rms);
  LightMethod method = trials.first();
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

void Lighting::sum_up(const View& view, const LightSource& source, const MediumDepths& depths,
                      const Progress& progress) {
  std::vector<std::size_t> all(blocks_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  medium_.reset();  // not beside the next
  const LitLuminance luminance(view, beams_);
  if (source.values_are_seen && !luminance.reads_density() && view.medium.others.empty())
    source.values_are_seen();
  const double volumes = double(depths.volumes());
  medium_ = luminance.medium({blocks_, all}, depths.at(0), part_of(progress, 0, 1 / volumes));
  light_others(
      view, beams_, [&](std::size_t volume) { return depths.at(volume); }, *medium_,
      part_of(progress, 1 / volumes, 1 - 1 / volumes));
}

}  // namespace psivox
