#pragma once

#include "march/marcher.h"

namespace psivox {

/// The march that a plan chose, and the pilot that it was chosen by.
struct PlannedMarch {
  View view;               ///< set to the method chosen; its scene has no tolerance
  BrickSteps brick_steps;  ///< null: one step everywhere
  Image truth;             ///< the pilot's rays, exactly in double; empty: nothing had to be tried
};

/// Finds the cheapest method for `view` whose RMS error over R G B A is at most its scene's
/// tolerance: marches a few hundred of the picture's rays in double precision, exactly in cells and
/// by methods that may be cheaper, and compares. A brick in which a step could miss more than a few
/// tolerances, by what is stored in it, gets a smaller step, whether a ray of the pilot meets it or
/// not. The result depends on the view alone, not on the machine or its threads. Light must have
/// been computed.
MarchPlan plan_march(const View& view, const MediumAtlas& atlas);

/// The most accurate method that is expected to take at most `budget` times the time of
/// `budget_unit`, without regard to a tolerance; the cheapest where there is none, and then it is
/// not `reached`.
MarchPlan plan_within(const View& view, const MediumAtlas& atlas, double budget);

/// The view by the method whose time the budget of plan_within is counted in.
View budget_unit(const View& view);

/// The view by the most exact method, with no early end: no error but the arithmetic's. plan_march
/// takes it for the truth.
View exact_view(const View& view);

/// The view of the pilot's rays: some hundreds of the picture's, spread over it.
View pilot_view(const View& view);

/// Replaces the plan's estimate by the error of the pilot's rays as the device drew them: `drawn`
/// is pilot_view of the plan's view, with its brick steps. The plan has a pilot.
void confirm(MarchPlan& plan, const Image& drawn);

/// RMS error of the device's arithmetic where a view is marched exactly: `drawn` is the exact
/// view's pilot_view as the device draws it.
double device_error(const View& exact, const MediumAtlas& atlas, const Image& drawn);

/// Layer `error`: of each pixel the root-mean-square difference over R G B A between a picture and
/// a better one, and `common`, an error that both share: the layer's RMS is the picture's.
Layer error_layer(const Image& picture, const Image& better, double common = 0);

/// Session::check_error, of any view.
CheckedError check_pixels(const View& view, const Image& picture, int pixels,
                          const Progress& progress = {});

}  // namespace psivox
