#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox {

/// The atlas of a whole medium, and the codes that were made of it last, as long as the medium is
/// drawn as one part.
class WholeAtlas {
 public:
  /// Lets values of fields and bricks go as soon as a picture needs them no more.
  bool discards = false;
  bool has_bricks() const { return atlas_ && !texels_are_gone_; }
  /// Whether some are gone.
  bool has_gaps() const { return texels_are_gone_ || !gone_.empty(); }
  /// Reads the fields' values again, and clears.
  void restore();

  bool empty() const { return !atlas_; }
  /// What it takes on the host [bytes].
  double bytes() const { return atlas_ ? double(atlas_->size().bytes()) : 0; }
  void clear();

  /// The atlas of a view, built if it is not there.
  const MediumAtlas& of(const View& view, PreparationTimes& times);
  /// The atlas as the device stores it: in codes of these widths, in the texel type's own codes, or
  /// as bricks. `last`: texels are freed as codes are stored.
  const MediumAtlas& on_device(const View& view, TexelType texel, const CodeWidths& codes,
                               PreparationTimes& times, bool last = false);
  /// Uploads that for a filter, if the marcher holds something else. Returns what it uploads. If it
  /// is the last, the host's texels go.
  const MediumAtlas& upload(Marcher& marcher, const View& view, TexelType texel, Filter filter,
                            PreparationTimes& times, const CodeWidths& codes = {},
                            bool last = false);
  /// If it discards: lets the density's values go, of which all is made.
  void discard_density(const Medium& medium);
  /// If it discards: lets the density's and the luminance's values go, of which all is made.
  void discard_fields(const Medium& medium);
  /// Replaces the luminance, after the view's light was computed.
  void relight(const View& view);

 private:
  struct Coded {
    CodeWidths widths;
    MediumAtlas atlas;
    std::uint64_t number;  ///< of its upload
  };

  /// Lets a field's values go, until restore().
  void discard(const std::shared_ptr<const Field>& field);

  std::optional<MediumAtlas> atlas_;
  bool texels_are_gone_ = false;                    ///< those of the atlas
  std::vector<std::shared_ptr<const Field>> gone_;  ///< fields without values
  std::map<Filter, std::uint64_t> uploads_;         ///< of the atlas: their numbers
  std::optional<Coded> coded_;
};

}  // namespace psivox
