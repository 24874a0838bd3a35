#pragma once

#include <string>
#include <vector>

#include "psivox/image.h"
#include "psivox/medium_atlas.h"
#include "psivox/progress.h"

namespace psivox {

/// A way to march that a pilot tried. Errors are of radiance and alpha, over R G B A.
struct Trial {
  Sampling sampling = Sampling::cells;
  Integrator integrator = Integrator::cell_exact;
  int segments = 1;        ///< under cells
  double step = 1;         ///< under uniform [voxels of the finest axis]
  double worst_brick = 0;  ///< likewise: what a brick may miss by its bound [tolerances]
  double rms = 0;          ///< over the pilot's rays
  double max = 0;          ///< of one of them
  double samples = 0;      ///< field look-ups a ray
  double cost = 0;  ///< expected time of a ray [look-ups of psi-balanced between uniform samples]
  bool accepted = false;  ///< its error is small enough
};

/// How a picture is to be marched so that its error is what was asked.
struct MarchPlan {
  View view;                  ///< set to the way chosen; its scene has no tolerance
  Trial chosen;               ///< rms and max are the estimate of the picture's error
  std::vector<Trial> trials;  ///< all that were tried
  Image truth;          ///< the pilot's rays, exactly in double; empty: nothing had to be tried
  bool reached = true;  ///< whether the estimate is within the tolerance
  int rays() const { return truth.width * truth.height; }  ///< of the pilot
};

/// The view of the pilot's rays: some hundreds of the picture's, spread over it.
View pilot_view(const View& view);

/// Finds the cheapest way to march `view` whose RMS error over R G B A is at most its scene's
/// tolerance: marches a few hundred of the picture's rays in double precision, exactly in cells and
/// in ways that may be cheaper, and compares. Bricks in which a step could miss more than a few
/// tolerances, by what is stored in them, are given smaller steps, whether a ray of the pilot meets
/// them or not. The result depends on the view alone, not on the machine or its threads. Light must
/// have been computed.
MarchPlan plan_march(const View& view, const MediumAtlas& atlas);

/// Takes for the estimate what the device itself makes of the pilot's rays: `drawn` is
/// pilot_view(plan.view) as it draws it, so that the error of its arithmetic is in it.
/// `plan` has a pilot.
void confirm(MarchPlan& plan, const Image& drawn);

/// RMS by which a device's arithmetic is off on a view that is marched exactly: `drawn` is its
/// pilot_view as the device draws it.
double device_error(const View& exact, const MediumAtlas& atlas, const Image& drawn);

/// A way whose time the budget of plan_within is counted in.
View budget_unit(const View& view);

/// The most accurate way that is expected to take at most `budget` times the time of `budget_unit`,
/// without regard to a tolerance; the cheapest where there is none, and then it is not `reached`.
MarchPlan plan_within(const View& view, const MediumAtlas& atlas, double budget);

/// A view that has next to no error but the arithmetic's: what plan_march takes for the truth.
View exact_view(const View& view);

/// Layer `error`: of each pixel the root-mean-square difference over R G B A between a picture and
/// a better one, and what both are off alike: the layer's RMS is the picture's.
Layer error_layer(const Image& picture, const Image& better, double common = 0);

/// Errors of some pixels of a picture.
struct CheckedError {
  int pixels = 0;
  double rms = 0;  ///< over R G B A
  double max = 0;  ///< of one channel
  int max_x = 0, max_y = 0;
};

/// Compares about `pixels` of the picture's pixels, one at random in each cell of a grid over it,
/// with the reference. The same pixels every time.
CheckedError check_error(const View& view, const Image& picture, int pixels,
                         const Progress& progress = {});

/// A trial in words: "uniform psi-balanced, step 1.7".
std::string trial_text(const Trial& trial);

}  // namespace psivox
