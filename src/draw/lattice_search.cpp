#include "draw/lattice_search.h"

#include <algorithm>
#include <cmath>

namespace psivox {

void LatticeSearch::search() {
  double widest = widest_step;
  while (widest > trials_.widest(worst_brick) && widest >= narrowest_step) widest /= 2;
  search_steps(widest, 0, worst_brick);
  if (!found_) return;
  const double found = found_->method.step;
  search_steps(std::min(widest, 8 * found), found, narrow_brick);
}

Trial LatticeSearch::run(double step, double brick) {
  const Trial trial = trials_.run(lattice(step), brick);
  if (trial.accepted && (!found_ || trial.cost < found_->cost)) found_ = trial;
  return trial;
}

/// Whether a lattice narrower than this rejected one may still be the cheapest, perhaps by a
/// simpler rule.
bool LatticeSearch::may_win(const Trial& trial) {
  if (found_) return trial.cost <= found_->cost;
  return std::min({trial.cost, trials_.cost_by(Integrator::porter_duff, trial),
                   trials_.cost_by(Integrator::midpoint, trial)}) <= best_.cost;
}

void LatticeSearch::search_steps(double first, double last, double brick) {
  std::optional<Trial> coarse;
  for (double step = first; step >= std::max(1.1 * last, narrowest_step); step /= 2) {
    const Trial next{.method = lattice(step), .worst_brick = brick};
    if (best_.accepted && trials_.costs_far_more(next, best_.cost)) return;
    const Trial fine = run(step, brick);
    if (fine.accepted) {
      if (coarse) widen(*coarse, fine);
      return;
    }
    if (!may_win(fine)) return;
    coarse = fine;
  }
}

void LatticeSearch::widen(Trial coarse, Trial fine) {
  for (int i = 0; i < 3 && coarse.method.step > 1.12 * fine.method.step; ++i) {
    const double steps = coarse.method.step / fine.method.step;
    const double order = std::log(coarse.rms / fine.rms) / std::log(steps);
    double ratio = order > 0.5 ? std::pow(trials_.target() / fine.rms, 1 / order) : 1;
    if (coarse.rms <= trials_.target())
      ratio = std::sqrt(steps);  // the RMS is small enough: one ray is off
    ratio = std::clamp(ratio, 1.1, 0.95 * steps);
    const Trial between = run(fine.method.step * ratio, fine.worst_brick);
    (between.accepted ? fine : coarse) = between;
  }
}

}  // namespace psivox
