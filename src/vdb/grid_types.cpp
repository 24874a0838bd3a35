#include "grid_types.h"

#include <array>

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

bool is_level_set(const openvdb::GridBase& grid) {
  return grid.getGridClass() == openvdb::GRID_LEVEL_SET &&
         (grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>());
}

}  // namespace psivox::vdb
