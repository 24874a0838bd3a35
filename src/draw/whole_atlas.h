#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox {

/// The atlases of a whole medium, one for each texel type, as long as the medium is drawn as one
/// part.
class WholeAtlas {
 public:
  bool empty() const { return atlases_.empty(); }
  /// What they take on the host [bytes].
  double bytes() const;
  void clear();

  /// The atlas of a view with that texel type, built if it is not there.
  const MediumAtlas& of(const View& view, TexelType texel, PreparationTimes& times);
  /// Uploads it for a filter, if the marcher holds something else.
  void upload(Marcher& marcher, const View& view, TexelType texel, Filter filter,
              PreparationTimes& times);
  /// Replaces the luminance, after the view's light was computed.
  void relight(const View& view);

 private:
  std::map<TexelType, MediumAtlas> atlases_;
  std::map<std::pair<TexelType, Filter>, std::uint64_t> uploads_;  ///< their numbers
};

}  // namespace psivox
