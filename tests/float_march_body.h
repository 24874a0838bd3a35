// No include guard: the march in float32 as PSIVOX_FLOAT_MARCH, compiled with the including file's
// options. PSIVOX_IN_ONE_FUNCTION may be an attribute.
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <glm/vec4.hpp>

#include "atlas/brick_code.h"
#include "float_march.h"
#include "march/glsl_subset.h"

namespace psivox {
namespace {

using glm::abs;
using glm::clamp;
using glm::dot;
using glm::floor;
using glm::max;
using glm::min;
using glm::mix;
using std::pow;
using std::sqrt;

using real = float;
using real2 = glm::vec2;
using real3 = glm::vec3;
using real4 = glm::vec4;
using int3 = glm::ivec3;
using uint = std::uint32_t;
using uint4 = glm::uvec4;

struct Grid {
#define PARAMETER(type, name) type name{};
#include "grid_parameters.glsl"
#undef PARAMETER
  Grid() = default;
  explicit Grid(const glsl::Grid& grid) {
#define PARAMETER(type, name) name = type(grid.name);
#include "grid_parameters.glsl"
#undef PARAMETER
  }
};

real power_of_two(int n) { return std::ldexp(1.0f, n); }

struct AtlasMarch {
#define REAL_BITS 32
#define precise volatile  // rounded by itself
#include "march/atlas_members.h"
};

template <typename Body>
void for_pixels(const MarchSetup& setup, const MediumAtlas& atlas, int width,
                std::span<FloatRay> rays, const Body& body) {
  const auto row = std::size_t(width);
  tbb::parallel_for(std::size_t(0), rays.size() / row, [&](std::size_t y) {
    AtlasMarch march(setup, atlas);
    for (std::size_t x = 0; x < row; ++x)
      body(march, march.make_pixel(real2(x, y)), rays[y * row + x]);
  });
}

void make_ray(AtlasMarch& march, const AtlasMarch::Pixel& pixel, FloatRay& out) {
  const AtlasMarch::Ray ray = march.march_ray_of(pixel);
  static_assert(sizeof ray <= sizeof out.ray);
  std::memcpy(out.ray.data(), &ray, sizeof ray);
}

PSIVOX_IN_ONE_FUNCTION void march_ray(AtlasMarch& march, const AtlasMarch::Pixel& pixel,
                                      FloatRay& out) {
  AtlasMarch::Ray ray;
  std::memcpy(&ray, out.ray.data(), sizeof ray);
  AtlasMarch::March m = march.begin_march(ray);
  march.aim(m, pixel);
  march.march(m, ray);
  out.picture = march.drawn(m, ray);
  out.end = ray.end;
  out.reached = m.t;
  out.stuck = m.stuck;
}

}  // namespace

const FloatMarch PSIVOX_FLOAT_MARCH{
    [](const MarchSetup& setup, const MediumAtlas& atlas, int width, std::span<FloatRay> rays) {
      for_pixels(setup, atlas, width, rays, make_ray);
    },
    [](const MarchSetup& setup, const MediumAtlas& atlas, int width, std::span<FloatRay> rays) {
      for_pixels(setup, atlas, width, rays, march_ray);
    }};

}  // namespace psivox
