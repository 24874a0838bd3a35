#include "formula_march.h"

#include "march/glsl_subset.h"
#include "march/march_parameters.h"
#include "march/march_tables.h"
#include "march/shader_math.h"

namespace psivox {
namespace {

template <typename Math>
RuleWeights weights(Integrator rule, double front, double back) {
  using real = typename Math::real;
  Math math;
  const real x_f = real(front), x_b = real(back);
  const real depth = real(0.5) * x_f + real(0.5) * x_b;
  const typename Math::Segment segment{x_f, depth, x_b, 1, depth};
  const auto evaluate = [&]() -> typename Math::Weights {
    switch (rule) {
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  case Integrator::name:                            \
    return math.name(segment);
      PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
      default:
        return typename Math::Weights(0, 0, 0, 0);
    }
  };
  const auto w = evaluate();
  return {double(w.front), double(w.middle), double(w.back), double(w.depth)};
}

}  // namespace

RuleWeights rule_weights_float(Integrator rule, double x_f, double x_b) {
  return weights<glsl32::Math>(rule, x_f, x_b);
}

RuleWeights rule_weights_double(Integrator rule, double x_f, double x_b) {
  return weights<glsl::Math>(rule, x_f, x_b);
}

namespace glsl {

/// The page table is one brick over the whole domain, whose "hardware" filter is the formula.
struct FormulaMarch {
  const FormulaRay* formulas = nullptr;

  static constexpr int half_width = 256;  ///< [cells] of the one brick

  real4 fetch_table(int i) const { return real4(shared_psi_table()[std::size_t(i)]); }
  uint fetch_page(int, int) const { return make_entry(EntryKind::brick, 0); }
  real fetch_constant(int, int) const { return 0; }
  real3 fetch_constant3(int, int) const { return real3(0); }
  real fetch_texel(int, int) const { return 0; }
  real3 fetch_texel3(int, int) const { return real3(0); }
  real4 fetch_pair(int) const { return real4(0); }
  uint4 fetch_code(int) const { return {}; }
  real real_of_bits(uint) const { return 0; }
  static bool is_nan(real) { return false; }
  real filtered_texel(int grid, int, real3 local) const {
    const real x = local.x - half_width;
    return grid == density_grid ? formulas->tau(x) : formulas->luminance(x);
  }
  real3 filtered_texel3(int, int, real3) const { return real3(0); }

#include "march/march_members.h"

  March along_x(Integrator rule, const FormulaRay& ray_of_formulas, const Lattice& lattice) {
    formulas = &ray_of_formulas;
    integrator = rule;
    end_corrections = lattice.end_corrections;
    middle_rule = info(rule).samples_middle;
    exact_depth = info(rule).exact_depth;
    luminance_source = SOURCE_SCALAR;
    uniform_sampling = hardware_filter = attenuates = ends_early = true;
    density_levels = luminance_levels = 3;
    density.table_min = int3(-half_width);
    density.table_size = int3(1);
    density.domain_min = int3(-half_width);
    density.domain_max = int3(half_width);
    density.anchor_0 = real3(lattice.phase, 0.5, 0.5);
    density.direction_0 = real3(1, 0, 0);
    luminance = density;
    extinction = 1;
    stop_depth = 1e30;
    step = lattice.step;
    opacity_unit = 1;
    max_turns = 1 << 30;
    color = real3(1);
    derive();
    const Pixel p(0, 0, 1, 0, 0);
    Ray ray = grid_ray(p, density);
    ray.begin = ray_of_formulas.first - lattice.phase;
    ray.end = ray_of_formulas.last - lattice.phase;
    March m = begin_march(ray);
    aim(m, p);
    march(m, ray);
    return m;
  }
};

}  // namespace glsl

FormulaSum march_formula(Integrator rule, const FormulaRay& ray, const Lattice& lattice) {
  const auto m = glsl::FormulaMarch().along_x(rule, ray, lattice);
  return {m.radiance.x, m.optical_depth};
}

}  // namespace psivox
