#pragma once

#include <functional>
#include <vector>

#include "march/glsl_subset.h"
#include "march/march_parameters.h"
#include "march/psi_table.h"

namespace psivox::glsl {

/// The march in double along one ray over fields that are formulas, no voxels: functions of t
/// alone. The page table is one brick over the whole domain, whose "hardware" filter is the
/// formula.
struct AnalyticMarch {
  std::function<double(double)> fields[2];  ///< value and luminance at x

  static constexpr int half_width = 256;  ///< [cells] of the one brick: t within -256 to 256

  real4 fetch_table(int i) const {
    static const std::vector<glm::vec4> table = make_psi_table();
    return real4(table[std::size_t(i)]);
  }
  uint fetch_page(int, int) const { return make_entry(EntryKind::brick, 0); }
  real fetch_constant(int, int) const { return 0; }
  real3 fetch_constant3(int, int) const { return real3(0); }
  real fetch_texel(int, int) const { return 0; }
  real3 fetch_texel3(int, int) const { return real3(0); }
  real filtered_texel(int grid, int, real3 local) const {
    return fields[grid](local.x - half_width);
  }
  real3 filtered_texel3(int, int, real3) const { return real3(0); }

#include "march/march_members.h"

  /// A ray along x, t = x, from `first` (the camera, or the box) to `last` (the box's face).
  /// Lattice points are at multiples of `h` from `phase` on. `unit`: opacity_linear's of length.
  March along_x(Integrator rule, double first, double last, double h, double phase,
                double unit = 1) {
    integrator = rule;
    middle_rule = info(rule).samples_middle;
    exact_depth = info(rule).exact_depth;
    luminance_source = SOURCE_SCALAR;
    uniform_sampling = hardware_filter = attenuates = ends_early = true;
    density_levels = luminance_levels = 3;
    density_table_min = luminance_table_min = int3(-half_width);
    density_table_size = luminance_table_size = int3(1);
    density_domain_min = luminance_domain_min = int3(-half_width);
    density_domain_max = luminance_domain_max = int3(half_width);
    density_anchor_0 = luminance_anchor_0 = real3(phase, 0.5, 0.5);
    density_direction_0 = luminance_direction_0 = real3(1, 0, 0);
    stop_depth = 1e30;
    step = h;
    opacity_unit = unit;
    max_turns = 1 << 30;
    color = real3(1);
    const Pixel p(0, 0, 1);
    Ray ray = density_ray(p);
    ray.begin = first - phase;
    ray.end = last - phase;
    return march_on(begin_march(ray), p, ray);
  }
};

}  // namespace psivox::glsl
