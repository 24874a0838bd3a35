#pragma once

#include <cstdlib>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>

#include "psivox/image.h"

namespace psivox {

/// Writes a test's picture as NAME.png to the folder named by the environment variable
/// PSIVOX_FIGURES, if set.
inline void write_figure(const std::string& name, const Image& image) {
  const char* folder = std::getenv("PSIVOX_FIGURES");
  if (folder) write_image(image, std::filesystem::path(folder) / (name + ".png"));
}

/// An opaque white picture.
inline Image blank_figure(int width, int height) { return rgba_image(width, height, 1); }

inline void put_pixel(Image& image, int x, int y, const glm::dvec3& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  for (int c = 0; c < 3; ++c)
    image.rgba()[std::size_t((y * image.width + x) * 4 + c)] = float(color[c]);
}

}  // namespace psivox
