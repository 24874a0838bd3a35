#pragma once

#include <string>

#include "psivox/scene.h"
#include "psivox/study.h"

namespace psivox {

/// What `--study FILE` gives.
struct StudyFile {
  Sweep sweep;
  Scene scene;
  int repeats = 0;  ///< 0: not given
};

/// The value of --repeats. Throws Error(usage).
int read_repeats(const std::string& text);

/// A JSON object: the sweep's lists by their names, as arrays or in the command line's syntax,
/// `repeats`, and `scene`, an object as --scene reads it. Throws Error(input), Error(usage).
StudyFile read_study_file(const std::string& path);

}  // namespace psivox
