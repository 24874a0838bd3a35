#pragma once

#include <optional>

#include "psivox/renderer.h"
#include "render_report.h"

namespace psivox {

/// The view as it is to be marched: by its tolerance, by a time for the march [ms] on `gpu` (null:
/// in double on the CPU), or as it is. Says on stderr what could not be had, unless `quiet`.
View choose_march(const View& view, const MediumAtlas& atlas, std::optional<double> time_budget,
                  GlRenderer* gpu, bool quiet, RenderReport& report);

/// Estimates the error of the plan's picture from the pilot's rays as `gpu` draws them with the
/// picture's own program. Says on stderr where that is above the tolerance, unless `quiet`.
void confirm_plan(GlRenderer& gpu, RenderOptions options, bool quiet, RenderReport& report);

}  // namespace psivox
