#include "study/report.h"

namespace psivox {

RuleSource source_of(Integrator rule) {
  switch (rule) {
    case Integrator::porter_duff:
      return {"Porter and Duff 1984", "10.1145/800031.808606"};
    case Integrator::midpoint:
    case Integrator::cell_exact:
      return {"Max 1995", "10.1109/2945.468400"};
    case Integrator::psi_exact:
    case Integrator::linear_source:
      return {"Williams, Max and Stein 1998", "10.1109/2945.675650"};
    case Integrator::preintegrated:
    case Integrator::preintegrated_fast:
      return {"Engel, Kraus and Ertl 2001", "10.1145/383507.383515"};
    default:
      return {"Moreland and Angel 2004", "10.1109/SVVG.2004.2"};
  }
}

}  // namespace psivox
