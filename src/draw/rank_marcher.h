#pragma once

#include <vector>

#include "draw/rank_light.h"
#include "draw/region_marcher.h"
#include "march/light_pilot.h"
#include "march/light_share.h"
#include "psivox/team.h"

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
  RankMarcher(Marcher& marcher, Team& team, const Regions& parts, const Regions& own);

  std::string description() const override { return own_.description(); }
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  bool approximates_light() const override { return true; }
  /// All ranks must ask for them together, each for its own voxels.
  LightDepths light_depths(const View& view) override;
  /// What light is chosen by.
  LightShare light_share(const std::shared_ptr<const Field>& whole);
  LightPilot::Depths exact_depths(const View& view);
  RenderResult render(const View& view, const RenderOptions& options = {}) override;

 private:
  CarriedLight carry_own(const View& view, const RenderOptions& options, const PixelBox& pixels,
                         RenderStats& stats);
  CarriedLight fold(const View& view, const CarriedLight& own, const std::vector<PixelBox>& seen);
  Image collect(const Image& strip, const glm::ivec2& size);
  void add_up(RenderStats& stats);
  void lattice(const View& view, const Beam& beam, const LightBlocks& blocks,
               const TakeDepths& take, const Progress& progress);

  RegionMarcher own_;
  Team& team_;
  const Regions& parts_;
  std::size_t most_regions_ = 0;  ///< of a rank's part
};

}  // namespace psivox
