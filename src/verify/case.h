#pragma once

#include <string>
#include <vector>

#include "psivox/marcher.h"
#include "psivox/medium.h"
#include "psivox/verify.h"

namespace psivox {

/// A picture that the device must draw as the CPU does in double.
struct Case {
  std::string name;
  std::string reason;  ///< for the bound
  double bound;        ///< on the largest difference of a channel, with the exact filter
  /// What the picture changes by at most, per error of 1 in every interpolation weight. Times 2^-8
  /// it bounds what the hardware filter may add.
  double weights;
  View view;
  /// The truth is the march in double by the view's rule; else it is the reference, which is
  /// another algorithm.
  bool by_rule = false;
};

std::vector<Case> verify_cases();

/// The error that a case finds, with the bound for that filter.
VerifyCase run_case(const Case& c, Marcher& gpu, Filter filter);

/// Largest |a - b| over R G B A; NaN if one is.
double largest_difference(const Image& a, const Image& b);

}  // namespace psivox
