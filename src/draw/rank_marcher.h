#pragma once

#include <vector>

#include "draw/region_marcher.h"
#include "psivox/ranks.h"

namespace psivox {

/// Draws a picture together with other processes, each of which draws the regions of its own part
/// of the volume. The picture is the first rank's; the others get an empty one.
///
/// Each rank folds one strip of rows: it gets from every rank the light that the strip's rays
/// carry through that rank's part, and joins it in the order of parts, front to back. Then the
/// first rank collects the strips.
class RankMarcher final : public Marcher {
 public:
  /// `parts`: one for each rank. `own`: the regions of this rank's part.
  RankMarcher(Marcher& marcher, Ranks& ranks, const Regions& parts, const Regions& own)
      : own_(marcher, own), ranks_(ranks), parts_(parts) {}

  std::string description() const override { return own_.description(); }
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override { return own_.light_depths(view); }
  RenderResult render(const View& view, const RenderOptions& options = {}) override;

 private:
  CarriedLight carry_own(const View& view, const RenderOptions& options, const PixelBox& pixels,
                         RenderStats& stats);
  CarriedLight fold(const View& view, const CarriedLight& own, const std::vector<PixelBox>& seen);
  Image collect(const Image& strip, const glm::ivec2& size);
  void add_up(RenderStats& stats);

  RegionMarcher own_;
  Ranks& ranks_;
  const Regions& parts_;
};

}  // namespace psivox
