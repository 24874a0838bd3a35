// How VolumeFile reads: each byte about once, in few calls, and the same values as OpenVDB's own
// reader with every codec.

#include <openvdb/io/Compression.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "psivox/vdb.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;

/// All values of all leaves and tiles are those of OpenVDB's reader. Both convert by
/// static_cast<float>.
template <typename GridT>
void expect_values_of_openvdb(const std::filesystem::path& path, const std::string& name) {
  const Field field = VolumeFile(path).read(name, {GridRole::data});
  const auto grid = openvdb::gridPtrCast<GridT>(test::openvdb_grid(path, name));
  constexpr bool vectors = openvdb::VecTraits<typename GridT::ValueType>::IsVec;
  ASSERT_EQ(field.channels, vectors ? 3 : 1);
  EXPECT_EQ(field.value_type, grid->valueType());
  EXPECT_EQ(field.active_voxels, grid->activeVoxelCount());
  const auto box = grid->evalActiveVoxelBoundingBox();
  const auto expect_equal = [&](const auto& actual, const auto& value) {
    if constexpr (vectors)
      for (int c = 0; c < 3; ++c) ASSERT_EQ(actual[c], static_cast<float>(value[c])) << name;
    else
      ASSERT_EQ(actual[0], static_cast<float>(value)) << name;
  };
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(field.active_box.min[axis], box.min()[axis]);
    EXPECT_EQ(field.active_box.max[axis], box.max()[axis]);
  }
  EXPECT_EQ(field.tiles.size(), 3u);
  for (const Tile& tile : field.tiles)
    for (const int in : {0, tile.width - 1}) {
      const glm::ivec3 at = tile.origin + in;
      expect_equal(tile.value, grid->tree().getValue(Coord(at.x, at.y, at.z)));
    }
  ASSERT_EQ(field.leaves.size(), grid->tree().leafCount());
  for (const Leaf& leaf : field.leaves) {
    const Coord origin(leaf.origin.x, leaf.origin.y, leaf.origin.z);
    const auto* expected = grid->tree().probeConstLeaf(origin);
    ASSERT_NE(expected, nullptr);
    for (openvdb::Index n = 0; n < expected->SIZE; ++n)
      expect_equal(leaf.values + int(n) * field.channels, expected->getValue(n));
  }
}

TEST(VdbReading, EveryCodecAndTypeGivesTheValuesOfOpenVdb) {
  const auto half = ball_with_tiles<openvdb::FloatGrid>("half");
  half->setSaveFloatAsHalf(true);
  const auto half_vectors = ball_with_tiles<openvdb::Vec3DGrid>("vec3d");
  half_vectors->setSaveFloatAsHalf(true);
  const openvdb::GridCPtrVec grids{
      ball_with_tiles<openvdb::FloatGrid>("float"),   half,
      ball_with_tiles<openvdb::DoubleGrid>("double"), ball_with_tiles<openvdb::Int32Grid>("int32"),
      ball_with_tiles<openvdb::Int64Grid>("int64"),   ball_with_tiles<openvdb::BoolGrid>("bool"),
      ball_with_tiles<openvdb::Vec3SGrid>("vec3s"),   half_vectors,
      ball_with_tiles<openvdb::Vec3IGrid>("vec3i")};
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(grids, codec);
    expect_values_of_openvdb<openvdb::FloatGrid>(path, "float");
    expect_values_of_openvdb<openvdb::FloatGrid>(path, "half");
    expect_values_of_openvdb<openvdb::DoubleGrid>(path, "double");
    expect_values_of_openvdb<openvdb::Int32Grid>(path, "int32");
    expect_values_of_openvdb<openvdb::Int64Grid>(path, "int64");
    expect_values_of_openvdb<openvdb::BoolGrid>(path, "bool");
    expect_values_of_openvdb<openvdb::Vec3SGrid>(path, "vec3s");
    expect_values_of_openvdb<openvdb::Vec3DGrid>(path, "vec3d");
    expect_values_of_openvdb<openvdb::Vec3IGrid>(path, "vec3i");
  }
}

void expect_read_once(const std::filesystem::path& path, const Reads& reads) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  ASSERT_GT(size, 1 << 20) << "too small to tell";
  EXPECT_LE(static_cast<double>(reads.bytes), 1.2 * static_cast<double>(size)) << path;
  EXPECT_LE(reads.calls, size / (256 << 10) + 100) << path;
}

TEST(VdbReading, EachByteIsReadAboutOnceInFewCalls) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const openvdb::GridCPtrVec grids{
      ball<openvdb::FloatGrid>("density", 40), ball<openvdb::FloatGrid>("heat", 32, true),
      ball<openvdb::Vec3SGrid>("velocity", 28), ball<openvdb::FloatGrid>("fuel", 24)};
  const auto everything = [](const VolumeFile& file) {
    file.info();
    for (const std::string& name : file.names()) file.read(name);
    file.read("density", {GridRole::data});
  };
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(grids, codec);
    expect_read_once(path, reads_of(path, everything));
  }
  const auto piped = test::write_bytes("piped.vdb", piped_bytes(grids));
  expect_read_once(piped, reads_of(piped, everything));
}

TEST(VdbReading, WhatIsNotAskedForIsNotRead) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path =
      written({ball<openvdb::FloatGrid>("small", 20), ball<openvdb::FloatGrid>("large", 60)},
              openvdb::io::COMPRESS_ACTIVE_MASK);
  const std::int64_t size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  EXPECT_LT(reads_of(path, [](const VolumeFile& file) { file.names(); }).bytes, size / 10);
  EXPECT_LT(reads_of(path, [](const VolumeFile& file) { file.read("small"); }).bytes, size / 4);
  EXPECT_LT(reads_of(path, [](const VolumeFile& file) { file.info(/*values=*/false); }).bytes,
            size / 4);
}

TEST(VdbReading, TopologyAloneGivesAllButValues) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 20),
                             ball<openvdb::Vec3SGrid>("velocity", 20, /*half=*/true)},
                            openvdb::io::COMPRESS_ACTIVE_MASK);
  const VolumeFile file(path);
  const std::vector<GridInfo> all = file.info(), some = file.info(/*values=*/false);
  ASSERT_EQ(some.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_TRUE(all[n].values);
    EXPECT_FALSE(some[n].values);
    EXPECT_FALSE(some[n].values_read);
    EXPECT_EQ(some[n].problem, "");
    EXPECT_EQ(some[n].leaves, all[n].leaves);
    EXPECT_EQ(some[n].active_voxels, all[n].active_voxels);
    EXPECT_EQ(some[n].active_box, all[n].active_box);
    EXPECT_EQ(some[n].world_max, all[n].world_max);
    EXPECT_EQ(some[n].metadata, all[n].metadata);
  }
}

TEST(VdbReading, AFileThatShrinksMeanwhileIsAnError) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  const VolumeFile file(path);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_TRUE(has(input_error([&] { file.read("density"); }), "the file ends too early"));
}

TEST(VdbReading, ProgressGrowsToTheEndAndMayEndTheReading) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  std::vector<double> told;
  VolumeFile(path, [&](double fraction) { told.push_back(fraction); }).read("density");
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.size(), 3u);
  EXPECT_GT(told.back(), 0.5);
  EXPECT_LE(told.back(), 1.0);
  struct Ended {};
  const VolumeFile ended(path, [](double fraction) {
    if (fraction > 0.3) throw Ended();
  });
  EXPECT_THROW(ended.read("density"), Ended);
}

}  // namespace
}  // namespace psivox
