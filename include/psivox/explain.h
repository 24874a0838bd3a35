#pragma once

#include <string>
#include <vector>

#include "psivox/medium_atlas.h"

namespace psivox {

/// One choice of the model that a view is marched by, and its reason.
struct Choice {
  std::string what;  ///< "luminance"
  std::string text;  ///< one line
};

/// What the march of a view computes, what it leaves out because the picture does not depend on it,
/// and why. Light may still be pending.
std::vector<Choice> explain(const View& view, const MediumAtlas& atlas);

}  // namespace psivox
