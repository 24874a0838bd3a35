#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "atlas/regions.h"
#include "draw/lighting.h"
#include "march/carried_light.h"
#include "march/marcher.h"
#include "psivox/team.h"

namespace psivox {

/// How a picture's volume is split: each member of a team draws one part of it, in one region or as
/// many as memory asks for.
struct Split {
  bool whole = true;               ///< one process draws it as one region, whose atlas may be kept
  Regions parts = Regions({}, 1);  ///< one for each member
  Regions own = Regions({}, 1);    ///< this member's part
  Box lit = everywhere;  ///< bricks that it lights, alone in memory: its part and what rays read
};

/// How often the texels of an atlas are in memory while a picture is drawn.
struct Copies {
  int whole = 2;  ///< on host and device
  int part = 2;   ///< those of one region
};

/// Those of a view without its light. `replaces`: codes take the place of a whole's texels.
Copies copies_of(const Marcher& marcher, const View& view, bool replaces);

/// The split by which the wish's team must draw a view. A process alone draws the volume whole if
/// its atlases fit on host and GPU into the scene's memory limit or, without a limit, into four
/// fifths of the free memory. Without a limit it also draws whole a picture that cannot be drawn in
/// parts. Other grids than the density and its gradient stay whole. Members of a team that share a
/// machine share its memory, unless the scene has a limit, which is each member's; with light their
/// parts' values are in memory. Throws Error(memory) if the limit cannot be kept. `limit` stands
/// for the scene's [bytes].
Split split_of(const View& view, const Wish& wish, const Copies& copies = {},
               std::optional<double> limit = {});

/// Draws a volume part by part and joins what the parts show. Each member of the team draws the
/// regions of its own part, one after another: each is converted, uploaded, drawn and dropped. One
/// that no ray sees is left out. The whole is one region, whose atlas the caller uploads and keeps;
/// the marcher draws it as it is.
///
/// A picture's regions come front to back, and a RayFold joins what rays collect in them. A region
/// knows which optical depths its rays have passed, so that they end where the whole's rays end:
/// the picture is the whole's, apart from rounding. Optical depths towards a light add up over the
/// regions.
class PartMarcher {
 public:
  PartMarcher(Marcher& marcher, Split split, Team& team);

  bool whole() const { return split_.whole; }
  /// Whether the marcher marches an atlas, and the whole's is at hand.
  bool marches_whole() const { return whole() && marcher_.marches(); }
  Marcher& marcher() const { return marcher_; }
  Team& team() const { return team_; }
  const Split& split() const { return split_; }
  /// The bricks of this member's part.
  Box own_part() const { return split_.parts.all()[std::size_t(team_.rank())].bricks; }

  /// The picture is the first member's; the others get an empty one.
  RenderResult render(const View& view, const RenderOptions& options = {});

  /// Optical depths towards light. All members must ask for them together, each for its own voxels.
  LightDepths light_depths(const View& view);
  /// Where light comes from. `whole`: the whole's atlas, if it is there.
  LightSource light_source(const MediumAtlas* whole);

 private:
  /// Adds what the rays collect in this member's regions.
  void carry(CarriedLight& light, const View& view, const RenderOptions& options,
             RenderStats& stats);
  /// carry(), while members tell the first how far they are.
  void carry_together(CarriedLight& light, const View& view, const RenderOptions& options,
                      RenderStats& stats);

  /// Exact depths from some voxels, the same in all members.
  std::vector<double> exact_depths(const View& view, const Beam& beam,
                                   std::span<const glm::ivec3> voxels);
  /// What rays cross of the whole, the same in all members.
  std::vector<std::vector<Crossed>> crossed(const View& view, std::span<const glm::dvec2> places);
  class Lattices;
  /// Bricks of a layer that lattices pass: as many as in a region, if there are several.
  std::size_t layer_bricks() const;
  LightDepths depths_by_rays(const View& view);
  LightDepths depths_by_lattices(const View& view);
  /// Sums of exact depths over this member's regions, 512 a block.
  std::vector<double> sum_rays(const View& view, const Beam& beam, LightBlocks blocks,
                               const Progress& progress);
  /// Bricks of the largest region.
  std::size_t most_bricks() const;
  /// Uploads a box of bricks for light, if it is not uploaded.
  void upload_dark(const View& view, const Box& bricks);
  void drop_dark();

  Marcher& marcher_;
  Split split_;
  Team& team_;
  MediumAtlas dark_;             ///< of the bricks uploaded last for light
  std::optional<Box> uploaded_;  ///< these bricks
};

}  // namespace psivox
