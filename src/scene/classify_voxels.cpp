#include "scene/classify_voxels.h"

#include "scene/fill_domain.h"
#include "scene/map_field.h"

namespace psivox {

Field attenuation_of_voxels(const Field& field, const TransferFunction& function) {
  const auto map = [&](const glm::vec3& value) {
    const TransferPoint point = function.at(static_cast<double>(value.x));
    return glm::vec3(static_cast<float>(point.attenuation), 0, 0);
  };
  if (function.at(0).attenuation == 0) return map_field(field, 1, map);
  Field whole = field;
  fill_domain(whole);
  return map_field(whole, 1, map);
}

Field color_of_voxels(const Field& field, const TransferFunction& function) {
  Field whole = field;
  if (function.at(0).attenuation > 0)
    fill_domain(whole);
  else if (function.at(0).color != glm::dvec3(0))
    fill_surroundings(whole);
  return map_field(whole, 3, [&](const glm::vec3& value) {
    return glm::vec3(function.at(static_cast<double>(value.x)).color);
  });
}

}  // namespace psivox
