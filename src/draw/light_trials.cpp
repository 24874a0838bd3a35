#include "draw/light_trials.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "field/index_space.h"
#include "march/light_lattice.h"

namespace psivox {
namespace {

/// Spacings of columns for light of a known error [voxels], from the widest (a wider one may leave
/// a few pixels far off) to the least.
constexpr double coarse = 2, finest = 0.25;

/// The spacing of the lattice with twice the columns; 1 after the square root of 2, exactly.
double next_spacing(double spacing) {
  return std::exp2((std::round(2 * std::log2(spacing)) - 1) / 2);
}

/// Part of the error that the next lattice leaves, above a voxel and below: half the spacing left
/// 0.23 and 0.13 on smoke and clouds (docs/notes/decisions.md). What is computed by it is compared
/// again.
constexpr double left_above = 0.5, left_below = 0.4;

/// A lattice is computed only if its expected error is at most this part of what will do: computing
/// one in vain costs more than columns closer than needed.
constexpr double sure = 0.75;

/// Rays that are exact end at this part of what the light may miss.
constexpr double termination_share = 0.5;

/// Time of a cell that a ray crosses, in look-ups of a lattice, on llvmpipe
/// (docs/performance.md).
constexpr double cell_cost = 1.5;

/// Time of a voxel's light beside its look-ups, in look-ups: of a cloud a direction takes 12 ms at
/// spacings of 4 and 2 voxels, 19 at 1, 50 at 1/2.
constexpr double output_cost = 3;

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

/// Part of the error that is left at this part of a spacing, above a voxel.
double left_at(double part) { return std::pow(left_above, -2 * std::log2(part)); }

/// Look-ups of a lattice for a voxel, for one beam.
double lattice_look_ups(double spacing) {
  // two a slice of voxels; bricks at the rim are half empty, and a look-up's time each for the
  // rest
  const double across = 1 / (spacing * spacing), along = std::max(2.0, 1 / spacing);
  return (1 + 0.5 * std::min(spacing, 1.0)) * across * along + 1;
}

}  // namespace

void set_method(std::vector<Beam>& beams, const LightMethod& method) {
  for (Beam& beam : beams) beam.method = method;
}

bool LightTrials::enough(double miss, double spacing) const {
  return miss <= light_safety / std::max(1.0, spacing * spacing) * rms_;
}

LightMethod LightTrials::first() {
  const LightError off = miss({.spacing = widest_spacing});
  LightMethod method = from(coarse, off.rms * left_at(coarse / widest_spacing));
  if (method.spacing > 0) method.spacing = std::max(method.spacing, 1.0);
  first_miss_ = method.spacing == 0 ? LightError{} : off * left_at(method.spacing / widest_spacing);
  return method;
}

LightMethod LightTrials::after(const LightMethod& method, double miss) {
  const double left = method.spacing > 1 ? left_above : left_below;
  return from(next_spacing(method.spacing), left * miss);
}

LightError LightTrials::miss(const LightMethod& method) const {
  return pilots_.sum_of([&](std::size_t i) {
    const View& view = pilots_.view(i);
    std::vector<Beam> beams = beams_(view, i);
    set_method(beams, method);
    const LightPilot& pilot = pilots_.of(i);
    const std::vector<glm::ivec3>& blocks = i == 0 ? blocks_ : depths_.blocks(i);
    const std::vector<std::size_t> wanted = blocks_with(pilot.voxels(), blocks);
    return pilot.error(LitLuminance(view, beams).medium({blocks, wanted}, depths_.at(i)));
  });
}

LightMethod LightTrials::rays() const {
  return {.termination = transmittance_of(termination_share * rms_, octaves_)};
}

double LightTrials::ray_look_ups() {
  if (!exact_look_ups_) exact_look_ups_ = cell_cost * pilots_.of(0).mean_cells(rays().termination);
  return *exact_look_ups_;
}

LightMethod LightTrials::from(double spacing, double miss) {
  for (; spacing >= finest; spacing = next_spacing(spacing)) {
    if (lattice_look_ups(spacing) > ray_look_ups()) break;
    if (enough(miss / sure, spacing)) return {.spacing = spacing};
    miss *= spacing > 1 ? left_above : left_below;
  }
  return rays();
}

SkyMethod LightTrials::of_sky(SkyTrial& directions) {
  const double most = light_safety * rms_;
  std::map<double, LightError> tried;
  const auto miss_of = [&](double spacing) {
    if (tried.empty()) tried[coarse] = miss({.spacing = coarse});
    const auto finer = tried.lower_bound(spacing);
    const auto& [known, off] = finer == tried.end() ? *tried.rbegin() : *finer;
    return off * left_at(spacing / known);
  };
  while (true) {
    SkyMethod best{directions.count(most), rays(), {}};
    double left = most, least = best.count * (output_cost + ray_look_ups());
    for (double spacing = widest_spacing; spacing >= finest; spacing = next_spacing(spacing)) {
      const LightError off = miss_of(spacing);
      if (!(off.rms < most)) continue;
      const double of_count = std::sqrt(most * most - off.rms * off.rms);
      const int count = directions.count(of_count);
      const double time = count * (output_cost + lattice_look_ups(spacing));
      if (time >= least) continue;
      best = {count, {.spacing = spacing}, off};
      left = of_count;
      least = time;
    }
    const double spacing = best.method.spacing;
    if (spacing > 0 && !tried.contains(spacing)) {
      tried[spacing] = miss(best.method);
      continue;
    }
    best.count = directions.tried(best.count, left);
    best.miss = sum(best.miss, directions.miss(best.count));
    return best;
  }
}

SkyTrial::SkyTrial(const View& view, const MediumDepths& depths)
    : view_(view),
      depths_(depths),
      pilots_(view, depths, sky_of(many_count)),
      few_(pilots_.error(sky_of(few_count))) {}

int SkyTrial::count(double most) {
  double wanted = few_count * few_.rms / most;
  if (wanted > many_count) {
    // So many cost much, and the few may tell too much, where they miss a phase's peak, or too
    // little: the error of light that has an edge falls as N^(-3/4) (Beck 1987).
    if (!many_) {
      many_ = LightPilots(view_, depths_, sky_of(2 * many_count)).error(sky_of(many_count));
      rate_ = std::clamp(std::log(few_.rms / many_->rms) / std::log(many_count / double(few_count)),
                         0.75, 1.0);
    }
    wanted = std::max(many_count * std::pow(many_->rms / most, 1 / rate_), double(many_count));
  }
  return int(std::clamp(std::ceil(wanted), 8.0, double(most_sky_count)));
}

LightError SkyTrial::miss(int count) {
  if (many_ && count >= many_count) return *many_ * std::pow(double(many_count) / count, rate_);
  if (count >= few_count) return few_ * (double(few_count) / count);
  return pilots_.error(sky_of(count));
}

int SkyTrial::tried(int count, double most) const {
  for (; count < few_count; count *= 2)
    if (pilots_.error(sky_of(count)).rms <= most) return count;
  return count;
}

}  // namespace psivox
