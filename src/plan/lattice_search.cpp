#include "plan/lattice_search.h"

#include <algorithm>
#include <cmath>

namespace psivox {

namespace {

/// A lattice is left if its first rays suggest that it costs this many times the best method.
constexpr double far_cost = 2;

/// A lattice between two is tried if it may save this part of the time: trying it takes about a
/// hundredth of the picture's.
constexpr double worth = 0.03;

}  // namespace

void LatticeSearch::search() {
  const double widest = std::min(widest_step, trials_.widest(worst_brick));
  search_steps(widest, 0, worst_brick);
  const std::optional<Trial> first = found();
  if (!first) return;
  const double step = first->method.step;
  search_steps(std::min(widest, 8 * step), step, narrow_brick);
}

std::optional<Trial> LatticeSearch::found() const {
  const auto cheapest =
      std::min_element(accepted_.begin(), accepted_.end(),
                       [](const Trial& a, const Trial& b) { return a.cost < b.cost; });
  if (cheapest == accepted_.end() || !beats_best(*cheapest, 1)) return {};
  return *cheapest;
}

std::optional<Trial> LatticeSearch::settle() {
  const Trial tried = *found();
  const Trial whole = trials_.finish(tried);
  if (whole.accepted) return whole;
  std::erase_if(accepted_, [&](const Trial& trial) {
    return trial.method == tried.method && trial.worst_brick == tried.worst_brick;
  });
  std::optional<Trial> finer;  // the next one
  for (const Trial& trial : accepted_)
    if (trial.worst_brick == whole.worst_brick && trial.method.step < whole.method.step &&
        (!finer || trial.method.step > finer->method.step))
      finer = trial;
  if (finer)
    widen(whole, *finer);
  else
    search_steps(whole.method.step / 2, 0, whole.worst_brick, whole);
  return {};
}

Trial LatticeSearch::run(double step, double brick) {
  const Trial trial = trials_.try_out(lattice(trials_.view(), step), brick,
                                      [&](const Trial& first) { return may_win(first, far_cost); });
  if (trial.accepted) accepted_.push_back(trial);
  return trial;
}

bool LatticeSearch::beats_best(const Trial& trial, double factor) const {
  if (!best_.accepted) return true;
  return std::min({trial.cost, trials_.cost_by(Integrator::porter_duff, trial),
                   trials_.cost_by(Integrator::midpoint, trial)}) <= factor * best_.cost;
}

bool LatticeSearch::may_win(const Trial& trial, double factor) const {
  if (const auto lattice = found()) return trial.cost <= factor * lattice->cost;
  return beats_best(trial, factor);
}

void LatticeSearch::search_steps(double first, double last, double brick,
                                 std::optional<Trial> coarse) {
  for (double step = first; step >= std::max(1.1 * last, narrowest_step); step /= 2) {
    const Trial fine = run(step, brick);
    if (fine.accepted) {
      if (coarse) widen(*coarse, fine);
      return;
    }
    if (!may_win(fine, 1)) return;
    coarse = fine;
  }
}

void LatticeSearch::widen(Trial coarse, Trial fine) {
  for (int i = 0; i < 3 && coarse.method.step > 1.12 * fine.method.step &&
                  coarse.cost < (1 - worth) * fine.cost;
       ++i) {
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
