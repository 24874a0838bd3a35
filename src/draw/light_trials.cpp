#include "draw/light_trials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "plan/budget.h"

namespace psivox {
namespace {

/// The candidates: spacings of columns [voxels], and 0 for exact rays. A wider lattice may leave a
/// few pixels far off.
constexpr double root = std::numbers::sqrt2;
constexpr double spacings[] = {2, root, 1, root / 2, 1.0 / 2, root / 4, 1.0 / 4, 0};

/// Power of the spacing with which the error of lattices falls: half of it left 0.23 above a voxel
/// and 0.13 below on smoke and clouds.
constexpr double order = 2.5;

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

LightChoice choose_light(const LightPilot& pilot, double rms, SkyTrial* sky,
                         const MeasureLight& measure) {
  const double end = pilot.transmittance(budget::light_rays_end * rms);
  const double ray_look_ups = cell_cost * pilot.mean_cells(end);
  std::map<double, LightError> tried{{spacings[0], pilot.error(LightMethod{spacings[0], end})}};
  double measured = sky ? spacings[0] : -1;  // lights are measured as they are computed in full
  while (true) {
    LightChoice best;
    double least = HUGE_VAL, left_for_count = 0;
    for (const double spacing : spacings) {
      LightError off;
      double counted = 0;
      if (spacing > 0) {
        const auto& [known, miss] = *tried.lower_bound(spacing);
        off = miss * std::pow(spacing / known, order);
        counted = known == spacing ? off.rms : off.rms / budget::light_sure;
      }
      // of one light, the errors of lattices wider than a voxel are larger in few pixels
      const double wide = sky ? 1 : std::max(1.0, spacing * spacing);
      const double most = budget::light_safety * rms / wide;
      if (counted >= most) continue;
      const double left = std::sqrt(most * most - counted * counted);
      const int count = sky ? sky->count(left) : 1;
      const double look_ups = spacing > 0 ? lattice_look_ups(spacing) : ray_look_ups;
      const double time = count * (output_cost + look_ups);
      if (time >= least) continue;
      best = {{.spacing = spacing, .termination = end}, count, off};
      least = time;
      left_for_count = left;
    }
    if (best.method.spacing != measured) {
      measured = best.method.spacing;
      tried[measured] = measure(best.method);
      continue;
    }
    if (!sky) return best;
    best.count = sky->tried(best.count, left_for_count);
    best.miss = sum(best.miss, sky->miss(best.count));
    return best;
  }
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
