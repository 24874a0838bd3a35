#pragma once

/// The tables of integrators: one row each, the formula in shaders/integrators/<name>.glsl.
/// X(name, samples_middle, exact_depth, lattice_cost, help)
/// samples_middle: the rule reads its segment's middle and not its ends.
/// exact_depth: it takes the segment's optical depth as given (from the cell's cubic, or of linear
/// attenuation), not from its own homogeneous model.
/// lattice_cost: time per look-up between uniform samples, relative to psi_balanced, measured on
/// llvmpipe by tools/bench/tolerance.py. It is 1 for unmeasured rules, which --tolerance does not
/// choose.
// clang-format off
/// Rules for one segment: Weights name(Segment).
#define PSIVOX_SEGMENT_INTEGRATORS(X)                                                                     \
  X(porter_duff,      false, false, 0.8, "homogeneous step of the front sample (thesis eq. 14)")               \
  X(midpoint,         true,  false, 0.85,"homogeneous step of the middle sample: the honest baseline")         \
  X(average,          false, true, 1,   "mean luminance of the ends (thesis fig. 1.10a)")                     \
  X(linear_luminance, false, true, 1,   "linear luminance, attenuation its mean (thesis fig. 1.10b)")         \
  X(opacity_linear,   false, false, 1,   "opacity linear per --opacity-unit, Moreland's fits (thesis eq. 64, 65)") \
  X(psi_weighted,     false, true, 1,   "Moreland's weighted opacity, 0.27 and 0.73 (thesis eq. 65)")         \
  X(psi_balanced,     false, true, 1,   "weights balanced against the lattice's bias: fourth order on smooth data") \
  X(psi_exact,        false, true, 1,   "linear luminance and attenuation, exactly: scaled erfc and Dawson")  \
  X(psi_fit,          false, true, 1,   "linear luminance and attenuation, Psi as a rational function: 1e-3")    \
  X(psi_table,        false, true, 1,   "linear luminance and attenuation, Psi from a table of 128 x 128 cells")  \
  X(linear_source,    false, true, 1,   "luminance times attenuation linear, attenuation linear, exactly")
/// Rules for a cell's cubic (cells only), its weight at s: real name(Cubic, real through, real s).
#define PSIVOX_CELL_INTEGRATORS(X)                                                                        \
  X(cell_exact,       false, true, 1,   "Gauss-Legendre on the cell's cubic, its own optical depth; cells only")
/// Rules that apply the transfer function themselves to values that are linear along the segment:
/// Mixture name(real front, real back, real length).
#define PSIVOX_TRANSFER_INTEGRATORS(X)                                                            \
  X(preintegrated, false, true, 1,   "table of the transfer function between two values (Engel, Kraus, Ertl 2001)") \
  X(preintegrated_fast, false, true, 1,   "integral functions of the transfer function, no shading inside a segment")
// clang-format on
#define PSIVOX_INTEGRATORS(X)   \
  PSIVOX_SEGMENT_INTEGRATORS(X) \
  PSIVOX_CELL_INTEGRATORS(X)    \
  PSIVOX_TRANSFER_INTEGRATORS(X)

namespace psivox {

enum class Integrator : int {
#define PSIVOX_ROW(name, ...) name,
  PSIVOX_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
};

/// The input of a rule: linear segments, a cell's cubic, or values that it classifies itself.
enum class IntegratorKind { segment, cell, transfer };

/// A row of the table. `name` is also that of the rule's GLSL function and file.
struct IntegratorInfo {
  Integrator id;
  const char* name;  ///< with underscores; the command line's has dashes
  bool samples_middle;
  bool exact_depth;
  double lattice_cost;
  const char* help;
  IntegratorKind kind;
};

inline constexpr IntegratorInfo integrators[] = {
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  {Integrator::name, #name, middle, exact, cost, help, IntegratorKind::segment},
    PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  {Integrator::name, #name, middle, exact, cost, help, IntegratorKind::cell},
        PSIVOX_CELL_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
#define PSIVOX_ROW(name, middle, exact, cost, help) \
  {Integrator::name, #name, middle, exact, cost, help, IntegratorKind::transfer},
            PSIVOX_TRANSFER_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
};

constexpr const IntegratorInfo& info(Integrator id) { return integrators[int(id)]; }
constexpr bool is_cell_rule(Integrator id) { return info(id).kind == IntegratorKind::cell; }
constexpr bool is_segment_rule(Integrator id) { return info(id).kind == IntegratorKind::segment; }
constexpr bool is_transfer_rule(Integrator id) { return info(id).kind == IntegratorKind::transfer; }

}  // namespace psivox
