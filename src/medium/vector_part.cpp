#include "medium/vector_part.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "medium/map_field.h"
#include "medium/value_range.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr std::array<const char*, 4> parts{"x", "y", "z", "length"};

}  // namespace

VectorPart vector_part(const VdbFile& file, const std::string& name) {
  const int channels = file.channels(name);
  if (channels == 3) return {name, "length"};
  const std::size_t colon = name.rfind(':');
  if (channels != 0 || colon == std::string::npos) return {name, ""};
  const VectorPart named{name.substr(0, colon), name.substr(colon + 1)};
  const int of_grid = file.channels(named.grid);
  if (of_grid == 0) return {name, ""};
  if (named.active()) return named;
  if (of_grid == 1)
    throw Error(ExitCode::input, "grid " + in_quotes(named.grid) + " is scalar: it has no part " +
                                     in_quotes(named.part) + " but 'active'; give its name alone");
  if (std::ranges::find(parts, named.part) == parts.end())
    throw Error(ExitCode::input, "grid " + in_quotes(named.grid) + " has no part " +
                                     in_quotes(named.part) +
                                     "; a vector has x, y, z, length and active");
  return named;
}

Field part_of_vectors(const Field& vectors, const VectorPart& part) {
  const auto place = std::ranges::find(parts, part.part) - parts.begin();
  Field field = map_field(vectors, 1, [place](const glm::vec3& v) {
    const float value = place == 3 ? glm::length(v) : v[static_cast<int>(place)];
    return glm::vec3(value, 0, 0);
  });
  field.name += ":" + part.part;
  field.value_type = "float";
  field.of_vectors = true;
  field.active_range = glm::vec2(active_range(field));
  return field;
}

}  // namespace psivox
