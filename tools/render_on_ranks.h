#pragma once

#include <functional>
#include <memory>

#include "psivox/draw.h"
#include "psivox/team.h"
#include "render_call.h"

// The part of `psivox render` that differs where several processes draw a picture together.

namespace psivox {

/// Throws Error(usage) if the call asks for what several processes cannot do.
void check_scope(const RenderCall& call, const Scene& scene);

/// The marcher of this rank: the ranks of a machine take its GPUs in turn.
std::shared_ptr<Marcher> open_own(Scene scene, const Team::Place& place);

/// Does this rank's work. The first writes and reports. Throws AgreedError in the first; the others
/// end.
void run_on(Team& team, const std::function<void()>& work);

}  // namespace psivox
