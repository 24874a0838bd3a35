#pragma once

#include "draw/trials.h"

namespace psivox {

/// Widest and narrowest step tried [voxels].
inline constexpr double widest_step = 16, narrowest_step = 1.0 / 64;

/// Finds the cheapest lattice that is accurate enough. It searches with psi-balanced.
class LatticeSearch {
 public:
  /// `best`: the cheapest method so far, which a lattice must beat if that method is accepted.
  LatticeSearch(Trials& trials, const Trial& best) : trials_(trials), best_(best) {}

  /// Searches lattices with steps as wide as bricks allow. In case bricks require small steps
  /// everywhere, it then searches wider lattices whose bricks keep narrower steps.
  void search();

  /// The cheapest accepted lattice.
  const std::optional<Trial>& found() const { return found_; }

 private:
  /// Halves the step, starting at `first`, until the error is small enough, then widens it as far
  /// as the error allows. Stops when no lattice wider than `last` can be cheaper.
  void search_steps(double first, double last, double brick);
  void widen(Trial coarse, Trial fine);
  Trial run(double step, double brick);
  bool may_win(const Trial& trial);

  Trials& trials_;
  const Trial& best_;
  std::optional<Trial> found_;
};

}  // namespace psivox
