#include "grid_types.h"

#include <array>
#include <optional>

namespace psivox::vdb {
namespace {

struct SupportedType {
  std::string grid_type;
  std::string value_type;
  int channels;
};

template <typename GridT>
SupportedType supported(int channels) {
  return {GridT::gridType(), openvdb::typeNameAsString<typename GridT::ValueType>(), channels};
}

const std::array<SupportedType, SupportedGrids::Size>& supported_types() {
  static const std::array<SupportedType, SupportedGrids::Size> types{
      supported<openvdb::FloatGrid>(1), supported<openvdb::DoubleGrid>(1),
      supported<openvdb::Int32Grid>(1), supported<openvdb::Int64Grid>(1),
      supported<openvdb::BoolGrid>(1),  supported<openvdb::Vec3SGrid>(3),
      supported<openvdb::Vec3DGrid>(3), supported<openvdb::Vec3IGrid>(3)};
  return types;
}

const SupportedType* find(const std::string& grid_type) {
  for (const SupportedType& type : supported_types()) {
    if (type.grid_type == grid_type) return &type;
  }
  return nullptr;
}

}  // namespace

int channels_of(const std::string& grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->channels : 0;
}

std::string value_type_of(const std::string& grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->value_type : std::string();
}

std::string unsupported_type(const std::string& grid_type) {
  std::string what = "has type " + grid_type;
  if (grid_type.find("ptdata") != std::string::npos) what += " (points)";
  if (grid_type.find("mask") != std::string::npos) what += " (topology without values)";
  what += ", which cannot be rendered; supported value types:";
  const char* separator = " ";
  for (const SupportedType& type : supported_types()) {
    what += separator + type.value_type;
    separator = ", ";
  }
  return what;
}

/// Of a grid of the class; nothing for other grids.
static std::optional<double> half_width(const openvdb::GridBase& grid) {
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET) return {};
  if (grid.isType<openvdb::FloatGrid>())
    return double(static_cast<const openvdb::FloatGrid&>(grid).background());
  if (grid.isType<openvdb::DoubleGrid>())
    return static_cast<const openvdb::DoubleGrid&>(grid).background();
  return {};
}

bool is_level_set(const openvdb::GridBase& grid) { return half_width(grid).value_or(0) != 0; }
bool is_fog_of_wrong_class(const openvdb::GridBase& grid) { return half_width(grid) == 0; }

}  // namespace psivox::vdb
