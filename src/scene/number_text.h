#pragma once

#include <charconv>
#include <string>

namespace psivox {

/// The shortest digits that read back as the same number of that type.
template <typename Number>
std::string number_text(Number value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

}  // namespace psivox
