#include "grid_types.h"

#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include "base/text.h"
#include "field/index_space.h"
#include "vdb/grid_rows.h"

namespace psivox::vdb {
namespace {

struct SupportedType {
  std::string grid_type;
  std::string value_type;
  int channels;
};

template <typename... GridTs>
std::vector<SupportedType> types_of(openvdb::TypeList<GridTs...>) {
  return {{GridTs::gridType(), openvdb::typeNameAsString<typename GridTs::ValueType>(),
           openvdb::VecTraits<typename GridTs::ValueType>::IsVec ? 3 : 1}...};
}

/// Not from PointDataGrid, whose headers take long to compile.
constexpr const char* points_type = "Tree_ptdataidx32_5_4_3";

/// Of values that are half floats in memory, since OpenVDB 13.
constexpr const char* half_type = "Tree_half_5_4_3";

const std::vector<SupportedType>& supported_types() {
  static const std::vector<SupportedType> types = [] {
    std::vector<SupportedType> all = types_of(SupportedGrids());
    all.push_back({points_type, "points", 1});
    all.push_back({openvdb::MaskGrid::gridType(), "mask", 1});
    return all;
  }();
  return types;
}

const SupportedType* find(const std::string& grid_type) {
  for (const SupportedType& type : supported_types()) {
    if (type.grid_type == grid_type) return &type;
  }
  return nullptr;
}

/// The half width of a level set, or the 0 of a fog of that class; nothing for other grids.
std::optional<double> half_width(const openvdb::GridBase& grid) {
  std::optional<double> width;
  if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
    grid.apply<RealGrids>([&](const auto& typed) { width = double(typed.background()); });
  return width;
}

}  // namespace

std::string points_grid_type() { return points_type; }
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
  if (grid_type == half_type)
    return "has values that are half floats, which OpenVDB reads since version 13; psivox uses "
           "OpenVDB " +
           std::string(openvdb::getLibraryVersionString());
  return "has type " + grid_type + ", which cannot be rendered; supported value types: " +
         joined(names_in(supported_types(), &SupportedType::value_type), ", ");
}

bool is_level_set(const openvdb::GridBase& grid) { return half_width(grid).value_or(0) != 0; }
bool is_fog_of_wrong_class(const openvdb::GridBase& grid) { return half_width(grid) == 0; }

bool has_background(const openvdb::GridBase& grid, const GridSummary& summary) {
  // A level set's background is its half width; the conversion to fog makes it 0.
  return !is_level_set(grid) && summary.background != glm::dvec3(0);
}

std::string background_text(const GridSummary& summary) {
  const glm::dvec3& value = summary.background;
  return summary.channels == 1 ? formatted("%g", value.x)
                               : formatted("(%g, %g, %g)", value.x, value.y, value.z);
}

std::string problem_of(const openvdb::GridBase& grid, const GridSummary& summary) {
  if (summary.active_voxels == 0) return "has no active voxel: nothing to render";
  if (too_large(summary.active_box)) {
    return "has active voxels 2^30 or more apart or from the origin; crop it";
  }
  if (grid.transform().isLinear() && !has_volume(world_from_index(grid.transform()))) {
    return "has a transform that is singular, not finite or beyond 1e75";
  }
  return {};
}

glm::dmat4 world_from_index(const openvdb::math::Transform& transform) {
  openvdb::Mat4d mat;
  try {
    mat = transform.baseMap()->getAffineMap()->getMat4();
  } catch (const openvdb::Exception&) {  // it also inverts the matrix
    return glm::dmat4(0.0);
  }
  // OpenVDB's vectors are rows: its row i is the image of axis i, which is glm's column i.
  glm::dmat4 result(1.0);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) result[i][j] = mat(i, j);
  }
  return result;
}

}  // namespace psivox::vdb
