#pragma once

#include <cstdint>
#include <string>

#include <optional>

#include "psivox/atlas.h"
#include "psivox/error_control.h"
#include "psivox/renderer.h"
#include "psivox/stopwatch.h"

namespace psivox {

/// Since the process was started, that is with the loading of its libraries [ms].
double process_ms();

/// What one `psivox render` did: --stats and -v.
struct RenderReport {
  std::string input, output;
  RenderStats stats;
  std::uint64_t reference_cells = 0;  ///< cells that --renderer reference crossed
  double startup_ms = 0;              ///< until the command began: loading of libraries
  double read_ms = 0, atlas_ms = 0, light_ms = 0, write_ms = 0, total_ms = 0;
  double plan_ms = 0;                    ///< of the choice of a way to march
  std::optional<double> tolerance;       ///< that was asked
  std::optional<MarchPlan> plan;         ///< where the way was chosen
  std::optional<Comparison> difference;  ///< from the exact picture, of layer `error`
  std::optional<CheckedError> checked;   ///< by --check-error
  AtlasSize atlas;                       ///< of all grids together
  std::uint64_t output_bytes = 0;

  std::string json() const;
  std::string table() const;  ///< lines for a person
};

}  // namespace psivox
