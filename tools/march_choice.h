#pragma once

#include <optional>

#include "psivox/renderer.h"
#include "render_report.h"

namespace psivox {

/// The view as it is to be marched: by its tolerance, by a time for the march [ms] on `gpu` (null:
/// in double on the CPU), or as it is. Says on stderr what could not be had, unless `quiet`.
View choose_march(const View& view, const MediumAtlas& atlas, std::optional<double> time_budget,
                  GlRenderer* gpu, bool quiet, RenderReport& report);

}  // namespace psivox
