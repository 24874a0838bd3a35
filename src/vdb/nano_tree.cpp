#include "nano_tree.h"

#include <nanovdb/NanoVDB.h>

#include <cstring>
#include <vector>

#include "grid_types.h"
#include "nano_nodes.h"

namespace psivox::vdb {
namespace {

template <typename BuildT, typename GridT, bool points = false>
std::unique_ptr<NanoTree> make_tree(NanoBytes bytes) {
  return std::make_unique<TypedNanoTree<BuildT, GridT, points>>(bytes);
}

/// A type of grids and how it is read. What is stored in fewer bits than OpenVDB's types have
/// becomes the next wider one.
struct KnownType {
  nanovdb::GridType type;
  NanoType as;
  std::unique_ptr<NanoTree> (*tree)(NanoBytes) = nullptr;
};

const std::vector<KnownType>& known_types() {
  using nanovdb::GridType;
  using namespace openvdb;
  static const std::vector<KnownType> types{
      {GridType::Float, {"float", FloatGrid::gridType()}, make_tree<float, FloatGrid>},
      {GridType::Double, {"double", DoubleGrid::gridType()}, make_tree<double, DoubleGrid>},
      {GridType::Int16, {"int16", Int32Grid::gridType()}, make_tree<std::int16_t, Int32Grid>},
      {GridType::Int32, {"int32", Int32Grid::gridType()}, make_tree<std::int32_t, Int32Grid>},
      {GridType::Int64, {"int64", Int64Grid::gridType()}, make_tree<std::int64_t, Int64Grid>},
      {GridType::UInt32, {"uint32", Int64Grid::gridType()}, make_tree<std::uint32_t, Int64Grid>},
      {GridType::Vec3f, {"Vec3f", Vec3SGrid::gridType()}, make_tree<nanovdb::Vec3f, Vec3SGrid>},
      {GridType::Vec3d, {"Vec3d", Vec3DGrid::gridType()}, make_tree<nanovdb::Vec3d, Vec3DGrid>},
      {GridType::Mask, {"mask", MaskGrid::gridType()}, make_tree<nanovdb::ValueMask, BoolGrid>},
      {GridType::Boolean, {"bool", BoolGrid::gridType()}, make_tree<bool, BoolGrid>},
      {GridType::Fp4, {"Fp4", FloatGrid::gridType(), true}, make_tree<nanovdb::Fp4, FloatGrid>},
      {GridType::Fp8, {"Fp8", FloatGrid::gridType(), true}, make_tree<nanovdb::Fp8, FloatGrid>},
      {GridType::Fp16, {"Fp16", FloatGrid::gridType(), true}, make_tree<nanovdb::Fp16, FloatGrid>},
      {GridType::FpN, {"FpN", FloatGrid::gridType(), true}, make_tree<nanovdb::FpN, FloatGrid>},
      {GridType::Half, {"half"}},
      {GridType::RGBA8, {"RGBA8"}},
      {GridType::Vec4f, {"Vec4f"}},
      {GridType::Vec4d, {"Vec4d"}},
      {GridType::Index, {"index"}},
      // since version 32.5: not every header has them
      {GridType(20), {"OnIndex"}},
      {GridType(21), {"IndexMask"}},
      {GridType(22), {"OnIndexMask"}},
      {GridType(23), {"PointIndex"}},
      {GridType(24), {"Vec3u8"}},
      {GridType(25), {"Vec3u16"}},
      {GridType(26), {"uint8", Int32Grid::gridType()}, make_tree<std::uint8_t, Int32Grid>}};
  return types;
}

const KnownType& find_type(std::uint32_t type, std::uint32_t grid_class) {
  static const KnownType unknown{nanovdb::GridType::Unknown, {"unknown"}};
  static const KnownType points{nanovdb::GridType::UInt32,
                                {"points", points_grid_type()},
                                make_tree<std::uint32_t, openvdb::Int32Grid, /*points=*/true>};
  static const KnownType index{nanovdb::GridType::UInt32, {"point index"}};
  if (type == std::uint32_t(nanovdb::GridType::UInt32)) {
    if (grid_class == std::uint32_t(nanovdb::GridClass::PointData)) return points;
    if (grid_class == std::uint32_t(nanovdb::GridClass::PointIndex)) return index;
  }
  for (const KnownType& known : known_types())
    if (std::uint32_t(known.type) == type) return known;
  return unknown;
}

}  // namespace

NanoType nano_type(std::uint32_t type, std::uint32_t grid_class) {
  return find_type(type, grid_class).as;
}

openvdb::GridClass nano_class(std::uint32_t grid_class) {
  switch (nanovdb::GridClass(grid_class)) {
    case nanovdb::GridClass::LevelSet:
      return openvdb::GRID_LEVEL_SET;
    case nanovdb::GridClass::FogVolume:
      return openvdb::GRID_FOG_VOLUME;
    case nanovdb::GridClass::Staggered:
      return openvdb::GRID_STAGGERED;
    default:
      return openvdb::GRID_UNKNOWN;
  }
}

std::uint32_t nano_major_version() { return NANOVDB_MAJOR_VERSION_NUMBER; }

openvdb::GridBase::Ptr nano_head(NanoBytes bytes, std::uint32_t type, std::uint32_t grid_class) {
  if (bytes.size() < sizeof(nanovdb::GridData)) refuse_nano("its header is cut off");
  const auto& data = *reinterpret_cast<const nanovdb::GridData*>(bytes.data());
  std::uint32_t stored_type, stored_class;  // an enumeration can have any value here
  std::memcpy(&stored_type, &data.mGridType, sizeof stored_type);
  std::memcpy(&stored_class, &data.mGridClass, sizeof stored_class);
  if (data.mVersion.getMajor() != nano_major_version() || stored_type != type ||
      stored_class != grid_class || data.mGridSize > bytes.size())
    refuse_nano("its header and the file's directory differ");
  const auto head =
      openvdb::GridBase::createGrid(stored_like(nano_type(type, grid_class).grid_type));
  head->setGridClass(nano_class(grid_class));
  const nanovdb::Map& map = data.mMap;
  // NanoVDB's vectors are columns, OpenVDB's rows
  auto matrix = openvdb::Mat4d::identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) matrix(column, row) = map.mMatD[3 * row + column];
  matrix.setTranslation(openvdb::Vec3d(map.mVecD[0], map.mVecD[1], map.mVecD[2]));
  head->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  return head;
}

std::unique_ptr<NanoTree> nano_tree(NanoBytes bytes, std::uint32_t type, std::uint32_t grid_class) {
  return find_type(type, grid_class).tree(bytes);
}

}  // namespace psivox::vdb
