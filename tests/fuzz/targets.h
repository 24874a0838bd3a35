#pragma once

#include <span>
#include <string_view>

namespace psivox::fuzz {

/// A reader of what others wrote. For any bytes it must return or throw psivox::Error; anything
/// else is a finding.
struct Target {
  std::string_view name;  ///< of its folder in corpus/ too
  void (*read)(std::string_view bytes);
};

std::span<const Target> targets();

/// Runs the target and takes psivox::Error from it. Throws std::logic_error if there is no such
/// target.
void run(std::string_view target, std::string_view bytes);

}  // namespace psivox::fuzz
