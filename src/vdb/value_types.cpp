#include "value_types.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace psivox::vdb {
namespace {

constexpr std::string_view before = "Tree_", behind = "_5_4_3";

/// By OpenVDB's names. Those with values come first, in the order of with_value_type.
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

constexpr int value_types = 9;
const std::array<SupportedType, value_types + 2> supported_types{{{"float", 1},
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

bool has_values(std::string_view grid_type, std::string_view value_type) {
  return grid_type == grid_type_of(value_type);
}

}  // namespace

int value_type_number(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  const auto number = type ? int(type - supported_types.data()) : -1;
  return number < value_types ? number : -1;
}

std::string grid_type_of(std::string_view value_type) {
  return std::ranges::find(supported_types, value_type, &SupportedType::value_type)->grid_type();
}

bool is_points(std::string_view grid_type) { return has_values(grid_type, "points"); }
bool is_mask(std::string_view grid_type) { return has_values(grid_type, "mask"); }

std::string stored_like(const std::string& grid_type) {
  if (is_points(grid_type)) return grid_type_of("int32");
  return is_mask(grid_type) ? grid_type_of("bool") : grid_type;
}

int channels_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->channels : 0;
}

std::string value_type_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->value_type : std::string();
}

std::string unsupported_type(const std::string& grid_type) {
  return "has type " + grid_type + ", which cannot be rendered; supported value types: " +
         joined(names_in(supported_types, &SupportedType::value_type), ", ");
}

}  // namespace psivox::vdb
