#pragma once

#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "psivox/medium.h"

namespace psivox {

/// Where the bricks of a further volume are, or of what it emits.
struct PlacedOther {
  std::size_t volume = 0;            ///< place in Medium::others
  std::optional<std::size_t> emits;  ///< place in its emission
  int channels = 1;                  ///< attenuation and luminance, or emission
  Box domain;                        ///< voxels, as the next two
  glm::ivec3 table_min{0}, table_size{0};
  int levels = 1;
  int first_page = 0;            ///< of its table
  int slots = 0, constants = 0;  ///< of a channel
  double greatest = 0;           ///< of its values, if it attenuates
};

/// The grids of a view's medium as bricks: only what its picture depends on.
struct MediumAtlas {
  BrickAtlas density;
  std::optional<BrickAtlas> luminance;  ///< where the luminance has a grid of its own
  std::vector<BrickAtlas> emission;     ///< as in Medium
  std::optional<BrickAtlas> gradient;   ///< where the transfer function has one
  std::optional<BrickAtlas> others{};   ///< of all further volumes, see join_others
  std::vector<PlacedOther> placed{};
  bool paired = false;  ///< luminance has the density's bricks in the same slots
  /// The region whose density and gradient are stored, alone: cells beside it may have values
  /// [8 voxels, inclusive]
  std::optional<Box> part{};
  /// In a region's atlas, the greatest value of the whole density: what a march derives from it
  /// must not differ from region to region.
  std::optional<double> greatest{};

  /// Where a medium's further volumes are; none if it has none: one is marched alone, to light.
  std::span<const PlacedOther> placed_in(const Medium& medium) const {
    if (medium.others.empty()) return {};
    return placed;
  }

  /// Sum over the grids.
  AtlasSize size() const;
};

/// Whether a scene's rule applies the transfer function between the ends of uniform steps, which
/// reach from brick to brick: its atlas holds bricks that the function hides, too.
bool needs_every_value(const Scene& scene);

/// Options of the density's atlas: which values can be seen under the view's mode and transfer
/// function, and where an emission grid needs walking though the density is empty there.
AtlasOptions density_options(const View& view);

/// Builds the atlases. Of a view whose light is still to be computed the luminance is left out.
/// `density`: the view's, whose values go as their bricks are stored; unset: they stay.
MediumAtlas build_medium_atlas(const View& view, std::optional<Field> density = {});

/// Bricks around a region that its rays read: a uniform step begins in the region and ends up to a
/// step beside it. None in cells.
glm::ivec3 region_ghost(const View& view);

/// Builds atlases with the density and its gradient in a region only, a box of bricks, and in
/// `ghost` bricks around it, and the other grids whole.
MediumAtlas build_region_atlas(const View& view, const Box& region, const glm::ivec3& ghost = {});

/// A field with the leaves alone that an atlas of some bricks reads, in memory. Its domain stays
/// the domain of the whole.
Field field_of_bricks(const Field& field, const Box& bricks, bool with_margin);

/// What the device stores: the density's bricks, with the luminance beside them, as codes of these
/// widths; all else is shared. `replaces`: see the same of a BrickAtlas; else the host keeps the
/// float32 atlas, by which methods are chosen.
MediumAtlas coded(MediumAtlas atlas, const std::vector<CodeWidth>& widths, bool replaces = false);

/// One width for all bricks, if that is the type of texels; else null.
CodeWidths fixed_widths(const MediumAtlas& atlas, TexelType texel);

/// Adds the luminance of a view whose light has been computed since. `luminance`: as `density`
/// above.
void add_luminance(MediumAtlas& atlas, const View& view, std::optional<Field> luminance = {});

/// The bricks of a further volume, or of what it emits, before they are joined.
struct OtherBricks {
  std::size_t volume = 0;              ///< place in Medium::others
  std::optional<std::size_t> emits{};  ///< place in its emission
  BrickAtlas bricks{};
  std::optional<BrickAtlas> light{};  ///< its luminance, in the same slots
};

/// Sets the atlas's further volumes: the bricks of all as one grid of one channel. A volume's
/// channels follow each other there, each with as many slots as it has bricks.
void join_others(const std::vector<OtherBricks>& parts, MediumAtlas& atlas);

}  // namespace psivox
