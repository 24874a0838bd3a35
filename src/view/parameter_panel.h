#pragma once

#include <functional>
#include <span>
#include <string>

#include "psivox/scene.h"

namespace psivox::view {

/// Values that the open file offers for parameters.
struct ParameterChoices {
  std::span<const std::string> grids;
  double extinction = 1;  ///< the number that `auto` chose
};

/// Called with the reason for which a value was refused.
using Refuse = std::function<void(const std::string& why)>;

/// Makes widgets from the table of parameters, except for parameters of the window. True if
/// the scene was changed; it is valid then. A refused parameter keeps its value.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse);

/// Widgets for the parameters named, without headers.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse,
                     std::span<const char* const> names);

}  // namespace psivox::view
