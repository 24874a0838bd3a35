// How VdbFile reads: each byte about once, in few calls, and the same values as OpenVDB's own
// reader with every codec.

#include <openvdb/io/Compression.h>
#include <openvdb/io/Stream.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>

#include "field/leaf_values.h"
#include "field/value_range.h"
#include "psivox/medium.h"
#include "psivox/vdb.h"
#include "scratch.h"
#include "thread_team.h"
#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;

/// All values of all leaves are those of OpenVDB's reader. Both convert by static_cast<float>.
template <typename GridT>
void expect_values_of_openvdb(const std::filesystem::path& path, const std::string& name) {
  const Field field = VdbFile(path).read(name, {GridRole::data});
  const auto grid = openvdb::gridPtrCast<GridT>(test::openvdb_grid(path, name));
  ASSERT_EQ(field.leaves.size(), grid->tree().leafCount());
  for (const Leaf& leaf : field.leaves) {
    const Coord origin(leaf.origin.x, leaf.origin.y, leaf.origin.z);
    const auto* expected = grid->tree().probeConstLeaf(origin);
    ASSERT_NE(expected, nullptr);
    for (openvdb::Index n = 0; n < expected->SIZE; ++n) {
      const auto value = expected->getValue(n);
      if constexpr (openvdb::VecTraits<typename GridT::ValueType>::IsVec) {
        for (openvdb::Index c = 0; c < 3; ++c)
          ASSERT_EQ(leaf.values[n * 3 + c], static_cast<float>(value[static_cast<int>(c)]));
      } else {
        ASSERT_EQ(leaf.values[n], static_cast<float>(value)) << name << " at " << origin;
      }
    }
  }
}

TEST(VdbReading, EveryCodecAndTypeGivesTheValuesOfOpenVdb) {
  const openvdb::GridCPtrVec grids{
      ball<openvdb::FloatGrid>("float", 40),   ball<openvdb::FloatGrid>("half", 20, /*half=*/true),
      ball<openvdb::DoubleGrid>("double", 20), ball<openvdb::Int32Grid>("int32", 20),
      ball<openvdb::Int64Grid>("int64", 20),   ball<openvdb::BoolGrid>("bool", 20),
      ball<openvdb::Vec3SGrid>("vec3s", 20),   ball<openvdb::Vec3DGrid>("vec3d", 20, /*half=*/true),
      ball<openvdb::Vec3IGrid>("vec3i", 20)};
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
      ball<openvdb::FloatGrid>("density", 50), ball<openvdb::FloatGrid>("heat", 40, true),
      ball<openvdb::Vec3SGrid>("velocity", 40), ball<openvdb::FloatGrid>("fuel", 30)};
  const auto everything = [](const VdbFile& file) {
    file.info();
    for (const std::string& name : file.names()) file.read(name);
    file.read("density", {GridRole::data});
  };
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(grids, codec);
    expect_read_once(path, reads_of(path, everything));
  }
  const auto piped = test::scratch_dir() / "piped.vdb";
  {
    std::ofstream out(piped, std::ios::binary);
    openvdb::io::Stream(out).write(grids);
  }
  expect_read_once(piped, reads_of(piped, everything));
}

TEST(VdbReading, WhatIsNotAskedForIsNotRead) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path =
      written({ball<openvdb::FloatGrid>("small", 20), ball<openvdb::FloatGrid>("large", 60)},
              openvdb::io::COMPRESS_ACTIVE_MASK);
  const std::int64_t size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.names(); }).bytes, size / 10);
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.read("small"); }).bytes, size / 4);
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.info(/*values=*/false); }).bytes,
            size / 4);
}

TEST(VdbReading, TopologyAloneGivesAllButValues) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 20),
                             ball<openvdb::Vec3SGrid>("velocity", 20, /*half=*/true)},
                            openvdb::io::COMPRESS_ACTIVE_MASK);
  const VdbFile file(path);
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
  const VdbFile file(path);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_TRUE(has(input_error([&] { file.read("density"); }), "the file ends too early"));
}

TEST(VdbReading, ProgressGrowsToTheEndAndMayEndTheReading) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  std::vector<double> told;
  VdbFile(path, [&](double fraction) { told.push_back(fraction); }).read("density");
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.size(), 3u);
  EXPECT_GT(told.back(), 0.5);
  EXPECT_LE(told.back(), 1.0);
  struct Ended {};
  const VdbFile ended(path, [](double fraction) {
    if (fraction > 0.3) throw Ended();
  });
  EXPECT_THROW(ended.read("density"), Ended);
}

}  // namespace
}  // namespace psivox
