// Grids whose voxels have no values of their own: points, masks, and the active voxels of any grid.

#include <openvdb/points/PointConversion.h>

#include "psivox/medium.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;
using namespace openvdb::points;

using Position = openvdb::Vec3f;

/// `count` points in a ball, with the positions' codec and an attribute of two more codecs.
template <typename Codec>
PointDataGrid::Ptr points(int count, const openvdb::Vec3d& move = openvdb::Vec3d(0)) {
  openvdb::initialize();
  std::vector<Position> at;
  std::vector<float> sizes;
  for (int i = 0; i < count; ++i) {
    const Coord n(i, i / 7, 3 * i);
    at.push_back(Position(float(noise(n) % 997) / 40 - 12, float(noise(n + Coord(1)) % 991) / 40,
                          float(noise(n + Coord(2)) % 983) / 40 - 3));
    sizes.push_back(float(i));
  }
  const auto transform = Transform::createLinearTransform(0.5);
  transform->postTranslate(move);
  const PointAttributeVector<Position> wrapped(at);
  const auto index =
      openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(wrapped, *transform);
  const auto grid = createPointDataGrid<Codec, PointDataGrid>(*index, wrapped, *transform);
  appendAttribute<float, TruncateCodec>(grid->tree(), "size");
  populateAttribute<PointDataTree, openvdb::tools::PointIndexTree, PointAttributeVector<float>>(
      grid->tree(), index->tree(), "size", PointAttributeVector<float>(sizes));
  appendAttribute<int>(grid->tree(), "same", /*uniformValue=*/7);
  grid->setName("points");
  return grid;
}

/// The field's values are what OpenVDB counts in each voxel.
void expect_counts(const PointDataGrid& grid, const Field& field) {
  EXPECT_EQ(field.channels, 1);
  EXPECT_EQ(field.value_type, "points");
  EXPECT_EQ(field.active_voxels, grid.activeVoxelCount());
  ASSERT_EQ(field.leaves.size(), grid.tree().leafCount());
  auto leaf = grid.tree().cbeginLeaf();
  for (const Leaf& is : field.leaves) {
    ASSERT_EQ(is.origin, (glm::ivec3(leaf->origin().x(), leaf->origin().y(), leaf->origin().z())));
    for (openvdb::Index i = 0; i < 512; ++i)
      ASSERT_EQ(double(is.values[i]),
                double(iterCount(leaf->beginIndexVoxel(leaf->offsetToGlobalCoord(i)))));
    ++leaf;
  }
}

TEST(Points, AreTheirNumberInEachVoxel) {
  const auto few = points<NullCodec>(2000);
  few->insertMeta("author", openvdb::StringMetadata("somebody"));
  const auto truncated = points<TruncateCodec>(2000), fixed = points<FixedPointCodec<true>>(2000);
  truncated->setName("truncated");
  fixed->setName("fixed");
  using Whole = TypedAttributeArray<int, TruncateCodec>;  // OpenVDB does not register it
  if (!Whole::isRegistered()) Whole::registerType();
  appendAttribute<int, TruncateCodec>(fixed->tree(), "id");
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const VolumeFile file(written({few, truncated, fixed}, codec));
    expect_counts(*few, file.read("points"));
    expect_counts(*truncated, file.read("truncated"));
    expect_counts(*fixed, file.read("fixed", {.role = GridRole::data}));
    const GridInfo info = file.info().at(0);
    EXPECT_EQ(info.problem, "");
    EXPECT_EQ(info.value_type, "points");
    EXPECT_EQ(info.metadata.at("author"), "somebody");
    EXPECT_GE(info.values->greatest, 2);
    EXPECT_TRUE(file.holds_something("fixed"));
  }
}

TEST(Points, OfNanoVdbAreTheirNumberInEachVoxel) {
  if (!has_nano_tool()) GTEST_SKIP() << no_nano_tool;
  const auto few = points<NullCodec>(2000, {1, 2, 3});
  const VolumeFile nano(written_nano({few})), vdb(write_vdb({few}));
  expect_counts(*few, nano.read("points"));
  const GridInfo row = nano.info().at(0), wanted = vdb.info().at(0);
  EXPECT_EQ(row.type, wanted.type);
  EXPECT_EQ(row.value_type, wanted.value_type);
  EXPECT_EQ(row.active_box, wanted.active_box);
  EXPECT_EQ(row.world_from_index, wanted.world_from_index);
  EXPECT_EQ(row.values->mean, wanted.values->mean);
  EXPECT_GE(row.values->greatest, 2);
}

TEST(Points, MayHaveManyPagesOfAttributes) {
  const auto grid = points<NullCodec>(100'000);  // a page is 1 MiB
  expect_counts(*grid, VolumeFile(write_vdb({grid})).read("points", {.memory = 10 << 20}));
}

TEST(Points, OfAnUnknownAttributeLeaveTheOtherGrids) {
  const auto grid = points<NullCodec>(500);
  std::string bytes = file_bytes(write_vdb({grid, voxel("after", 3, Coord(1))}));
  const std::size_t at = bytes.find("trnc");
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 4, "abcd");
  const VolumeFile file(write_bytes("unknown.vdb", bytes));
  EXPECT_TRUE(has(input_error([&] { file.read("points"); }), "abcd"));
  EXPECT_EQ(file.default_grid(), "after");
  EXPECT_EQ(FieldVoxels(file.read("after")).voxel({1, 1, 1}, 0), 3);
}

TEST(Points, OfAFileWithoutPositionsLeaveTheOtherGrids) {
  const auto grid = points<NullCodec>(500);
  const VolumeFile file(write_bytes("piped.vdb", piped_bytes({grid, voxel("after", 3, Coord(1))})));
  expect_counts(*grid, file.read("points"));
  EXPECT_EQ(FieldVoxels(file.read("after")).voxel({1, 1, 1}, 0), 3);
}

TEST(Points, AreDrawnBesideVectors) {
  const auto vectors = named<openvdb::Vec3SGrid>("vectors");
  vectors->tree().addTile(2, Coord(0), openvdb::Vec3f(1), true);
  EXPECT_EQ(VolumeFile(write_vdb({vectors, points<NullCodec>(10)})).default_grid(), "points");
}

TEST(Points, AGridWithoutPointsIsEmptyToEveryQuestion) {
  const auto empty = createPointDataGrid<NullCodec, PointDataGrid>(
      std::vector<openvdb::Vec3R>(), *openvdb::math::Transform::createLinearTransform(1));
  empty->setName("points");
  const VolumeFile file(write_vdb({empty}));
  EXPECT_EQ(file.content("points").nothing, "has no active voxel");
  EXPECT_EQ(file.info().at(0).problem, "has no active voxel: nothing to render");
  EXPECT_TRUE(has(input_error([&] { file.read("points"); }), "has no active voxel"));
}

TEST(Points, OutOfOrderAreAnError) {
  const auto grid = points<NullCodec>(40);
  grid->tree().beginLeaf()->setOffsetOnly(0, 1'000'000);
  const VolumeFile wrong(write_vdb({grid}));
  EXPECT_TRUE(has(input_error([&] { wrong.read("points"); }), "points are out of order"));
}

TEST(Points, AFrustumIsResampled) {
  const auto grid = points<NullCodec>(500);
  grid->setTransform(Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(-40), openvdb::Vec3d(60)), 2, 10, 0.25));
  const Field field = VolumeFile(write_vdb({grid})).read("points");
  EXPECT_EQ(field.value_type, "points");
  EXPECT_TRUE(has(field.notices.at(0), "frustum"));
}

// --- masks and active voxels ---------------------------------------------------------------------

template <typename GridT>
typename GridT::Ptr with_topology(const std::string& name) {
  using ValueT = typename GridT::ValueType;
  const auto grid = named<GridT>(name);
  if constexpr (!std::is_same_v<GridT, openvdb::MaskGrid>)
    grid->tree().root().setBackground(ValueT(1), /*updateChildNodes=*/false);
  grid->tree().setValue(Coord(1, 2, 3), ValueT(1));
  grid->tree().setValueOff(Coord(1, 2, 4));
  if constexpr (!std::is_same_v<GridT, openvdb::MaskGrid>)
    grid->tree().setValueOnly(Coord(1, 2, 3), openvdb::zeroVal<ValueT>());
  grid->tree().addTile(1, Coord(16, 0, 0), openvdb::zeroVal<ValueT>(), true);
  grid->tree().addTile(1, Coord(32, 0, 0), ValueT(1), false);
  grid->insertMeta("author", openvdb::StringMetadata("somebody"));
  return grid;
}

void expect_activity(const Field& field) {
  EXPECT_EQ(field.channels, 1);
  EXPECT_EQ(field.active_voxels, 513u);
  EXPECT_EQ(field.notices, std::vector<std::string>{});
  const FieldVoxels sampler(field);
  EXPECT_EQ(sampler.voxel({1, 2, 3}, 0), 1);
  EXPECT_EQ(sampler.voxel({1, 2, 4}, 0), 0);
  EXPECT_EQ(sampler.voxel({17, 7, 7}, 0), 1);
  EXPECT_EQ(sampler.voxel({33, 7, 7}, 0), 0);
  EXPECT_EQ(sampler.voxel({1, 9, 3}, 0), 0);
}

TEST(Activity, IsOneAtActiveVoxelsOfEveryType) {
  const openvdb::GridCPtrVec grids{
      with_topology<FloatGrid>("float"),          with_topology<openvdb::DoubleGrid>("double"),
      with_topology<openvdb::Int32Grid>("int32"), with_topology<openvdb::Int64Grid>("int64"),
      with_topology<openvdb::BoolGrid>("bool"),   with_topology<openvdb::MaskGrid>("mask"),
      with_topology<openvdb::Vec3SGrid>("vec3s"), with_topology<openvdb::Vec3DGrid>("vec3d"),
      with_topology<openvdb::Vec3IGrid>("vec3i")};
  for (const auto& path : {write_vdb(grids), write_bytes("piped.vdb", piped_bytes(grids))}) {
    const VolumeFile file(path);
    for (const std::string& name : file.names()) {
      SCOPED_TRACE(name);
      const Field field = file.read(name, {.active = true});
      EXPECT_EQ(field.name, name + ":active");
      expect_activity(field);
    }
    const Field mask = file.read("mask");
    EXPECT_EQ(mask.value_type, "mask");
    expect_activity(mask);
    EXPECT_TRUE(file.holds_something("mask"));
    EXPECT_FALSE(file.holds_something("float"));
    EXPECT_EQ(file.info().at(5).problem, "");
    EXPECT_EQ(file.info().at(5).metadata.at("author"), "somebody");
  }
}

TEST(Activity, ColoursOfAnyBackgroundLightTheActiveVoxels) {
  for (const float background : {-1.0f, 1.0f}) {
    SCOPED_TRACE(background);
    const auto grid = voxel<openvdb::Vec3SGrid>("Cd", openvdb::Vec3f(0.5f, -2, 0.25f));
    grid->tree().root().setBackground(openvdb::Vec3f(background), /*updateChildNodes=*/false);
    grid->tree().setValue(Coord(5), openvdb::Vec3f(background));
    Scene scene;
    scene.grid = "Cd:active";
    scene.luminance_grid = "Cd";
    const MediumFields fields = read_fields(scene, VolumeFile(write_vdb({grid})));
    EXPECT_EQ(fields.density->name, "Cd:active");
    const FieldVoxels density(*fields.density), colour(*fields.luminance);
    EXPECT_EQ(density.voxel({0, 0, 0}, 0), 1);
    EXPECT_EQ(density.voxel({1, 0, 0}, 0), 0);
    const double expected[] = {0.5, 0, 0.25};
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(colour.voxel({0, 0, 0}, c), expected[c]);
      EXPECT_EQ(colour.voxel({1, 0, 0}, c), expected[c]) << "as beside it, so as not to be dark";
      EXPECT_EQ(colour.voxel({2, 2, 2}, c), 0);
      EXPECT_EQ(colour.voxel({5, 5, 5}, c), background > 0 ? 1 : 0);
    }
    scene.grid = "Cd:x";
    EXPECT_EQ(read_fields(scene, VolumeFile(write_vdb({grid}))).density->name, "Cd:x");
  }
}

TEST(Activity, IsKnownOfGridsInMemoryToo) {
  const auto grid = voxel<openvdb::Vec3SGrid>("v", openvdb::Vec3f(0, 0, -4), Coord(1, 2, 3));
  grid->tree().addTile(1, Coord(16, 0, 0), openvdb::Vec3f(0, -1, 0), true);
  const VolumeFile file(write_vdb({grid}));
  const auto inner = std::make_shared<VolumeFile>(
      std::make_shared<const Field>(file.read("v", {.role = GridRole::data})));
  const Field field = VolumeFile({{"w", inner, "v"}}).read("w", {.active = true});
  EXPECT_EQ(field.name, "w:active");
  expect_activity(field);
}

}  // namespace
}  // namespace psivox
