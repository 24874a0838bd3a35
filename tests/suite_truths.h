#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "closed_forms.h"

// The exact values of some scenes of the precision suite.

namespace psivox {

/// Length along x where the plate's value, linear between voxels, is above a level [voxels].
inline double width_above(const Plate& plate, double level) {
  double sum = 0;
  for (int x = -1; x < int(plate.values.size()); ++x) {
    const double a = plate.value(x) - level, b = plate.value(x + 1) - level;
    sum += a > 0 && b > 0 ? 1 : a > 0 || b > 0 ? std::max(a, b) / std::abs(a - b) : 0;
  }
  return sum;
}

/// The exact value of a channel at the end of a ray.
struct SuiteTruth {
  int channel = 3;
  std::function<double(const WorldRay&)> value;
};

/// By the scenes' names.
inline std::map<std::string, SuiteTruth> suite_truths() {
  const Plate bell{profile(33, [](int x) { return std::exp(-std::pow((x - 16) / 6.0, 2)); })};
  const Plate ramp{profile(56, [](int x) { return 0.125 * std::min(x + 1, 32); })};
  const Plate turned{profile(33, [](int x) { return 0.125 * std::min(x, 12); }), {}, sheared};
  const auto opacity = [](double K, const Plate& plate) {
    return SuiteTruth{3, [=](const WorldRay& ray) { return -std::expm1(-K * plate.along(ray)); }};
  };
  return {{"gaussian", opacity(0.3, bell)},
          {"inside", opacity(0.3, bell)},
          {"ramp", {0, [=](const WorldRay& r) { return rising_glow(0.5, 0.125 * ramp.slope(r)); }}},
          {"rotated", opacity(0.3, turned)},
          {"voxel",
           {3,
            [](const WorldRay& r) {
              return -std::expm1(-2 * tent_along(r, {8, 0, -8}));
            }}},
          {"step", {3, [=](const WorldRay& ray) {
                      return -std::expm1(-0.4 * width_above(bell, double(float(0.6))) /
                                         std::abs(bell.slope(ray)));
                    }}}};
}

}  // namespace psivox
