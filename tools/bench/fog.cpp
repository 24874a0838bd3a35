#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "bench.h"
#include "psivox/dense_field.h"

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
  const double half = n / 2, voxel = 1 / half;
  const glm::dmat4 place =
      glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(voxel)), glm::dvec3(-half));
  DenseField field("density", glm::ivec3(n), 1, place);
  std::vector<float> slab(std::size_t(8 * n * n));
  for (int x = 0; x < n; x += 8) {
    tbb::parallel_for(0, 8 * n, [&](int row) {
      float* to = slab.data() + std::size_t(row) * std::size_t(n);
      for (int z = 0; z < n; ++z)
        to[z] = fog_value((glm::dvec3(x + row / n, row % n, z) - half) * voxel);
    });
    field.add(slab);
  }
  return field.finish();
}

}  // namespace psivox::bench
