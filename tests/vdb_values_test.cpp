// VolumeFile on grids made here: value types, bad values, transforms.

#include <openvdb/tools/Interpolation.h>

#include <limits>
#include <numbers>

#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(VdbValues, PercentilesAreOfActiveVoxelsAndATileCountsAsItsVoxels) {
  auto grid = named<FloatGrid>("g");
  for (int i = 0; i < 100; ++i) grid->tree().setValue(Coord(i, 0, 0), float(i - 20));
  grid->tree().setValueOff(Coord(0, 1, 0), 1000);
  ReadOptions options{.role = GridRole::data, .percentiles = {0, 1, 50, 100}};
  const auto percentiles = [&] {
    return VolumeFile(write_vdb({grid})).read("g", options).active_percentiles;
  };
  using Percentiles = std::map<double, double>;
  EXPECT_EQ(percentiles(), (Percentiles{{0, -20}, {1, -20}, {50, 29}, {100, 79}}));
  grid->tree().addTile(1, Coord(0, 8, 8), 500, true);
  EXPECT_EQ(percentiles(), (Percentiles{{0, -20}, {1, -14}, {50, 500}, {100, 500}}));
  // all values have zeros for their lower 16 bits; then one does not
  grid = named<FloatGrid>("g");
  for (int i = 0; i < 100; ++i) grid->tree().setValue(Coord(i, 0, 0), float(i));
  EXPECT_EQ(percentiles(), (Percentiles{{0, 0}, {1, 0}, {50, 49}, {100, 99}}));
  grid->tree().setValue(Coord(99, 0, 0), std::nextafter(98.0f, 99.0f));
  EXPECT_EQ(percentiles(),
            (Percentiles{{0, 0}, {1, 0}, {50, 49}, {100, double(std::nextafter(98.0f, 99.0f))}}));
}

/// The file is OpenVDB 13's, whose program set voxels (i, 2 i, 3) to (i + 1) / 10 and a tile of 8
/// voxels at (32, 0, 0) to 0.7.
TEST(VdbValues, GridsOfHalfFloatsAreRead) {
  const VolumeFile vdb(test::assets_dir().parent_path() / "tests/recorded/openvdb-13-half.vdb");
  EXPECT_EQ(FieldVoxels(vdb.read("float")).voxel({1, 2, 3}, 0), 4.0);
  EXPECT_EQ(vdb.info().at(0).value_type, "half");
  const Field field = vdb.read("density");
  const FieldVoxels read(field);
  const auto rounded = [](float value) { return double(float(openvdb::math::half(value))); };
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(read.voxel({i, 2 * i, 3}, 0), rounded(0.1f * float(i + 1))) << i;
  EXPECT_EQ(read.voxel({35, 7, 1}, 0), rounded(0.7f));
}

TEST(VdbValues, BadValuesAreReplacedAndCounted) {
  auto grid = named<FloatGrid>("x");
  auto& tree = grid->tree();
  tree.setValue(Coord(0, 0, 0), kNan);
  tree.setValue(Coord(0, 0, 1), kInfinity);
  tree.setValue(Coord(0, 0, 2), -kInfinity);
  tree.setValue(Coord(0, 0, 3), -3.0f);
  tree.setValue(Coord(0, 0, 4), 5.5f);
  tree.setValueOff(Coord(0, 0, 5), -1.0f);
  tree.setValue(Coord(0, 0, 6), -0.0f);
  tree.addTile(1, Coord(16, 0, 0), -2.0f, true);
  tree.addTile(1, Coord(32, 0, 0), kInfinity, true);
  tree.addTile(1, Coord(48, 0, 0), kNan, true);
  tree.addTile(1, Coord(64, 0, 0), 6.5f, true);
  const VolumeFile vdb(write_vdb({grid}));
  const Field field = vdb.read("x");
  ASSERT_EQ(field.notices.size(), 1u);
  EXPECT_EQ(field.notices[0],
            "grid 'x': 2 NaN, 1 -Inf, 3 negative values taken as 0; 2 +Inf taken as 6.5");
  EXPECT_EQ(field.replaced.negative, 3u);
  EXPECT_EQ(field.replaced.least, -3);
  ASSERT_EQ(field.tiles.size(), 2u);
  const FieldVoxels sampler(field);
  const double expected[] = {0, 6.5, 0, 0, 5.5, 0, 0};
  for (int z = 0; z < 7; ++z) EXPECT_EQ(sampler.voxel({0, 0, z}, 0), expected[z]) << z;
  EXPECT_EQ(sampler.voxel({33, 1, 1}, 0), 6.5);
  EXPECT_EQ(vdb.read("x", {GridRole::luminance}).notices, field.notices);

  // The transfer function decides how negative data is used.
  const Field data = vdb.read("x", {GridRole::data});
  EXPECT_EQ(data.notices.at(0), "grid 'x': 2 NaN, 1 -Inf values taken as 0; 2 +Inf taken as 6.5");
  EXPECT_EQ(data.replaced.nan, 2u);
  EXPECT_EQ(data.replaced.least, 0);
  EXPECT_EQ(FieldVoxels(data).voxel({0, 0, 3}, 0), -3.0);

  const std::string message = input_error([&] { vdb.read("x", {GridRole::attenuation, true}); });
  EXPECT_TRUE(has(message, "grid 'x' is refused by strict reading: 2 NaN"));
}

/// Where a density is read, what is no data stays absent.
TEST(VdbValues, FillValuesAreNoData) {
  const auto read = [](float fill, float scale, GridRole role, const ReadOptions& more = {}) {
    const auto grid = named<FloatGrid>("x");
    for (int i = 0; i < 1000; ++i)
      grid->tree().setValue(Coord(i / 100, i / 10 % 10, i % 10),
                            i < 100 ? fill : scale * float(i) / 1000);
    ReadOptions options = more;
    options.role = role;
    options.absent = true;
    return VolumeFile(write_vdb({grid})).read("x", options);
  };
  const float most = std::numeric_limits<float>::max();
  // ends of float32, climate models, scanners, many programs
  for (const auto& [fill, scale] : {std::pair(-most, 1.0f),
                                    {most, 1.0f},
                                    {5e37f, 1.0f},
                                    {1e20f, 300.0f},
                                    {-3024.0f, 3000.0f},
                                    {-9999.0f, 40.0f}})
    for (const GridRole role : {GridRole::attenuation, GridRole::data}) {
      SCOPED_TRACE(fill);
      const Field field = read(fill, scale, role);
      EXPECT_TRUE(field.absent);
      EXPECT_EQ(field.replaced.filled, 100u);
      EXPECT_TRUE(std::isnan(FieldVoxels(field).voxel({0, 0, 0}, 0)));
      EXPECT_LE(greatest_value(field), 0.999f * scale);
      EXPECT_GE(stored_range(field).x, 0);
      EXPECT_TRUE(has(field.notices.at(0), "100 values of ")) << field.notices[0];
    }
  // neither undershoots, nor values of both signs, nor number densities in many decades
  for (const auto& [value, scale] : {std::pair(-0.02f, 1.0f), {-1000.0f, 3e4f}, {1e24f, 1e20f}})
    EXPECT_FALSE(read(value, scale, GridRole::data).absent) << value;
  EXPECT_FALSE(read(-3024, 3000, GridRole::data, {.fill = false}).absent);
  EXPECT_EQ(stored_range(read(-most, 1, GridRole::data, {.fill = false})).x,
            double(-greatest_magnitude));
  EXPECT_EQ(read(7, 1, GridRole::data, {.fill = false, .fill_value = 7.0f}).replaced.filled, 100u);
  const auto signs = named<FloatGrid>("x");
  for (const Coord& p : CoordBBox(Coord(0), Coord(9)))
    signs->tree().setValue(p, float(p.x() % 4) - 1);
  EXPECT_FALSE(VolumeFile(write_vdb({signs})).read("x", {.absent = true}).absent);
}

TEST(VdbValues, InfoCountsFillValuesApart) {
  for (const float fill : {-3024.0f, -std::numeric_limits<float>::max()}) {
    const auto grid = named<FloatGrid>("x");
    for (int i = 0; i < 1000; ++i)
      grid->tree().setValue(Coord(i / 100, i / 10 % 10, i % 10), i < 100 ? fill : float(i));
    const GridInfo row = VolumeFile(write_vdb({grid})).info().at(0);
    EXPECT_EQ(row.values->least, 100);
    EXPECT_EQ(row.values->greatest, 999);
    EXPECT_NEAR(row.values->mean, 549.5, 1e-9);  // rounding of a thousand sums
    EXPECT_EQ(row.values->filled, 100u);
    EXPECT_EQ(row.values->fill, double(fill));
  }
}

TEST(VdbValues, InfinityAloneBecomesOne) {
  const auto grid = voxel<openvdb::DoubleGrid>("x", std::numeric_limits<double>::infinity());
  const Field field = VolumeFile(write_vdb({grid})).read("x");
  EXPECT_EQ(FieldVoxels(field).voxel({0, 0, 0}, 0), 1.0);
  EXPECT_EQ(field.notices.at(0), "grid 'x': 1 +Inf taken as 1");
}

TEST(VdbValues, ALevelSetOfDoublesIsThatOfFloats) {
  const VolumeFile vdb(write_vdb(
      {level_set_ball<FloatGrid>("floats"), level_set_ball<openvdb::DoubleGrid>("doubles")}));
  for (const bool distances : {false, true}) {
    const ReadOptions options{.role = GridRole::data, .distances = distances};
    const Field a = vdb.read("floats", options), b = vdb.read("doubles", options);
    EXPECT_EQ(b.value_type, "double");
    EXPECT_EQ(a.half_width, b.half_width);
    EXPECT_EQ(a.active_box, b.active_box);
    EXPECT_EQ(a.active_voxels, b.active_voxels);
    EXPECT_EQ(a.active_range, b.active_range);
    EXPECT_EQ(a.world_from_index, b.world_from_index);
    ASSERT_EQ(a.tiles.size(), 1u);
    ASSERT_EQ(b.tiles.size(), 1u);
    EXPECT_EQ(a.tiles[0].value.x, distances ? 6.0f : 1.0f);
    EXPECT_EQ(b.tiles[0].value.x, a.tiles[0].value.x);
    EXPECT_GT(a.leaves.size(), 8u);
    ASSERT_EQ(a.leaves.size(), b.leaves.size());
    for (std::size_t n = 0; n < a.leaves.size(); ++n) {
      ASSERT_EQ(a.leaves[n].origin, b.leaves[n].origin);
      for (int i = 0; i < 512; ++i) ASSERT_EQ(a.leaves[n].values[i], b.leaves[n].values[i]) << n;
    }
  }
}

TEST(VdbValues, AFogOfTheLevelSetsClassIsAFog) {
  const auto fog = of_class(named("density"), openvdb::GRID_LEVEL_SET);
  fog->fill(openvdb::CoordBBox(Coord(0), Coord(7)), 0.5f);
  const VolumeFile vdb(write_vdb({fog}));
  for (const bool distances : {false, true}) {
    const Field field = vdb.read("density", {.role = GridRole::data, .distances = distances});
    EXPECT_EQ(field.half_width, 0);
    EXPECT_EQ(field.active_range->y, 0.5);
    ASSERT_EQ(field.notices.size(), 1u);
    EXPECT_TRUE(has(field.notices[0], "taken as fog"));
  }
}

TEST(VdbTransforms, AffineTransformsAreTheMatrixThatOpenVdbApplies) {
  std::vector<Transform::Ptr> transforms;
  for (const openvdb::math::Axis axis :
       {openvdb::math::X_AXIS, openvdb::math::Y_AXIS, openvdb::math::Z_AXIS}) {
    auto quarter = Transform::createLinearTransform(0.5);
    quarter->postRotate(std::numbers::pi / 2, axis);
    quarter->postTranslate({1, 2, 3});
    transforms.push_back(quarter);
  }
  auto sheared = Transform::createLinearTransform(0.1);
  sheared->postShear(0.3, openvdb::math::X_AXIS, openvdb::math::Z_AXIS);
  sheared->preScale(openvdb::Vec3d(1, -2, 3));
  transforms.push_back(sheared);
  for (const Transform::Ptr& transform : transforms) {
    const auto grid = voxel("density", 1);
    grid->setTransform(transform);
    const VolumeFile vdb(write_vdb({grid}));
    const Field field = vdb.read("density");
    for (const glm::dvec3 p : {glm::dvec3(0, 0, 0), glm::dvec3(4, -7, 0.5)}) {
      const auto expected = transform->indexToWorld(openvdb::Vec3d(p.x, p.y, p.z));
      const glm::dvec4 actual = field.world_from_index * glm::dvec4(p, 1.0);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], 1e-14);
    }
    EXPECT_EQ(vdb.info().at(0).world_from_index, field.world_from_index);
    EXPECT_NEAR(vdb.info().at(0).voxel_size.x, transform->voxelSize()[0], 1e-14);
  }
}

TEST(VdbTransforms, AFrustumIsResampledIntoCubicVoxels) {
  // 40x40x20 voxels; the far end is twice as wide as the near one.
  const openvdb::BBoxd box(openvdb::Vec3d(0), openvdb::Vec3d(39, 39, 19));
  const auto frustum = Transform::createFrustumTransform(box, /*taper=*/0.5, /*depth=*/1.0, 0.05);
  auto grid = named<FloatGrid>("density");
  grid->setTransform(frustum);
  const auto value = [](const openvdb::Vec3d& p) {
    return std::exp(-8.0 * (p - openvdb::Vec3d(1.0, 1.0, 0.5)).lengthSqr());
  };
  for (const Coord& c : CoordBBox(Coord(0), Coord(39, 39, 19))) {
    grid->tree().setValue(c, static_cast<float>(value(frustum->indexToWorld(c))));
  }
  auto counts = named<openvdb::Int32Grid>("counts");
  counts->setTransform(frustum);
  counts->tree().fill(CoordBBox(Coord(4), Coord(16)), 8);
  const VolumeFile vdb(write_vdb({grid, counts}));
  EXPECT_EQ(vdb.info().at(0).problem, "");
  EXPECT_EQ(vdb.info().at(0).transform, "NonlinearFrustumMap");

  const Field field = vdb.read("density");
  ASSERT_EQ(field.notices.size(), 1u);
  EXPECT_TRUE(has(field.notices[0], "frustum transform resampled to cubic voxels of size"));
  const double voxel_size = field.world_from_index[0][0];
  EXPECT_LE(voxel_size, 0.05);
  const FieldVoxels sampler(field);
  // Two interpolations, each off by at most h^2/8 * sum of second derivatives (16 * 3 here), with h
  // = 0.1 across the far end at worst: 0.06 together; far less where the Gaussian is flat.
  const glm::dvec3 origin(field.world_from_index[3]);
  for (const auto& c : {Coord(20, 20, 10), Coord(12, 22, 8), Coord(25, 18, 14)}) {
    const openvdb::Vec3d world = frustum->indexToWorld(c);
    const glm::dvec3 index = (glm::dvec3(world[0], world[1], world[2]) - origin) / voxel_size;
    EXPECT_NEAR(sampler.trilinear(index, 0), value(world), 0.06) << c;
  }
  EXPECT_TRUE(has(input_error([&] {
                    vdb.read("density", {GridRole::attenuation, true});
                  }),
                  "has a frustum transform"));

  // Other types convert through float: an inside of 8 stays 8.
  const Field resampled = vdb.read("counts");
  const openvdb::Vec3d world = frustum->indexToWorld(openvdb::Vec3d(10, 10, 10));
  const glm::dvec3 index =
      (glm::dvec3(world[0], world[1], world[2]) - glm::dvec3(resampled.world_from_index[3])) /
      resampled.world_from_index[0][0];
  EXPECT_NEAR(FieldVoxels(resampled).trilinear(index, 0), 8.0, 1e-5);
}

}  // namespace
}  // namespace psivox
