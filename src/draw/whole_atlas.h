#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <utility>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox {

/// The type of the host's bricks, by which light is computed and methods are chosen, whatever codes
/// the device has.
inline TexelType host_texel(TexelType texel) {
  return texel == TexelType::float16 ? texel : TexelType::float32;
}

/// The atlases of a whole medium, in float32 or float16 or both, and the codes made of them last,
/// as long as the medium is drawn as one part.
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
  /// Uploads codes of these widths, of the float32 atlas, for exact filtering.
  void upload_coded(Marcher& marcher, const View& view, const CodeWidths& widths,
                    PreparationTimes& times);
  /// The codes, made if they are not there.
  const MediumAtlas& coded_as(const View& view, const CodeWidths& widths, PreparationTimes& times) {
    return coded_of(view, widths, times).atlas;
  }
  /// The widths of the codes that the marcher holds; null if it holds none.
  CodeWidths held_codes(const Marcher& marcher) const;
  /// Replaces the luminance, after the view's light was computed.
  void relight(const View& view);

 private:
  struct Coded {
    CodeWidths widths;
    MediumAtlas atlas;
    std::uint64_t number;  ///< of its upload
  };
  Coded& coded_of(const View& view, const CodeWidths& widths, PreparationTimes& times);

  std::map<TexelType, MediumAtlas> atlases_;
  std::map<std::pair<TexelType, Filter>, std::uint64_t> uploads_;  ///< their numbers
  std::list<Coded> coded_;  ///< the last two, the newest first
};

}  // namespace psivox
