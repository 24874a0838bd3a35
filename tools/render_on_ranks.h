#pragma once

#include <memory>

#include "commands.h"
#include "psivox/team.h"

namespace psivox {

/// `psivox render` in one of several processes. The first writes and reports. Throws AgreedError in
/// the first; the others end.
void render_on_ranks(Arguments arguments, const std::shared_ptr<Team>& team);

}  // namespace psivox
