#pragma once

#include "draw/trials.h"

namespace psivox {

/// Widest and narrowest step that is tried [voxels].
inline constexpr double widest_step = 16, narrowest_step = 1.0 / 64;

/// Looks for the cheapest lattice that is accurate enough. Lattices are searched by psi-balanced.
class LatticeSearch {
 public:
  /// `best`: the cheapest method so far, which a lattice must beat if it is accepted.
  LatticeSearch(Trials& trials, const Trial& best) : trials_(trials), best_(best) {}

  /// Searches lattices with steps as wide as bricks allow, and then, in case those have small steps
  /// everywhere, wider ones whose bricks keep narrower steps.
  void search();

  /// The cheapest that was accepted.
  const std::optional<Trial>& found() const { return found_; }

 private:
  /// Halves the step from `first` on until the error is small, then widens it as far as that
  /// allows. Stops where no lattice that is wider than `last` can be cheaper.
  void search_steps(double first, double last, double brick);
  void widen(Trial coarse, Trial fine);
  Trial run(double step, double brick);
  bool may_win(const Trial& trial);

  Trials& trials_;
  const Trial& best_;
  std::optional<Trial> found_;
};

}  // namespace psivox
