#pragma once

/// The tables of integrators: one row each, the formula in shaders/integrators/<name>.glsl.
/// X(name, samples_middle, exact_depth, help): samples_middle: the rule reads its segment's middle
/// and not its ends; exact_depth: it takes the segment's optical depth as given (from the cell's
/// cubic, or of linear attenuation), not from its own homogeneous model.
// clang-format off
/// Rules for one segment: Weights name(Segment).
#define PSIVOX_SEGMENT_INTEGRATORS(X)                                                             \
  X(porter_duff,  false, false, "homogeneous step of the front sample (thesis eq. 14)")           \
  X(midpoint,     true,  false, "homogeneous step of the middle sample: the honest baseline")     \
  X(psi_weighted, false, true,  "Moreland's weighted opacity, 0.27 and 0.73 (thesis eq. 65)")     \
  X(psi_balanced, false, true,  "weights balanced against the lattice's bias: fourth order on smooth data")
/// Rules for the cubic of a cell, with --sampling cells only: Weights name(Cubic, real).
#define PSIVOX_CELL_INTEGRATORS(X)                                                                \
  X(cell_exact,   false, true,  "Gauss-Legendre on the cell's cubic, its own optical depth; cells only")
// clang-format on
#define PSIVOX_INTEGRATORS(X)   \
  PSIVOX_SEGMENT_INTEGRATORS(X) \
  PSIVOX_CELL_INTEGRATORS(X)

namespace psivox {

enum class Integrator : int {
#define PSIVOX_ROW(name, middle, exact, help) name,
  PSIVOX_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
};

/// Integrates cells, not segments.
constexpr bool is_cell_rule(Integrator id) {
  switch (id) {
#define PSIVOX_ROW(name, middle, exact, help) \
  case Integrator::name:                      \
    return true;
    PSIVOX_CELL_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
    default:
      return false;
  }
}

/// A row of the table. `name` is also that of the rule's GLSL function and file.
struct IntegratorInfo {
  Integrator id;
  const char* name;  ///< with underscores; the command line's has dashes
  bool samples_middle;
  bool exact_depth;
  const char* help;
};

inline constexpr IntegratorInfo integrators[] = {
#define PSIVOX_ROW(name, middle, exact, help) {Integrator::name, #name, middle, exact, help},
    PSIVOX_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
};

constexpr const IntegratorInfo& info(Integrator id) { return integrators[static_cast<int>(id)]; }

}  // namespace psivox
