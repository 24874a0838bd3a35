#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox {

/// The atlas of a whole medium, and the codes that were made of it last, as long as the medium is
/// drawn as one part.
class WholeAtlas {
 public:
  bool empty() const { return !atlas_ && !coded_; }
  /// What it takes on the host [bytes].
  double bytes() const;
  void clear();

  /// The atlas of a view, built if it is not there. `density`: the view's, moved in.
  const MediumAtlas& of(const View& view, std::optional<Field> density = {});
  /// The atlas as the device stores it: in codes of these widths, in the texel type's own codes, or
  /// as bricks. `last`: codes may take the place of texels. Until clear() nothing else is made
  /// then.
  const MediumAtlas& on_device(const View& view, TexelType texel, const CodeWidths& codes,
                               bool last = false);
  /// Uploads that for a filter, if the marcher holds something else. Returns what it uploads.
  const MediumAtlas& upload(Marcher& marcher, const View& view, TexelType texel, Filter filter,
                            const CodeWidths& codes = {}, bool last = false);
  /// Replaces the luminance, after the view's light was computed. `luminance`: the view's, moved
  /// in.
  void relight(const View& view, std::optional<Field> luminance = {});

  double ms = 0;  ///< time that building has taken

 private:
  struct Coded {
    CodeWidths widths;
    MediumAtlas atlas;
    std::uint64_t number;  ///< of its upload
  };

  std::optional<MediumAtlas> atlas_;
  std::map<Filter, std::uint64_t> uploads_;  ///< of the atlas: their numbers
  std::optional<Coded> coded_;
};

}  // namespace psivox
