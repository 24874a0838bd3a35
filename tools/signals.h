#pragma once

namespace psivox {

/// From now on a write beyond the limit of a file's size fails, and does not end the process.
void report_failed_writes();

/// From now on SIGINT, SIGTERM and SIGHUP end the process at once with 128 plus their number, and
/// without unfinished files: outputs that were begun are removed, or complete. To be called before
/// other threads start.
void end_cleanly_on_signals();

/// The process ends with exit code 1, this message and no unfinished files, if it still runs then.
void end_after(int seconds, const char* message);

}  // namespace psivox
