#pragma once

#include <functional>
#include <span>
#include <string>

#include "psivox/scene.h"

namespace psivox::view {

/// A slider of one number. Values outside its ends stay until it is dragged.
bool slide(const char* label, double& value, double least, double most, const char* format);

/// Values that the open file offers for parameters.
struct ParameterChoices {
  std::span<const std::string> grids;
  double extinction = 1;  ///< the number that `auto` chose
};

/// Called with the reason for which a value was refused.
using Refuse = std::function<void(const std::string& why)>;

/// Widgets for all parameters but those of the window, made from the table of parameters. True if
/// the scene was changed; it is valid then. A refused parameter keeps its value.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse);

/// Widgets for the parameters named, without headers.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse,
                     std::span<const char* const> names);

}  // namespace psivox::view
