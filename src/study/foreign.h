#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "psivox/image.h"
#include "study/results.h"

namespace psivox {

struct ComparedPicture {
  ForeignPoint point;
  Image difference;
};

/// Compares the picture with the reference of its size. An opaque picture is compared with the
/// reference over the colour, or over the radiance `behind` its pixels.
ComparedPicture compare_foreign(const ForeignPicture& foreign, const Image& picture,
                                Image reference, const glm::dvec3& color,
                                const std::vector<glm::vec3>& behind);

}  // namespace psivox
