#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

#include "bench.h"

namespace psivox::bench {
namespace {

struct Sphere {
  glm::dvec3 centre;
  double radius;
  double density;
};

constexpr Sphere spheres[] = {{{0, 0, 0}, .42, .8},          {{.42, .18, -.20}, .34, .9},
                              {{-.40, -.25, .22}, .38, .75}, {{.05, .50, .30}, .28, 1.0},
                              {{-.30, .42, -.38}, .24, 1},   {{.38, -.46, .34}, .26, .9},
                              {{-.02, -.38, -.50}, .30, .7}};

double lattice_value(const glm::ivec3& at) {
  std::uint32_t n = std::uint32_t(at.x) * 0x8da6b343u ^ std::uint32_t(at.y) * 0xd8163841u ^
                    std::uint32_t(at.z) * 0xcb1ab31fu;
  n ^= n >> 15;
  n *= 0x2c1b3c6du;
  n ^= n >> 12;
  n *= 0x297a2d39u;
  n ^= n >> 15;
  return n / 4294967295.0;
}

double value_noise(const glm::dvec3& p) {
  const glm::ivec3 cell(glm::floor(p));
  const glm::dvec3 f = glm::fract(p);
  const glm::dvec3 u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  double planes[2];
  for (int z = 0; z < 2; ++z) {
    double rows[2];
    for (int y = 0; y < 2; ++y)
      rows[y] = glm::mix(lattice_value(cell + glm::ivec3(0, y, z)),
                         lattice_value(cell + glm::ivec3(1, y, z)), u.x);
    planes[z] = glm::mix(rows[0], rows[1], u.y);
  }
  return glm::mix(planes[0], planes[1], u.z);
}

double fractal_noise(glm::dvec3 p) {
  double amplitude = 0.5, sum = 0, norm = 0;
  for (int octave = 0; octave < 4; ++octave) {
    sum += amplitude * value_noise(p);
    norm += amplitude;
    amplitude *= 0.5;
    p = p * glm::dvec3(2.02, 2.03, 2.01) + glm::dvec3(17.3, 5.1, -9.7);
  }
  return sum / norm;
}

float fog_value(const glm::dvec3& p) {
  double density = 0;
  for (const Sphere& s : spheres) {
    const glm::dvec3 d = p - s.centre;
    const double q = glm::dot(d, d) / (s.radius * s.radius);
    if (q < 1) density += s.density * (1 - q) * (1 - q);
  }
  if (density > 0) density *= std::max(0.0, (fractal_noise(p * 6.0 + 100.0) - 0.30) * 2.6);
  density = std::min(1.0, density);
  return density < 1e-3 ? 0.0f : float(density);
}

}  // namespace

Field make_fog(int n) {
  const int half = n / 2;
  const double voxel = 1.0 / half;
  const int blocks = n / 8;
  struct Storage {
    std::vector<float> values;
    std::vector<std::uint32_t> active;  // per block
  };
  auto storage = std::make_shared<Storage>();
  storage->values.resize(std::size_t(blocks * blocks * blocks) * 512);
  storage->active.resize(std::size_t(blocks * blocks * blocks));
  tbb::parallel_for(0, blocks, [&](int bx) {
    for (int by = 0; by < blocks; ++by)
      for (int bz = 0; bz < blocks; ++bz) {
        const std::size_t b = std::size_t((bx * blocks + by) * blocks + bz);
        float* to = storage->values.data() + b * 512;
        for (int i = 0; i < 512; ++i) {
          const glm::ivec3 at(bx * 8 + (i >> 6), by * 8 + (i >> 3 & 7), bz * 8 + (i & 7));
          to[i] = fog_value(glm::dvec3(at - half) * voxel);
          storage->active[b] += to[i] > 0;
        }
      }
  });

  Field field;
  field.name = "density";
  field.value_type = "float";
  field.world_from_index = glm::scale(glm::dmat4(1), glm::dvec3(voxel));
  field.active_box = {glm::ivec3(half), glm::ivec3(-half)};
  for (int b = 0; b < blocks * blocks * blocks; ++b) {
    const std::uint32_t active = storage->active[std::size_t(b)];
    if (active == 0) continue;
    const glm::ivec3 origin =
        glm::ivec3(b / (blocks * blocks), b / blocks % blocks, b % blocks) * 8 - half;
    const float* values = storage->values.data() + std::size_t(b) * 512;
    field.leaves.push_back({origin, values});
    field.active_voxels += active;
    for (int i = 0; i < 512; ++i) {
      if (!(values[i] > 0)) continue;
      const glm::ivec3 at = origin + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
      field.active_box.min = glm::min(field.active_box.min, at);
      field.active_box.max = glm::max(field.active_box.max, at);
    }
  }
  field.storage = storage;
  return field;
}

}  // namespace psivox::bench
