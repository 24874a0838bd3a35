#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/camera.h"
#include "psivox/field.h"
#include "psivox/medium.h"

// Fields in memory and views of them, which verify, the precision suite and tests draw.

namespace psivox {

/// A field of leaves that cover `active`. `write(voxel, out)` writes the `channels` floats of each
/// active voxel; the leaves' other voxels are 0.
inline Field make_field_of(const Box& active, int channels,
                           const std::function<void(const glm::ivec3&, float*)>& write,
                           const glm::dmat4& world_from_index) {
  Field field;
  field.name = "density";
  field.value_type = channels == 3 ? "vec3s" : "float";
  field.channels = channels;
  field.active_box = active;
  field.world_from_index = world_from_index;
  if (active.empty()) return field;
  const Box blocks{active.min >> 3, active.max >> 3};
  const auto floats_per_leaf = std::size_t(512 * channels);
  auto values = std::make_shared<std::vector<float>>(count_of(blocks) * floats_per_leaf);
  float* out = values->data();
  for_points(blocks, [&](const glm::ivec3& block) {
    field.leaves.push_back({8 * block, values->data() + field.leaves.size() * floats_per_leaf});
  });
  for (const Leaf& leaf : field.leaves) {
    for (int i = 0; i < 512; ++i, out += channels) {
      const glm::ivec3 voxel = leaf.origin + leaf_voxel(i);
      if (!active.contains(voxel)) continue;
      write(voxel, out);
      ++field.active_voxels;
    }
  }
  field.storage = std::move(values);
  return field;
}

inline Field make_field(const Box& active, const std::function<float(glm::ivec3)>& value,
                        const glm::dmat4& world_from_index = glm::dmat4(1.0)) {
  return make_field_of(
      active, 1, [&](const glm::ivec3& voxel, float* out) { *out = value(voxel); },
      world_from_index);
}

inline Field make_vector_field(const Box& active, const std::function<glm::vec3(glm::ivec3)>& value,
                               const glm::dmat4& world_from_index = glm::dmat4(1.0)) {
  return make_field_of(
      active, 3,
      [&](const glm::ivec3& voxel, float* out) {
        const glm::vec3 v = value(voxel);
        for (int c = 0; c < 3; ++c) out[c] = v[c];
      },
      world_from_index);
}

/// Smooth blobs in a box of 40 x 36 x 32 voxels that starts at `at`, 0 around them.
inline float blobs_at(const glm::dvec3& p) {
  const auto blob = [&](const glm::dvec3& c, double r) {
    const glm::dvec3 d = (p - c) / r;
    return std::max(0.0, 1 - glm::dot(d, d));
  };
  return float(blob({12, 11, 12}, 9) + 0.7 * blob({26, 20, 18}, 10) + 2 * blob({20, 30, 8}, 4));
}
inline Field blobs(const glm::ivec3& at = {0, 0, 0}, const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {at, at + glm::ivec3(39, 35, 31)},
      [at](glm::ivec3 v) { return blobs_at(glm::dvec3(v - at)); }, m);
}

/// Rotated, anisotropic and sheared.
inline const glm::dmat4 sheared = [] {
  glm::dmat4 m = glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, -2, 0.5));
  m = glm::scale(m, glm::dvec3(0.3, 0.5, 1.1));
  m[2] += 0.4 * m[0] - 0.2 * m[1];
  m[3] = {2, -3, 5, 1};
  return m;
}();

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

}  // namespace psivox
