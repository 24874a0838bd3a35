#pragma once

#include <glm/vec2.hpp>

#include "psivox/scene.h"

namespace psivox::view {

/// How much cheaper than the exact one a picture is made while something moves.
struct Rung {
  double divisor = 1;  ///< of width and height
  double step = 1;     ///< uniform step [voxels], where the scene's march has one to widen
  bool operator==(const Rung&) const = default;
};

/// Chooses the rung whose pictures take about as long as the budget allows, from what the last ones
/// took.
class Pace {
 public:
  explicit Pace(double budget_ms) : budget_ms_(budget_ms) {}

  Rung rung() const;
  /// What a picture of that rung took.
  void took(const Rung& rung, double ms);
  /// Another volume or scene: what is known of costs is worth little, but the rung stays.
  void forget() { known_ = false; }

 private:
  double budget_ms_;
  double cost_ms_ = 0;  ///< of the full picture, by the last ones
  bool known_ = false;
  int index_ = 5;
};

/// The scene as it is drawn on a rung: resolution, and a uniform step where its mode and rule allow
/// one (a surface is found in cells, and a rule that applies the transfer function has tables for
/// its own lengths).
Scene preview_scene(const Scene& scene, const Rung& rung);

}  // namespace psivox::view
