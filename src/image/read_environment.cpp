#include "read_environment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/trigonometric.hpp>
#include <string>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "scene/environment.h"

namespace psivox {

Environment read_environment(const Scene& scene) {
  const Image image = read_image(scene.environment);
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::input, "--environment " + in_quotes(scene.environment) + ": " + why);
  };
  if (image.width != 2 * image.height)
    fail("a latitude-longitude map is twice as wide as high, and it has " +
         std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels");
  const auto rgba = image.rgba();
  const float scale = float(scene.environment_scale);
  std::vector<glm::vec3> radiance;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const glm::vec3 value(rgba[i], rgba[i + 1], rgba[i + 2]);
    if (!std::isfinite(value.x + value.y + value.z)) fail("it has pixels that are NaN or Inf");
    radiance.push_back(scale * glm::max(value, glm::vec3(0)));  // sharpening filters go below 0
  }
  if (std::ranges::all_of(radiance, [](const glm::vec3& L) { return L == glm::vec3(0); }))
    fail("it is black");
  return {{image.width, image.height},
          std::move(radiance),
          scene.up_axis == UpAxis::z,
          glm::radians(scene.environment_rotation)};
}

}  // namespace psivox
