#pragma once

#include <optional>

#include "draw/pilot.h"

namespace psivox {

/// What a method may miss on the pilot's rays.
struct ErrorLimits {
  double rms = 0;  ///< over all rays and R G B A
  double max = 0;  ///< of one channel of a ray
};

/// A method tried on rays of the pilot, some at a time. It is refused as soon as the rays marched
/// show that all together are beyond the limits.
class Attempt {
 public:
  /// The pilot must outlive it.
  Attempt(const Method& method, double worst_brick, const MethodView& marched,
          const ErrorLimits& limits, Pilot& pilot);
  /// The exact method, whose errors the pilot knows.
  static Attempt exact(const Method& method, const MethodView& marched, const ErrorLimits& limits,
                       Pilot& pilot);

  /// What the rays so far show. The RMS and the look-ups are estimates from those in even order.
  const Trial& trial() const { return trial_; }
  const MethodView& marched() const { return marched_; }
  bool refused() const { return refused_; }
  bool complete() const { return even_ == pilot_->even_order().size(); }
  /// Errors by ray, of those marched.
  const std::vector<std::optional<RayError>>& errors() const { return errors_; }

  /// Marches the first `count` rays in even order, unless it is refused before.
  void march_evenly(std::size_t count);
  /// Marches these rays, but for those that were marched before.
  void march(std::span<const int> rays);

 private:
  void update();

  Trial trial_;
  double look_up_cost_;
  ErrorLimits limits_;
  Pilot* pilot_;
  MethodView marched_;
  std::optional<PixelMarch> march_;  ///< once it is needed
  std::vector<std::optional<RayError>> errors_;
  std::size_t even_ = 0;  ///< rays marched of the even order's beginning
  bool refused_ = false;
};

}  // namespace psivox
