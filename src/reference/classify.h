#pragma once

#include <array>
#include <vector>

#include "piece.h"
#include "scene/transfer_function.h"

namespace psivox {

/// A part of a cubic of values between two knots of a transfer function: attenuation and colour are
/// cubics over it.
struct ClassifiedPart {
  double begin = 0, end = 1;  ///< u
  Cubic attenuation{};
  std::array<Cubic, 3> color{};
  double attenuation_error = 0;  ///< bounds on both from rounding of the value and from fits
  double color_error = 0;
};

/// Cuts the values where they pass through the knots.
void classify(const TransferFunction& function, const Cubic& value,
              std::vector<ClassifiedPart>& parts);

/// Cuts a function of value and gradient, whose magnitude is another cubic, into parts that cubics
/// fit. `attenuation_error` has the error of the fit.
void classify(const TransferFunction& function, const Cubic& value, const Cubic& gradient,
              std::vector<ClassifiedPart>& parts);

/// One part between two knots of the values, from the points alone.
ClassifiedPart classify_part(const TransferFunction& function, const Cubic& value, double begin,
                             double end);

}  // namespace psivox
