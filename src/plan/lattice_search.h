#pragma once

#include "plan/trials.h"

namespace psivox {

/// Finds the cheapest lattice that is accurate enough. It searches with the rule of lattice(), on a
/// part of the pilot's rays.
class LatticeSearch {
 public:
  /// `best`: the cheapest method so far, which a lattice must beat if that method is accepted.
  LatticeSearch(Trials& trials, const Trial& best) : trials_(trials), best_(best) {}

  /// Searches lattices with steps as wide as bricks allow. In case bricks require small steps
  /// everywhere, it then searches wider lattices whose bricks keep narrower steps.
  void search();

  /// The cheapest lattice that was accepted so far, perhaps on a part of the pilot's rays. Unset if
  /// none is, or if it cannot win.
  std::optional<Trial> found() const;
  /// Runs found() on all rays. If it is refused there, searches on and returns nothing.
  std::optional<Trial> settle();

 private:
  /// Halves the step, starting at `first`, until the error is small enough, then widens it as far
  /// as the error allows, below `coarse`. Stops when no lattice wider than `last` can be cheaper.
  void search_steps(double first, double last, double brick, std::optional<Trial> coarse = {});
  void widen(Trial coarse, Trial fine);
  Trial run(double step, double brick);
  /// Whether a lattice takes less than `factor` times the time of `best`, perhaps by a simpler
  /// rule.
  bool beats_best(const Trial& trial, double factor) const;
  /// Whether it, or a narrower one, may still be the cheapest, if times may be off by that factor.
  bool may_win(const Trial& trial, double factor) const;

  Trials& trials_;
  const Trial& best_;
  std::vector<Trial> accepted_;
};

}  // namespace psivox
