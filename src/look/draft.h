#pragma once

#include <vector>

#include "psivox/medium.h"

namespace psivox {

/// Luminances (Rec. 709) and brightest channels of the covered pixels of a small picture of a
/// scene, each ascending. Drawn in double precision, in coarse light.
struct Draft {
  std::vector<double> luminance, brightest;

  double mean_luminance() const;
  /// The brightest channel that this part of the pixels exceeds; 0 if none is covered.
  double level(double part) const;
};

Draft make_draft(const Scene& scene, const MediumFields& fields);

/// The small picture itself.
Image draft_picture(Scene scene, const MediumFields& fields);

}  // namespace psivox
