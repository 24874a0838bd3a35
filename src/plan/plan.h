#pragma once

#include "plan/picture_error.h"
#include "plan/pilot.h"

namespace psivox {

/// The march that a plan chose, and the pilot that it used.
struct PlannedMarch : MethodView {
  std::shared_ptr<Pilot> pilot{};  ///< null: no method was tried
  CodeWidths code_widths{};        ///< null: float32
  std::vector<double> through{};   ///< see light_through
};

/// Finds the cheapest method for `view` whose RMS error over R G B A is at most its scene's
/// tolerance. It marches a few hundred of the picture's rays in double precision, exactly in cells
/// and by methods that may be cheaper, and compares. Any brick whose stored values allow a step to
/// miss more than a few tolerances gets a smaller step, even if no ray of the pilot meets it. The
/// result depends on the view alone, not on the machine or its threads. Light must have been
/// computed. `progress` is called with 0, often: it may throw to end the search.
MarchPlan plan_march(const View& view, const MediumAtlas& atlas, const Progress& progress = {});

/// The plan that marches exactly, without a pilot.
MarchPlan exact_plan(const View& view);

/// Whether the view may be drawn by codes that are chosen for it.
bool may_be_coded(const View& view);

/// Gives the plan the coarsest codes of the density, and of the light beside it, with which the
/// pilot's rays stay within the tolerance. The atlas is of float32. The plan keeps float32 if codes
/// save less than a quarter of the texels, or if a brick needs more than 16 bits. Unless
/// `fewest_bytes`, it also keeps float32 where the picture is too small to pay for the choice and
/// memory is not scarce, and where codes of density and light save less than 45 %.
void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance, bool fewest_bytes,
                  const Progress& progress);

/// Replaces the plan's estimate by the error of the pilot's rays as the device drew them. `drawn`
/// is pilot_view of the plan's view, with its brick steps. The plan must have a pilot. Of a
/// `picture` with one ray in a pixel, the bright pixels that no ray of the pilot lets expect count
/// too, each for itself.
void confirm(MarchPlan& plan, const Image& drawn, const Image* picture = nullptr);

}  // namespace psivox
