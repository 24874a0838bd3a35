#pragma once

#include <functional>

#include "psivox/integrators.h"

namespace psivox {

/// A rule's weights of the luminance at its segment's front, middle and back, and its optical
/// depth.
struct RuleWeights {
  double front = 0, middle = 0, back = 0, depth = 0;
};

/// What a rule gives for a segment of length 1 (and one `--opacity-unit`) whose attenuation is
/// linear from x_f to x_b, its optical lengths: in the GPU's precision, in which the ends are
/// rounded too, and in double. The rule is a segment rule (is_segment_rule).
RuleWeights rule_weights_float(Integrator rule, double x_f, double x_b);
RuleWeights rule_weights_double(Integrator rule, double x_f, double x_b);

/// A ray along x through fields that are formulas, no voxels: what is left is the step's own error.
struct FormulaRay {
  std::function<double(double x)> tau;        ///< attenuation [1/unit of x]
  std::function<double(double x)> luminance;  ///< of the medium
  double first = 0, last = 0;                 ///< the camera or the box, and the box's face
};

/// Where the samples stand: at multiples of `step` from `phase` on [units of x].
struct Lattice {
  double step = 1, phase = 0;
  bool end_corrections = false;
};

struct FormulaSum {
  double radiance = 0, optical_depth = 0;
};

/// The march in double along the ray, by a rule of segments; x within -256 to 256.
FormulaSum march_formula(Integrator rule, const FormulaRay& ray, const Lattice& lattice);

}  // namespace psivox
