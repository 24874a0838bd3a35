#pragma once

#include "plan/plan.h"

namespace psivox {

/// Whether the view may be drawn by codes that are chosen for it.
bool may_be_coded(const View& view);

/// Gives the plan the coarsest codes of the density, and of the light beside it, with which the
/// pilot's rays stay within the tolerance. The atlas is of float32. The plan keeps float32 if codes
/// save less than a quarter of the texels, or if a brick needs more than 16 bits. Unless
/// `fewest_bytes`, it also keeps float32 where the picture is too small to pay for the choice and
/// memory is not scarce, and where codes of density and light save less than 45 %.
void choose_codes(MarchPlan& plan, const MediumAtlas& atlas, double tolerance, bool fewest_bytes,
                  const Progress& progress);

}  // namespace psivox
