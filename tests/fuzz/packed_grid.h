#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace psivox::fuzz {

/// A bare grid of NanoVDB, of 8 MiB at most. A byte of 0 and the two behind it are so many zeros,
/// of which a grid mostly consists.
inline std::string unpacked_grid(std::string_view packed) {
  constexpr std::size_t most = 8 << 20;  // [bytes]
  std::string grid;
  for (std::size_t i = 0; i < packed.size() && grid.size() < most; ++i) {
    std::size_t count = 1;
    if (packed[i] == 0 && i + 2 < packed.size()) {
      count = static_cast<unsigned char>(packed[i + 1]);
      count += std::size_t{256} * static_cast<unsigned char>(packed[i + 2]);
    }
    grid.append(count, packed[i]);
    if (packed[i] == 0) i += 2;
  }
  return grid;
}

}  // namespace psivox::fuzz
