#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/field.h"

// Fields in memory, of any function; and some without a simple closed form, for properties that any
// field must have. verify and the tests use them.

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

/// Values in [0, 1), uncorrelated from voxel to voxel; about a quarter are 0.
inline float noise(const glm::ivec3& v) {
  auto mixed = [](int i, std::uint32_t factor) { return std::uint32_t(i) * factor; };
  std::uint32_t h = mixed(v.x, 73856093u) ^ mixed(v.y, 19349663u) ^ mixed(v.z, 83492791u);
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  h ^= h >> 15;
  return std::max(0.0f, float(h & 0xffffu) / 65536.0f * 1.33f - 0.33f);
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

/// Moreland's picture of two spheres (2004, fig. 1.10): red before blue along z, both dense in the
/// middle; they touch.
struct Spheres {
  Field density, color;
};
inline Spheres thesis_spheres() {
  const auto sphere = [](const glm::dvec3& p, const glm::dvec3& c) {
    const glm::dvec3 d = (p - c) / 12.0;
    return std::max(0.0, 1 - glm::dot(d, d));
  };
  const Box box{{0, 0, 0}, {31, 31, 55}};
  return {make_field(box,
                     [&](glm::ivec3 v) {
                       const glm::dvec3 p(v);
                       return float(sphere(p, {17, 17, 40}) + sphere(p, {14, 14, 16}));
                     }),
          make_vector_field(box, [](glm::ivec3 v) {
            const float red = float(std::clamp((v.z - 22) / 12.0, 0.0, 1.0));
            return glm::vec3(0.05f + 0.95f * red, 0.15f, 1.0f - 0.95f * red);
          })};
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

/// Rotated, anisotropic and sheared.
inline const glm::dmat4 sheared = [] {
  glm::dmat4 m = glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, -2, 0.5));
  m = glm::scale(m, glm::dvec3(0.3, 0.5, 1.1));
  m[2] += 0.4 * m[0] - 0.2 * m[1];
  m[3] = {2, -3, 5, 1};
  return m;
}();

}  // namespace psivox
