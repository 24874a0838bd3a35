#pragma once

#include <vector>

#include "march/carried_light.h"
#include "psivox/regions.h"
#include "psivox/team.h"

namespace psivox {

/// Joins what the members of a team have collected in their parts. Each folds one strip of rows: it
/// gets from every member the light that the strip's rays carry through that member's part, and
/// joins it in the order of parts, front to back. Then the first collects the strips.
class Strips {
 public:
  /// `parts`: one for each member.
  Strips(Team& team, const Regions& parts, const View& view);

  /// The pixels that see this member's part.
  const PixelBox& own_pixels() const { return seen_[std::size_t(team_.rank())]; }

  /// Which of this member's rays end in its part, in the whole picture, although they would not end
  /// there by this part alone: the optical depth that each has passed before, by its index, and
  /// CarriedLight::no_ray for all others. Empty: no member has one.
  std::vector<float> ending(const CarriedLight& own) const;

  /// The picture, in the first.
  Image picture(const CarriedLight& own, bool transmittance) const;

 private:
  template <typename Number, typename Of>
  std::vector<std::vector<Number>> sent_to_strips(const CarriedLight& own, int sample,
                                                  const Of& of) const;
  PixelBox strip_of(int rank) const;

  Team& team_;
  const View& view_;
  std::vector<Region> order_;   ///< parts, front to back
  std::vector<PixelBox> seen_;  ///< pixels, by part
};

/// Counts of all members, and the times of the slowest.
void add_up(Team& team, RenderStats& stats);

}  // namespace psivox
