#include "march/formula_march.h"

#include "march/glsl_subset.h"
#include "march/march_parameters.h"
#include "march/psi_table.h"
#include "march/shader_constants.h"

namespace psivox {
namespace glsl {

/// The page table is one brick over the whole domain, whose "hardware" filter is the formula.
struct FormulaMarch {
  const FormulaRay* formulas = nullptr;

  static constexpr int half_width = 256;  ///< [cells] of the one brick

  real4 fetch_table(int i) const {
    static const std::vector<glm::vec4> table = make_psi_table();
    return real4(table[std::size_t(i)]);
  }
  uint fetch_page(int, int) const { return make_entry(EntryKind::brick, 0); }
  real fetch_constant(int, int) const { return 0; }
  real3 fetch_constant3(int, int) const { return real3(0); }
  real fetch_texel(int, int) const { return 0; }
  real3 fetch_texel3(int, int) const { return real3(0); }
  real4 fetch_pair(int) const { return real4(0); }
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
    const Pixel p(0, 0, 1, 0);
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
