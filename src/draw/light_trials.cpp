#include "draw/light_trials.h"

#include <algorithm>
#include <cmath>

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

/// Part of the error of a lattice that one of another spacing leaves: half of it left 0.23 above a
/// voxel and 0.13 below on smoke and clouds (docs/notes/decisions.md). What is computed by it is
/// compared again.
double left_at(double spacing, double known) {
  const double below = std::min(spacing, 1.0) / std::min(known, 1.0);
  return std::pow(spacing / known, 2) * std::pow(below, 0.64);
}

/// A lattice is taken only if its expected error is at most this part of what will do: computing
/// one in vain costs more than columns closer than needed.
constexpr double sure = 0.75;

/// Rays that are exact end at this part of what the light may miss.
constexpr double termination_share = 0.5;

/// Time of a cell that a ray crosses, in look-ups of a lattice, on llvmpipe: 4 to 7 on clouds,
/// smoke and labels.
constexpr double cell_cost = 5;

/// Time of a voxel's light beside its look-ups, in look-ups: of a cloud a direction takes 12 ms at
/// spacings of 4 and 2 voxels, 19 at 1, 50 at 1/2.
constexpr double output_cost = 3;

/// Look-ups of a lattice for a voxel, for one beam.
double lattice_look_ups(double spacing) {
  // two a slice of voxels; bricks at the rim are half empty, and a look-up's time each for the
  // rest
  const double across = 1 / (spacing * spacing), along = std::max(2.0, 1 / spacing);
  return (1 + 0.5 * std::min(spacing, 1.0)) * across * along + 1;
}

}  // namespace

std::pair<LightError, bool> LightTrials::expected(double spacing) const {
  const auto wider = tried_.lower_bound(spacing);
  const auto& [known, off] = wider == tried_.end() ? *tried_.rbegin() : *wider;
  if (known == spacing) return {off, true};
  return {off * left_at(spacing, known), false};
}

LightChoice LightTrials::best() {
  const LightMethod rays{.termination = transmittance_of(termination_share * rms_, octaves_)};
  const double ray_look_ups = cell_cost * pilot_.mean_cells(rays.termination);
  if (tried_.empty()) learn(coarse, pilot_.error(LightMethod{.spacing = coarse}));
  const auto directions = [&](double left) { return directions_ ? directions_->count(left) : 1; };
  LightChoice best{rays, directions(most(1))};
  double least = best.count * (output_cost + ray_look_ups), left_for_count = most(1);
  for (double spacing = directions_ ? double(widest_spacing) : coarse; spacing >= finest;
       spacing = next_spacing(spacing)) {
    const auto [off, known] = expected(spacing);
    const double allowed = most(spacing), counted = known ? off.rms : off.rms / sure;
    if (!(counted < allowed)) continue;
    const double left = std::sqrt(allowed * allowed - counted * counted);
    const int count = directions(left);
    const double time = count * (output_cost + lattice_look_ups(spacing));
    if (time >= least) continue;
    best = {{.spacing = spacing}, count, off};
    least = time;
    left_for_count = left;
  }
  if (best.method.spacing > 0)  // of what is far finer than all that was tried little is known
    best.method.spacing = std::max(best.method.spacing, tried_.begin()->first / 2);
  if (!directions_) return best;
  best.count = directions_->tried(best.count, left_for_count);
  best.miss = sum(best.miss, directions_->miss(best.count));
  return best;
}

LightChoice LightTrials::settled() {
  LightChoice choice = best();
  for (double at = choice.method.spacing; at > 0 && !tried_.contains(at);
       at = choice.method.spacing) {
    learn(at, pilot_.error(choice.method));
    choice = best();
  }
  return choice;
}

SkyTrial::SkyTrial(const View& view, const MediumDepths& depths)
    : view_(view),
      depths_(depths),
      pilot_(view, depths, sky_of(many_count)),
      few_(pilot_.error(sky_of(few_count))) {}

int SkyTrial::count(double most) {
  double wanted = few_count * few_.rms / most;
  if (wanted > many_count) {
    // So many cost much, and the few may tell too much, where they miss a phase's peak, or too
    // little: the error of light that has an edge falls as N^(-3/4) (Beck 1987).
    if (!many_) {
      many_ = LightPilot(view_, depths_, sky_of(2 * many_count)).error(pilot_);
      rate_ = std::clamp(std::log(few_.rms / many_->rms) / std::log(many_count / double(few_count)),
                         0.75, 1.0);
    }
    wanted = std::max(many_count * std::pow(many_->rms / most, 1 / rate_), double(many_count));
  }
  return int(std::clamp(std::ceil(wanted), 8.0, double(most_sky_count)));
}

LightError SkyTrial::miss(int count) const {
  if (many_ && count >= many_count) return *many_ * std::pow(double(many_count) / count, rate_);
  if (count >= few_count) return few_ * (double(few_count) / count);
  return pilot_.error(sky_of(count));
}

int SkyTrial::tried(int count, double most) const {
  for (; count < few_count; count *= 2)
    if (pilot_.error(sky_of(count)).rms <= most) return count;
  return count;
}

}  // namespace psivox
