#pragma once

#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// A look as its file has it.
struct LookFile {
  Scene scene;                       ///< its parameters: those that are given
  std::vector<std::string> choices;  ///< its list `choose`
};

/// Throws Error(usage) that lists the looks if there is none of that name, or names what is wrong.
LookFile read_look(const std::string& name);

}  // namespace psivox
