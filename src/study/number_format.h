#pragma once

#include <charconv>
#include <cstdio>
#include <string>

namespace psivox {

/// The shortest digits that read back as the same number.
inline std::string all_digits(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// Two significant digits as 1.3e-6, and 0 as 0.
inline std::string two_digits(double value) {
  if (value == 0) return "0";
  char text[40];
  std::snprintf(text, sizeof text, "%.1e", value);
  std::string out = text;
  const std::size_t e = out.find('e');
  if (e == std::string::npos) return out;  // inf, nan
  const int power = std::stoi(out.substr(e + 1));
  return power ? out.substr(0, e + 1) + std::to_string(power) : out.substr(0, e);
}

/// With a fixed number of decimals.
inline std::string decimals(double value, int count) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", count, value);
  return text;
}

}  // namespace psivox
