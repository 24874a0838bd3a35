#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "atlas/atlas.h"

namespace psivox {

/// The code of a brick's values: offset + step * code.
struct BrickCode {
  float offset;
  float step;      ///< its lowest bits are 0: there a stored brick has its width
  float per_step;  ///< 1 / step
  float end;       ///< the greatest code, and a half

  /// The code of one of the values; 0 if it is absent.
  std::int32_t of(float value) const {
    const float place = (value - offset) * per_step + 0.5F;
    return std::int32_t(place > 0 ? std::min(place, end) : 0.0F);
  }
  /// What a value is by its code; NaN if it is absent.
  double rounded(float value) const {
    if (value != value) return double(value);
    return double(offset) + double(step) * double(of(value));
  }
};

/// The codes of an atlas's bricks, and of those beside it, by slot.
struct BrickCodes {
  std::vector<BrickCode> own, beside;
};

BrickCodes brick_codes(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                       const BrickAtlas* beside = nullptr);

/// Bytes of bricks in codes of these widths, with the channels of the bricks beside them.
std::uint64_t coded_bytes(const std::vector<CodeWidth>& widths, const BrickAtlas* beside = nullptr);

}  // namespace psivox
