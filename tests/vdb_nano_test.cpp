// .nvdb files that NanoVDB's own tool writes: they are read as the .vdb that they were made from.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fuzz/packed_grid.h"
#include "scratch.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using openvdb::GridBase;
using test::ball_with_tiles;
using test::with;
using test::written_nano;

using NanoVdb = test::NanoTest;

/// The largest difference of the values of two fields that have the same leaves.
float difference(const Field& a, const Field& b) {
  EXPECT_EQ(a.leaves.size(), b.leaves.size());
  float most = 0;
  for (std::size_t n = 0; n < std::min(a.leaves.size(), b.leaves.size()); ++n) {
    EXPECT_EQ(a.leaves[n].origin, b.leaves[n].origin);
    for (std::size_t i = 0; i < 512 * std::size_t(a.channels); ++i)
      most = std::max(most, std::abs(a.leaves[n].values[i] - b.leaves[n].values[i]));
  }
  return most;
}

void expect_same(const VolumeFile& nano, const VolumeFile& vdb) {
  const std::vector<GridInfo> rows = nano.info(true), wanted = vdb.info(true);
  ASSERT_EQ(nano.names(), vdb.names());
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    SCOPED_TRACE(wanted[n].name);
    EXPECT_EQ(rows[n].problem, wanted[n].problem);
    EXPECT_EQ(rows[n].type, wanted[n].type);
    EXPECT_EQ(rows[n].value_type, wanted[n].value_type);
    EXPECT_EQ(rows[n].grid_class, wanted[n].grid_class);
    EXPECT_EQ(rows[n].transform, "AffineMap");  // NanoVDB has no other
    EXPECT_EQ(rows[n].world_from_index, wanted[n].world_from_index);
    EXPECT_EQ(rows[n].active_voxels, wanted[n].active_voxels);
    EXPECT_EQ(rows[n].active_tiles, wanted[n].active_tiles);
    EXPECT_EQ(rows[n].active_box, wanted[n].active_box);
    EXPECT_EQ(rows[n].background, wanted[n].background);
    ASSERT_TRUE(rows[n].values && wanted[n].values);
    EXPECT_EQ(rows[n].values->mean, wanted[n].values->mean);
    const Field a = nano.read(rows[n].name), b = vdb.read(wanted[n].name);
    ASSERT_EQ(a.channels, b.channels);
    EXPECT_TRUE(test::same(a.leaves, b.leaves, b.channels));
    EXPECT_TRUE(test::same(a.tiles, b.tiles));
    EXPECT_EQ(a.notices, b.notices);
  }
}

TEST_F(NanoVdb, GridsOfEachTypeAndCodecAreReadAsTheirVdb) {
  using namespace openvdb;
  const auto b = ball_with_tiles<BoolGrid>("b"), density = ball_with_tiles<FloatGrid>("density"),
             l = ball_with_tiles<Int64Grid>("l");
  density->setGridClass(GRID_FOG_VOLUME);
  // becomes another float if it becomes a double first
  constexpr Int64 between = (Int64{1} << 60) + (Int64{1} << 36) + 1;
  static_cast<Int64Grid&>(*l).tree().setValue(Coord(0), between);
  const GridCPtrVec grids{b,       ball_with_tiles<DoubleGrid>("d"),
                          density, ball_with_tiles<Int32Grid>("i"),
                          l,       ball_with_tiles<Vec3SGrid>("v")};
  const VolumeFile vdb(test::written(grids, io::COMPRESS_NONE));
  for (const char* const codec : {"", "--zip", "--blosc"}) {
    SCOPED_TRACE(codec);
    expect_same(VolumeFile(written_nano(grids, codec)), vdb);
  }
}

TEST_F(NanoVdb, MasksLevelSetsBackgroundsAndRepeatedNamesAreReadAsTheirVdb) {
  using namespace openvdb;
  const auto mask = test::named<MaskGrid>("m");
  mask->fill(CoordBBox(Coord(-3), Coord(11)), true);
  const auto ball = ball_with_tiles<FloatGrid>("density");
  static_cast<FloatGrid&>(*ball).tree().root().setBackground(1, true);
  const GridCPtrVec grids{test::level_set_ball<FloatGrid>("density"), ball, mask};
  expect_same(VolumeFile(written_nano(grids, "--zip")),
              VolumeFile(test::written(grids, io::COMPRESS_ZIP)));
}

TEST_F(NanoVdb, QuantisedValuesAreWithinTheirQuantum) {
  const auto grid = ball_with_tiles<openvdb::FloatGrid>("density");
  const Field exact = VolumeFile(test::written({grid}, openvdb::io::COMPRESS_NONE)).read("density");
  constexpr float range = 65;  // of ball's values
  const auto error = [&](const std::string& type) {
    const VolumeFile file(written_nano({grid}, "--blosc --" + type, type + ".nvdb"));
    EXPECT_EQ(file.value_type("density"), "float");
    return difference(file.read("density"), exact);
  };
  const float of_4 = error("fp4"), of_8 = error("fp8"), of_16 = error("fp16");
  EXPECT_LE(of_4, range / 15 / 2 * 1.001f);
  EXPECT_LE(of_8, range / 255 / 2 * 1.001f);
  EXPECT_LE(of_16, range / 65535 / 2 * 1.01f);
  EXPECT_GT(of_4, of_8);
  EXPECT_GT(of_8, of_16);
  EXPECT_LE(error("fpN"), range / 15);
}

TEST_F(NanoVdb, TheBackgroundOfQuantisedValuesBecomesZero) {
  const auto grid = test::named("density");
  grid->tree().root().setBackground(1, true);
  grid->tree().setValue(openvdb::Coord(1, 2, 3), 0.3f);
  grid->tree().setValue(openvdb::Coord(4, 4, 4), 2.7f);
  const Field field = VolumeFile(written_nano({grid}, "--fp8")).read("density");
  ASSERT_EQ(field.leaves.size(), 1u);
  EXPECT_EQ(std::count_if(field.leaves[0].values, field.leaves[0].values + 512,
                          [](float value) { return value != 0; }),
            2);
}

/// What is read of a grid of one voxel that NanoVDB 32.4 wrote, of a type that its tool does not
/// make.
void expect_voxel(const std::string& type, const std::string& read_as, double value) {
  SCOPED_TRACE(type);
  const std::string packed =
      test::file_bytes(test::assets_dir() / "../tests/fuzz/corpus/nano" / type);
  const VolumeFile file(test::write_bytes(type + ".nvdb", fuzz::unpacked_grid(packed)));
  const std::vector<GridInfo> rows = file.info(true);
  EXPECT_EQ(rows.at(0).value_type, read_as);
  EXPECT_EQ(rows[0].active_voxels, 1);
  EXPECT_EQ(value < 0 ? rows[0].values->least : rows[0].values->greatest, value);
}

TEST(RecordedNanoVdb, VectorsOfDoublesKeepTheirPrecision) { expect_voxel("vec3d", "vec3d", 0.1); }

/// NanoVDB 32.4 does not name bytes, whose number stands in the file.
TEST(RecordedNanoVdb, IntegersThatOpenVdbLacksAreWidened) {
  expect_voxel("int16", "int32", -7);
  expect_voxel("uint32", "int64", 3000000000.0);
  expect_voxel("uint8", "int32", 200);
}

/// Two grids as they are in memory, without headers and entries.
TEST_F(NanoVdb, BareGridsAreRead) {
  std::string bare;
  const auto add = [&](const GridBase::Ptr& grid) {
    const std::string bytes = test::file_bytes(written_nano({grid}));
    bare += "NanoVDB1" + bytes.substr(bytes.find("NanoVDB", 8) + 8);
  };
  const auto density = ball_with_tiles<openvdb::FloatGrid>("density"),
             v = ball_with_tiles<openvdb::Vec3SGrid>("v");
  add(density);
  add(v);
  expect_same(VolumeFile(test::write_bytes("bare.nvdb", bare)),
              VolumeFile(test::written({density, v}, openvdb::io::COMPRESS_NONE)));
}

TEST_F(NanoVdb, AnUnsupportedGridLeavesTheOthers) {
  constexpr std::size_t type = 48;  // of the first grid
  const std::string good =
      test::file_bytes(written_nano({ball_with_tiles<openvdb::FloatGrid>("density"),
                                     ball_with_tiles<openvdb::FloatGrid>("rgba")}));
  const VolumeFile file(test::write_bytes("rgba.nvdb", with(good, type, 12u)));
  EXPECT_EQ(file.names(), (std::vector<std::string>{"density", "rgba"}));
  EXPECT_EQ(file.channels("density"), 0);
  EXPECT_FALSE(file.read("rgba").leaves.empty());
}

}  // namespace
}  // namespace psivox
