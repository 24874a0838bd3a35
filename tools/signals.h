#pragma once

namespace psivox {

/// From now on SIGINT, SIGTERM and SIGHUP end the process at once with 128 plus their number, and
/// without unfinished files: outputs that were begun are removed, or complete. To be called before
/// other threads start.
void end_cleanly_on_signals();

}  // namespace psivox
