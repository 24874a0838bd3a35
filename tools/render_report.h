#pragma once

#include <cstdint>
#include <string>

#include <optional>

#include "psivox/draw.h"
#include "psivox/stopwatch.h"

namespace psivox {

/// Time since the process started, which includes loading its libraries [ms].
double process_ms();

/// What one `psivox render` did, for --stats and -v.
struct RenderReport {
  std::string input, output;
  Drawn drawn;
  double startup_ms = 0;  ///< until the command began: loading of libraries
  double read_ms = 0, write_ms = 0, total_ms = 0;
  std::optional<CheckedError> checked;  ///< from --check-error
  std::uint64_t output_bytes = 0;
  std::uint64_t clipped = 0;  ///< pixels brighter than the output's white

  std::string json() const;
  std::string table() const;  ///< lines to be read by people
};

}  // namespace psivox
