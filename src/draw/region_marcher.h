#pragma once

#include <optional>
#include <span>
#include <vector>

#include "draw/carried_light.h"
#include "march/marcher.h"
#include "psivox/regions.h"

namespace psivox {

/// Draws with another marcher, region by region, and joins what they show. Each region is
/// converted, uploaded, drawn and dropped. One that no ray sees is left out.
///
/// A picture's regions come front to back, and a RayFold joins what rays collect in them. The
/// picture is that of the whole, apart from rounding and from what rays of the whole leave out when
/// they end early: a ray ends in a region by what that region hides alone. A view with a tolerance
/// is marched exactly. Optical depths towards a light add up over the regions.
class RegionMarcher final : public Marcher {
 public:
  RegionMarcher(Marcher& marcher, const Regions& regions) : marcher_(marcher), regions_(regions) {}

  std::string description() const override { return marcher_.description(); }
  /// It needs no atlas of its session, and chooses no method.
  bool marches() const override { return false; }
  bool approximates_light() const override { return true; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override;
  std::size_t regions() const { return regions_.count(); }
  /// Gives the lattice through a region. One that there is not hides nothing.
  void with_lattice_of(std::size_t region, const View& view, const Beam& beam,
                       const UseLattice& use);
  /// Exact depths of the regions from some voxels.
  std::vector<double> exact_depths(const View& view, const Beam& beam,
                                   std::span<const glm::ivec3> voxels);
  RenderResult render(const View& view, const RenderOptions& options = {}) override;
  /// What the picture's rays collect in these pixels, which must have all that see the regions.
  CarriedLight carry(const View& view, const RenderOptions& options, const PixelBox& pixels,
                     RenderStats& stats);

 private:
  /// Those of rays through all regions; and by lattices.
  void by_rays(const View& view, std::span<const Beam> beams, const LightBlocks& blocks,
               const TakeLight& take, const Progress& progress);
  void by_lattices(const View& view, std::span<const Beam> beams, const LightBlocks& blocks,
                   const TakeLight& take, const Progress& progress);
  /// Of a region.
  std::size_t most_bricks() const;
  /// Uploads a box of bricks for light, if it is not uploaded.
  void upload_dark(const View& view, const Box& bricks);
  /// The density's greatest value.
  double greatest_of(const View& view);

  Marcher& marcher_;
  const Regions& regions_;
  MediumAtlas dark_;             ///< of the bricks uploaded last for light
  std::optional<Box> uploaded_;  ///< these bricks
  std::optional<double> greatest_;
};

}  // namespace psivox
