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

/// Not from PointDataGrid, whose headers take long to compile.
constexpr const char* points_type = "Tree_ptdataidx32_5_4_3";

const std::array<SupportedType, SupportedGrids::Size + 2>& supported_types() {
  static const std::array<SupportedType, SupportedGrids::Size + 2> types{
      supported<openvdb::FloatGrid>(1),
      supported<openvdb::DoubleGrid>(1),
      supported<openvdb::Int32Grid>(1),
      supported<openvdb::Int64Grid>(1),
      supported<openvdb::BoolGrid>(1),
      supported<openvdb::Vec3SGrid>(3),
      supported<openvdb::Vec3DGrid>(3),
      supported<openvdb::Vec3IGrid>(3),
      SupportedType{points_type, "points", 1},
      SupportedType{openvdb::MaskGrid::gridType(), "mask", 1}};
  return types;
}

const SupportedType* find(const std::string& grid_type) {
  for (const SupportedType& type : supported_types()) {
    if (type.grid_type == grid_type) return &type;
  }
  return nullptr;
}

}  // namespace

bool is_points(const std::string& grid_type) { return grid_type == points_type; }
bool is_mask(const std::string& grid_type) { return grid_type == openvdb::MaskGrid::gridType(); }

std::string stored_like(const std::string& grid_type) {
  if (is_points(grid_type)) return openvdb::Int32Grid::gridType();
  return is_mask(grid_type) ? openvdb::BoolGrid::gridType() : grid_type;
}

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
