#pragma once

#include <string>

#include "psivox/parameters.h"
#include "psivox/study.h"

namespace psivox {

/// What `--study FILE` gives.
struct StudyFile {
  Sweep sweep;
  Scene scene;
  int repeats = 0;  ///< 0: not given
};

inline constexpr Range repeats_range{1, 1000};

/// A JSON object: the sweep's lists by their names, as arrays or in the command line's syntax,
/// `repeats`, and `scene`, an object as --scene reads it. Throws Error(input), Error(usage).
StudyFile read_study_file(const std::string& path);

}  // namespace psivox
