#include "grid_head.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <glm/geometric.hpp>
#include <optional>
#include <tuple>

#include "base/text.h"
#include "field/index_space.h"
#include "survey.h"
#include "topology.h"

namespace psivox::vdb {
namespace {

constexpr std::string_view before = "Tree_", behind = "_5_4_3";

/// By OpenVDB's names.
struct SupportedType {
  std::string value_type;
  int channels;
  std::string_view name_in_file = {};  ///< if it is another

  std::string grid_type() const {
    return std::string(before)
        .append(name_in_file.empty() ? value_type : name_in_file)
        .append(behind);
  }
};

const std::array<SupportedType, 11> supported_types{{{"float", 1},
                                                     {"double", 1},
                                                     {"half", 1},
                                                     {"int32", 1},
                                                     {"int64", 1},
                                                     {"bool", 1},
                                                     {"vec3s", 3},
                                                     {"vec3d", 3},
                                                     {"vec3i", 3},
                                                     {"points", 1, "ptdataidx32"},
                                                     {"mask", 1}}};

const SupportedType* find(std::string_view grid_type) {
  const auto found = std::ranges::find(supported_types, grid_type, &SupportedType::grid_type);
  return found == supported_types.end() ? nullptr : &*found;
}

/// A vector of integers in metadata; false if there is none of that name.
bool take_vector(const MetadataText& metadata, const char* name, glm::ivec3& v) {
  const auto found = metadata.find(name);
  return found != metadata.end() &&
         std::sscanf(found->second.c_str(), "[%d, %d, %d]", &v.x, &v.y, &v.z) == 3;
}

/// The half width of a level set, or the 0 of a fog of that class; nothing for other grids.
std::optional<double> half_width(const GridHead& head, const GridSummary& summary) {
  const std::string type = value_type_of(head.type);
  const bool real = type == "float" || type == "double" || type == "half";
  if (!real || head.grid_class != level_set_class) return {};
  return summary.background.x;
}

}  // namespace

std::string grid_type_of(std::string_view value_type) {
  return std::ranges::find(supported_types, value_type, &SupportedType::value_type)->grid_type();
}

std::string value_type_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->value_type : std::string();
}

int channels_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->channels : 0;
}

bool is_points(std::string_view grid_type) { return value_type_of(grid_type) == "points"; }
bool is_mask(std::string_view grid_type) { return value_type_of(grid_type) == "mask"; }

std::string unsupported_type(const std::string& grid_type) {
  return "has type " + grid_type + ", which cannot be rendered; supported value types: " +
         joined(names_in(supported_types, &SupportedType::value_type), ", ");
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
