#pragma once

#include <functional>
#include <span>
#include <string>

#include "psivox/scene.h"

namespace psivox::view {

/// What a file offers to parameters.
struct ParameterChoices {
  std::span<const std::string> grids;
  double extinction = 1;  ///< that `auto` chose
};

/// Told why a value was refused.
using Refuse = std::function<void(const std::string& why)>;

/// Widgets for all parameters but those of the window, made from the one table. True if the scene
/// was changed; it is valid then. What is refused stays as it was.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse);

/// A few parameters without their groups' headers.
bool edit_parameters(Scene& scene, const ParameterChoices& choices, const Refuse& refuse,
                     std::span<const char* const> names);

}  // namespace psivox::view
