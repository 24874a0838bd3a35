#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/results.h"

namespace psivox {

/// The errors that tables ask for: RMS over R G B A, powers of ten.
inline const std::vector<double> usual_rms = {1e-2, 1e-3, 1e-4, 1e-5};
/// A power of ten as "1e-3".
std::string power_text(double rms);

/// The cost at which a rule under a sampling reaches `rms`. It is interpolated linearly between
/// measured points, in logarithms of cost and error; unset if no point reaches it.
struct Need {
  Variant variant;  ///< the refinement: step, segments and tolerance are 0
  double rms = 0;
  std::optional<double> samples_per_ray, cpu_ms;
  bool at_most = false;  ///< the coarsest point already reaches it: the cost is an upper bound
};

/// One need for each refinement and RMS; refinements are in the order of their first points.
std::vector<Need> needs_of(const StudyResults& results,
                           const std::vector<double>& rms_wanted = usual_rms);

}  // namespace psivox
