#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <vector>

#include "psivox/field.h"
#include "scene/transfer_function.h"

namespace psivox {

/// How many voxels have each value other than 0. Unset if there are more than `most` values.
using LabelCounts = std::map<float, std::uint64_t>;
std::optional<LabelCounts> label_counts(const Field& field, std::size_t most = 65536);

/// Linear colour of a label: neighbouring numbers have hues far apart. 0 is black.
glm::dvec3 label_color(double label);

struct LabelColor {
  float value;
  std::uint64_t voxels;
  glm::dvec3 color;  ///< linear
};

/// The labels of a field but 0, ascending, with their colours: one label alone is like bone. Throws
/// Error(input) if the values are no labels.
std::vector<LabelColor> label_colors(const Field& field);

/// The function of labels: each has its colour, and an attenuation by which all labels are about
/// equally deep: inversely to the cube root of its volume, 1 for the largest. 0 is vacuum. Between
/// two labels it jumps. Throws Error(input) if the values are no labels.
TransferFunction label_function(const Field& field);

/// Extinction by which a label's cube has an optical depth of 2 from face to face.
double label_extinction(const Field& field);

}  // namespace psivox
