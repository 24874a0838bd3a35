#include "march/rule_weights.h"

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

}  // namespace psivox
