#include "march/psi_table.h"

#include "march/glsl_subset.h"

namespace psivox {
namespace glsl {
namespace {

/// The exact share in double, and the factor that the shader multiplies by.
struct PsiTable {
  int psi_table_first = 0;
  real4 fetch_table(int) const { return real4(0); }

#define REAL_BITS 64
// each file uses the ones before it
// clang-format off
#include "math/decay.glsl"
#include "math/psi.glsl"
#include "math/mills.glsl"
#include "math/dawson.glsl"
#include "math/linear_psi.glsl"
#include "math/segment.glsl"
#include "integrators/psi_table.glsl"
  // clang-format on
#undef REAL_BITS

  /// x of a place. The limits stand for 0 and for ever: the thin share depends on the ends' ratio
  /// alone, and at 1e16 the share is at its limit to 1e-8.
  real x_at(int place) {
    if (place == 0) return 1e16;
    const real root = 2.0 * psi_table_size / place - 2.0;
    return max(root * root, 1e-9);
  }

  float value(int front, int back) {
    const real x_f = x_at(front), x_b = x_at(back);
    const Decay d = decay(0.5 * (x_f + x_b));
    return float(linear_psi(x_f, x_b, d.e).back / d.a / psi_table_factor(x_f, x_b));
  }
};

}  // namespace
}  // namespace glsl

std::vector<glm::vec4> make_psi_table() {
  glsl::PsiTable table;
  const int n = table.psi_table_size;
  std::vector<float> values;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) values.push_back(table.value(i, j));
  std::vector<glm::vec4> entries;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const float* corner = &values[std::size_t(i * (n + 1) + j)];
      entries.emplace_back(corner[0], corner[1], corner[n + 1], corner[n + 2]);
    }
  return entries;
}

}  // namespace psivox
