#pragma once

#include <optional>
#include <vector>

#include "psivox/image.h"
#include "psivox/medium.h"

namespace psivox {

/// Luminances (Rec. 709) and brightest channels of the covered pixels of a small picture of a
/// scene, each ascending. Drawn in double precision, in coarse light.
struct Draft {
  std::vector<double> luminance, brightest;

  /// Adds a pixel of this radiance and opacity; sort() is due when all are added.
  void see(const glm::dvec3& radiance, double alpha);
  void sort();

  double mean_luminance() const;
  /// The brightest channel that this part of the pixels exceeds; 0 if none is covered.
  double level(double part) const;
};

Draft make_draft(const Scene& scene, const MediumFields& fields);

/// The same from rays through the nearest voxels, without an atlas: a large volume takes no longer.
/// Nothing where the view has more than `alpha` with lights shows.
std::optional<Draft> ray_draft(const View& view);

/// The small picture itself.
Image draft_picture(Scene scene, const MediumFields& fields);

/// The brightest channel that this part of the glowing pixels exceeds, however bright they are: of
/// those that have a hundredth of the greatest. 0 if none glows.
double glow_level(const Image& image, double part);

}  // namespace psivox
