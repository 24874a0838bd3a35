#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "psivox/camera.h"
#include "psivox/image.h"
#include "psivox/medium.h"

// Views of in-memory fields, and the pixels of their pictures. verify and the tests use them.

namespace psivox {

/// A square picture of a few pixels; rays never end early.
inline Scene small_scene(int side = 48, double extinction = 1) {
  Scene scene;
  scene.resolution = {side, side};
  scene.early_termination = 0;
  scene.extinction = extinction;
  return scene;
}

inline std::shared_ptr<const Field> share(Field field) {
  return std::make_shared<const Field>(std::move(field));
}

enum class Glow { constant, density };

inline View view_of(const Scene& scene, std::shared_ptr<const Field> density,
                    Glow glow = Glow::constant) {
  return make_view(scene, density, glow == Glow::density ? density : nullptr);
}
inline View view_of(const Scene& scene, Field density, Glow glow = Glow::constant) {
  return view_of(scene, share(std::move(density)), glow);
}
inline View view_of(const Scene& scene, Field density, Field luminance) {
  return make_view(scene, share(std::move(density)), share(std::move(luminance)));
}

/// Looks at `target` from `position`; orthographic, `width` world units wide, if `width` is given.
inline Scene looking(Scene scene, const glm::dvec3& position, const glm::dvec3& target,
                     std::optional<double> width = {}) {
  scene.camera_position = position;
  scene.camera_target = target;
  if (width) {
    scene.projection = Projection::orthographic;
    scene.ortho_width = width;
  }
  return scene;
}

inline Scene with(Scene scene, Integrator rule, std::optional<double> step) {
  scene.integrator = rule;
  scene.step = step;
  return scene;
}

/// Ray of a pixel's centre.
inline WorldRay pixel_ray(const View& view, int x, int y) {
  return camera_ray(view.camera, view.scene.resolution, x + 0.5, y + 0.5);
}

inline float pixel(const Image& image, int x, int y, int channel) {
  return image.rgba()[4 * image.index(x, y) + std::size_t(channel)];
}

/// Calls f(ray, rgba) for each pixel of the view's picture: the ray of its centre, and a pointer to
/// its four floats.
template <typename Function>
void for_pixels(const View& view, const Image& image, Function f) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      f(pixel_ray(view, x, y), &image.rgba()[4 * image.index(x, y)]);
}

inline double mean_alpha(const Image& image) {
  double sum = 0;
  const auto rgba = image.rgba();
  for (std::size_t i = 3; i < rgba.size(); i += 4) sum += rgba[i];
  return sum / (double(image.width) * double(image.height));
}

}  // namespace psivox
