#pragma once

#include "draw/plan.h"

namespace psivox {

/// One picture in the making, by a marcher that holds the view's atlas.
class Picture {
 public:
  /// `plan`: by which it is marched; unset: by the view's own method.
  Picture(Marcher& marcher, const View& view, const Wish& wish, std::optional<MarchPlan> plan);

  void march();
  /// Estimates the error from the pilot's rays as the marcher draws them.
  void confirm_plan();
  /// Adds layer `error`. The marcher holds the atlas for exact filtering.
  void add_error(const MediumAtlas& atlas);
  Drawn finish();

 private:
  const View& marched() const { return plan_ ? plan_->march->view : view_; }
  RenderOptions options() const;
  /// Those of a small picture by the same program.
  RenderOptions pilot_options() const;

  Marcher& marcher_;
  const View& view_;
  const Wish& wish_;
  std::optional<MarchPlan> plan_;
  double expected_rms_ = 0;  ///< of the plan, before it is confirmed
  Drawn drawn_;
};

}  // namespace psivox
