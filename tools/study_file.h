#pragma once

#include <string>

#include "psivox/parameters.h"
#include "psivox/study.h"

namespace psivox {

/// The contents of the file that `--study FILE` names.
struct StudyFile {
  Sweep sweep;
  Scene scene;
  int repeats = 0;  ///< 0: not given
};

inline constexpr Range repeats_range{1, 1000};

/// Reads a JSON object: the sweep's lists by name, as arrays or in the command line's syntax;
/// `repeats`; and `scene`, an object in the format of --scene. Throws Error(input), Error(usage).
StudyFile read_study_file(const std::string& path);

}  // namespace psivox
