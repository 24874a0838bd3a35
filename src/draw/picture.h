#pragma once

#include "draw/part_marcher.h"
#include "plan/plan.h"

namespace psivox {

/// The progress of one stage; `progress` must outlive it.
Progress of_stage(const StageProgress& progress, Stage stage);
/// Tells that a stage begins.
void enter(const StageProgress& progress, Stage stage);

/// The last stages of a picture: the march, and what checks it.
class Picture {
 public:
  /// Marches by `plan`, or by the view's own method if there is none.
  Picture(PartMarcher& marcher, const View& view, const Wish& wish, std::optional<MarchPlan> plan);

  /// `grids`: what a device stores of the whole; null: the marcher reads the fields, or draws
  /// parts.
  void march(const std::shared_ptr<const MediumAtlas>& grids);
  /// Estimates the error from the pilot's rays, as the marcher draws them.
  void confirm_plan();
  /// Adds layer `error`. The marcher must hold the atlas for exact filtering. The medium may have
  /// better light than the picture's.
  void add_error(const Medium& medium);
  /// Adds layer `bound`: against the integral of the medium, whose light is computed exactly.
  void add_bound(const Medium& medium);
  /// Completes what was drawn.
  void finish();
  Drawn& drawn() { return drawn_; }

 private:
  const View& marched() const { return plan_ ? plan_->march->view : view_; }
  bool confirms() const;
  void say(std::string notice) { drawn_.notices.push_back(std::move(notice)); }

  PartMarcher& marcher_;
  const View& view_;
  const Wish& wish_;
  std::optional<MarchPlan> plan_;
  double expected_rms_ = 0;  ///< the plan's estimate before it is confirmed
  Image pilot_;              ///< the plan's rays, as the marcher draws them
  Drawn drawn_;
};

/// Why float32 loses the density's values in products with extinctions and lengths; empty if it
/// keeps them.
std::string why_lost(const View& view);

/// Throws Error(usage) or Error(memory) if the scene's picture cannot be deep. A look may have set
/// another mode since the scene was checked.
void check_deep(const Scene& scene, const PartMarcher& parts);

/// Session::pick for a view and its atlas, marched in double by the view's method.
std::optional<glm::dvec3> pick_point(const View& view, const MediumAtlas& atlas,
                                     const glm::dvec2& pixel);

}  // namespace psivox
