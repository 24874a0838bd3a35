#pragma once

#include <cmath>
#include <vector>

#include "march/glsl_subset.h"
#include "march/march_tables.h"

// shaders/math and shaders/integrators as C++, in the GPU's precision and in double. Every line of
// them is + - * /, comparisons and floor (decay.glsl has its own exp and log), so float here rounds
// as any GPU does that keeps IEEE rules.

namespace psivox {

/// Built once a process.
inline const std::vector<glm::vec4>& shared_psi_table() {
  static const std::vector<glm::vec4> table = make_psi_table();
  return table;
}

}  // namespace psivox

namespace psivox::glsl32 {

using glm::abs;
using glm::clamp;
using glm::floor;
using glm::max;
using glm::min;
using std::pow;
using std::sqrt;

struct Math {
  using real = float;
  using real4 = glm::vec4;
  real opacity_unit = 1;
  int psi_table_first = 0;
  real4 fetch_table(int i) const { return real4(shared_psi_table()[std::size_t(i)]); }
  float power_of_two(int n) const { return std::ldexp(1.0f, n); }

#define precise
#define REAL_BITS 32
#include "formulas.glsl"
// uses the formulas
#include "all_integrators.h"
#undef REAL_BITS
#undef precise
};

}  // namespace psivox::glsl32

namespace psivox::glsl {

struct Math {
  using real = double;
  real opacity_unit = 1;
  int psi_table_first = 0;
  real4 fetch_table(int i) const { return real4(shared_psi_table()[std::size_t(i)]); }

#define precise
#define REAL_BITS 64
#include "formulas.glsl"
// uses the formulas
#include "all_integrators.h"
#undef REAL_BITS
#undef precise
};

}  // namespace psivox::glsl
