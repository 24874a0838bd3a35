#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "psivox/image.h"
#include "verify/made.h"

// More fields in memory, for properties that any field must have, and the pixels of pictures.

namespace psivox {

/// The larger of two; NaN if either is NaN.
inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

/// Values in [0, 1), uncorrelated from voxel to voxel; about a quarter are 0.
inline float noise(const glm::ivec3& v) {
  auto mixed = [](int i, std::uint32_t factor) { return std::uint32_t(i) * factor; };
  std::uint32_t h = mixed(v.x, 73856093u) ^ mixed(v.y, 19349663u) ^ mixed(v.z, 83492791u);
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  h ^= h >> 15;
  return std::max(0.0f, float(h & 0xffffu) / 65536.0f * 1.33f - 0.33f);
}

/// Blobs and rough noise in one field, with constant and empty bricks.
inline Field mixed(const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {{-20, -12, -8}, {43, 35, 31}},
      [](glm::ivec3 v) {
        if (v.x < -2 && v.y >= 8) return 0.6f;
        if (v.x > 30) return v.y < 0 ? 0.0f : noise(v);
        return blobs_at(glm::dvec3(v));
      },
      m);
}

/// 1 over the whole domain of `mixed`, in voxels of width 12. All bricks of its leaves are
/// textured.
inline Field ones_around_mixed() {
  const glm::dmat4 m =
      glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(-28, -20, -20)), glm::dvec3(12));
  return make_field(
      {{0, 0, 0}, {7, 6, 6}}, [](glm::ivec3) { return 1.0f; }, m);
}

/// Noise beside a region of one value.
inline Field noise_beside_constant() {
  return make_field({{0, 0, 0}, {39, 31, 23}},
                    [](glm::ivec3 v) { return v.x < 16 && v.y >= 8 ? 0.5f : noise(v); });
}

/// The same field, with tiles in place of leaves of one value.
inline Field with_tiles(Field field) {
  std::erase_if(field.leaves, [&](const Leaf& leaf) {
    const float value = leaf.values[0];
    if (value == 0 ||
        std::any_of(leaf.values, leaf.values + 512, [&](float other) { return other != value; }))
      return false;
    field.tiles.push_back({leaf.origin, 8, {value, 0, 0}});
    return true;
  });
  return field;
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
