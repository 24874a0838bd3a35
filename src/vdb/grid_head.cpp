#include "grid_head.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <glm/geometric.hpp>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "base/text.h"
#include "field/index_space.h"
#include "survey.h"
#include "topology.h"

namespace psivox::vdb {
namespace {

/// The type of the metadata for delayed loading. Files of OpenVDB 13 and before have them; later
/// libraries do not know them.
constexpr std::string_view delayed_load_type = "__delayedload";

/// A type of metadata: so many numbers, in so many rows.
struct MetadataType {
  std::string_view name;
  char number;  ///< i, l, f, d: int32, int64, float, double
  int numbers = 1, rows = 1;
};

constexpr MetadataType metadata_types[] = {
    {"int32", 'i'},    {"int64", 'l'},       {"float", 'f'},      {"double", 'd'},
    {"vec2i", 'i', 2}, {"vec2s", 'f', 2},    {"vec2d", 'd', 2},   {"vec3i", 'i', 3},
    {"vec3s", 'f', 3}, {"vec3d", 'd', 3},    {"vec4i", 'i', 4},   {"vec4s", 'f', 4},
    {"vec4d", 'd', 4}, {"mat4s", 'f', 4, 4}, {"mat4d", 'd', 4, 4}};

void take_number(std::istream& bytes, char number, std::ostream& text) {
  switch (number) {
    case 'i':
      text << take<std::int32_t>(bytes);
      break;
    case 'l':
      text << take<std::int64_t>(bytes);
      break;
    case 'f':
      text << take<float>(bytes);
      break;
    default:
      text << take<double>(bytes);
  }
}

std::string text_of(const std::string& type, const std::string& value) {
  if (type == "string") return value;
  if (type == "bool") return value.empty() || value[0] == 0 ? "false" : "true";
  const auto* const known = std::ranges::find(metadata_types, type, &MetadataType::name);
  if (known == std::end(metadata_types)) return value.empty() ? "" : "<binary data>";
  std::istringstream bytes(value);
  bytes.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  std::ostringstream text;
  const auto list = [&](int count, const auto& item) {
    if (count > 1) text << '[';
    for (int n = 0; n < count; ++n) {
      if (n > 0) text << ", ";
      item();
    }
    if (count > 1) text << ']';
  };
  list(known->rows,
       [&] { list(known->numbers, [&] { take_number(bytes, known->number, text); }); });
  return text.str();
}

/// A vector of integers in metadata; false if there is none of that name.
bool take_vector(const MetadataText& metadata, const char* name, glm::ivec3& v) {
  const auto found = metadata.find(name);
  return found != metadata.end() &&
         std::sscanf(found->second.c_str(), "[%d, %d, %d]", &v.x, &v.y, &v.z) == 3;
}

/// Reads a transform of a known type without a frustum.
glm::dmat4 read_linear(std::istream& stream, const std::string& map) {
  glm::dmat4 matrix(1);
  if (map == "AffineMap" || map == "UnitaryMap") {
    // OpenVDB's vectors are rows: its row i is the image of axis i, which is glm's column i
    matrix = take<glm::dmat4>(stream);
    for (int axis = 0; axis < 4; ++axis)
      if (matrix[axis][3] != (axis == 3)) throw std::runtime_error("its transform is not affine");
    return matrix;
  }
  const bool moves = map.find("Translat") != std::string::npos;
  const bool scales = map.find("Scale") != std::string::npos;
  constexpr std::array known{"TranslationMap", "ScaleMap", "UniformScaleMap", "ScaleTranslateMap",
                             "UniformScaleTranslateMap"};
  if (std::ranges::find(known, map) == known.end())
    throw std::runtime_error("its transform is of the unknown type " + in_quotes(printable(map)));
  if (moves) matrix[3] = glm::dvec4(take<glm::dvec3>(stream), 1);
  if (scales) {
    constexpr int derived = 4;  // vectors that follow from the scale
    const auto scale = take<glm::dvec3>(stream);
    for (int axis = 0; axis < 3; ++axis) matrix[axis][axis] = scale[axis];
    stream.seekg(derived * sizeof(glm::dvec3), std::ios_base::cur);
  }
  return matrix;
}

/// The half width of a level set, or the 0 of a fog of that class; nothing for other grids.
std::optional<double> half_width(const GridHead& head, const GridSummary& summary) {
  const bool real = with_value_type(head.type, []<typename ValueT>() {
    return ValueTraits<ValueT>::channels == 1 &&
           (is_real<ValueT> || std::is_same_v<ValueT, Imath::half>);
  });
  if (!real || head.grid_class != level_set_class) return {};
  return summary.background.x;
}

}  // namespace

std::string read_string(std::istream& stream) {
  const auto begin = stream.tellg();
  skip_string(stream);  // throws before memory is allocated
  std::string bytes(static_cast<std::size_t>(stream.tellg() - begin) - sizeof(std::uint32_t), '\0');
  stream.seekg(begin + std::streamoff(sizeof(std::uint32_t)));
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

void skip_string(std::istream& stream) {
  const auto length = take<std::uint32_t>(stream);
  stream.seekg(length, std::ios_base::cur);
}

MetadataText read_metadata(std::istream& stream, std::string* delayed_load) {
  MetadataText metadata;
  for (auto count = take<std::uint32_t>(stream); count > 0; --count) {
    const std::string name = read_string(stream), type = read_string(stream);
    std::string value = read_string(stream);
    if (type == delayed_load_type) {
      if (delayed_load) *delayed_load = std::move(value);
      continue;
    }
    try {
      metadata[name] = text_of(type, value);
    } catch (const std::ios_base::failure&) {
      throw std::runtime_error("the metadata " + in_quotes(printable(name)) + " are cut off");
    }
  }
  return metadata;
}

Transform read_transform(std::istream& stream) {
  Transform transform;
  transform.map = read_string(stream);
  if (transform.map != "NonlinearFrustumMap") {
    transform.world_from_index = read_linear(stream, transform.map);
    return transform;
  }
  const auto begin = stream.tellg();
  constexpr int numbers = 6 + 2;  // box, taper, depth
  stream.seekg(numbers * sizeof(double), std::ios_base::cur);
  const std::string second = read_string(stream);
  read_linear(stream, second);
  transform.frustum.resize(static_cast<std::size_t>(stream.tellg() - begin));
  stream.seekg(begin);
  stream.read(transform.frustum.data(), static_cast<std::streamsize>(transform.frustum.size()));
  return transform;
}

std::string_view class_in(const MetadataText& metadata) {
  const auto found = metadata.find("class");
  if (found == metadata.end()) return unknown_class;
  constexpr const char* blanks = " \t\r\n";
  std::string text = lower_case(found->second);
  text.erase(0, text.find_first_not_of(blanks));
  text.erase(text.find_last_not_of(blanks) + 1);
  for (const std::string_view known : {level_set_class, staggered_class, fog_class})
    if (text == known) return known;
  return unknown_class;
}

GridPlace place_in(const MetadataText& metadata, const Transform& transform) {
  GridPlace place;
  take_vector(metadata, "file_base_resolution", place.domain);
  if (!transform.is_linear()) return place;
  const glm::dmat3 axes(transform.world_from_index);
  place.voxel_size = std::min({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
  Box box;
  const auto count = metadata.find("file_voxel_count");
  place.known = count != metadata.end() && read_number(count->second, place.voxels) &&
                take_vector(metadata, "file_bbox_min", box.min) &&
                take_vector(metadata, "file_bbox_max", box.max) &&
                (place.voxels == 0 || !box.empty());
  if (place.known && place.voxels > 0)
    std::tie(place.world_min, place.world_max) = bounds_of(box, transform.world_from_index);
  return place;
}

bool is_level_set(const GridHead& head, const GridSummary& summary) {
  return half_width(head, summary).value_or(0) != 0;
}
bool is_fog_of_wrong_class(const GridHead& head, const GridSummary& summary) {
  return half_width(head, summary) == 0;
}

bool has_background(const GridHead& head, const GridSummary& summary) {
  // A level set's background is its half width; the conversion to fog makes it 0.
  return !is_level_set(head, summary) && summary.background != glm::dvec3(0);
}

std::string background_text(const GridSummary& summary) {
  const glm::dvec3& value = summary.background;
  return summary.channels == 1 ? formatted("%g", value.x)
                               : formatted("(%g, %g, %g)", value.x, value.y, value.z);
}

std::string problem_of_distances(const GridHead& head, const GridSummary& summary) {
  if (half_width(head, summary).value_or(0) >= 0) return {};
  return "is a level set whose background is " + background_text(summary) +
         ": its distances have the opposite sign; negate them, or give it the class unknown";
}

std::string problem_of(const Transform& transform, const GridSummary& summary) {
  if (summary.active_voxels == 0) return "has no active voxel: nothing to render";
  if (too_large(summary.active_box)) {
    return "has active voxels 2^30 or more apart or from the origin; crop it";
  }
  if (transform.is_linear() && !has_volume(transform.world_from_index)) {
    return "has a transform that is singular, not finite or beyond 1e75";
  }
  return {};
}

}  // namespace psivox::vdb
