#include "scene/isovalue.h"

#include <cmath>

#include "psivox/error.h"
#include "psivox/text.h"
#include "scene/value_range.h"

namespace psivox {

double resolved_isovalue(const Scene& scene, const Field& density) {
  if (density.half_width > 0) {
    const double isovalue = scene.isovalue.value_or(0);
    if (std::abs(isovalue) >= density.half_width)
      throw Error(ExitCode::usage, "--isovalue " + number_text(isovalue) + ": level set " +
                                       in_quotes(density.name) + " has distances below " +
                                       number_text(density.half_width) + " only, either side");
    return isovalue;
  }
  if (scene.isovalue) return *scene.isovalue;
  const glm::dvec2 range = active_range(density);
  return 0.5 * (range.x + range.y);
}

double field_isovalue(double isovalue, const Field& density) {
  return density.half_width > 0 ? density.half_width - isovalue : isovalue;
}

}  // namespace psivox
