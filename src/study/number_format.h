#pragma once

#include <string>

#include "psivox/text.h"

namespace psivox {

/// Two significant digits, such as 1.3e-6; 0 is "0".
inline std::string two_digits(double value) {
  if (value == 0) return "0";
  const std::string out = formatted("%.1e", value);
  const std::size_t e = out.find('e');
  if (e == std::string::npos) return out;  // inf, nan
  const int power = std::stoi(out.substr(e + 1));
  return power ? out.substr(0, e + 1) + std::to_string(power) : out.substr(0, e);
}

/// A number with `count` decimals.
inline std::string decimals(double value, int count) { return formatted("%.*f", count, value); }

}  // namespace psivox
