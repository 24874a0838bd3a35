#pragma once

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

}  // namespace psivox
