// Values that stay in the file: they equal the values of a field that is read whole; a part or a
// rank reads its own alone.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

#include "field/leaf_values.h"
#include "field/value_range.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "psivox/vdb.h"
#include "thread_team.h"
#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;

/// A grid's values stay in the file: its field has all that the whole one has, and the same values.
void expect_stored_like_whole(const std::filesystem::path& path, const std::string& name,
                              ReadOptions options) {
  SCOPED_TRACE(name);
  const auto file = std::make_unique<VolumeFile>(path);
  options.percentiles = {1, 50};
  const Field whole = file->read(name, options);
  options.memory = 1;
  const Field stored = file->read(name, options);
  ASSERT_TRUE(stored.reader);
  EXPECT_FALSE(whole.reader);
  EXPECT_EQ(stored.name, whole.name);
  EXPECT_EQ(stored.value_type, whole.value_type);
  EXPECT_EQ(stored.active_box, whole.active_box);
  EXPECT_EQ(stored.active_voxels, whole.active_voxels);
  EXPECT_EQ(stored.world_from_index, whole.world_from_index);
  EXPECT_EQ(stored.notices, whole.notices);
  EXPECT_EQ(stored.active_percentiles, whole.active_percentiles);
  EXPECT_EQ(stored.replaced.negative, whole.replaced.negative);
  EXPECT_EQ(stored.replaced.least, whole.replaced.least);
  EXPECT_EQ(stored.stored_range, whole.stored_range);
  EXPECT_EQ(active_range(stored), active_range(whole));
  EXPECT_EQ(stored.active_range, whole.active_range);
  ASSERT_EQ(stored.tiles.size(), whole.tiles.size());
  for (std::size_t n = 0; n < whole.tiles.size(); ++n) {
    EXPECT_EQ(stored.tiles[n].origin, whole.tiles[n].origin);
    EXPECT_EQ(stored.tiles[n].value, whole.tiles[n].value);
  }
  ASSERT_EQ(stored.leaves.size(), whole.leaves.size());
  std::size_t seen = 0;
  const auto length = 512 * std::size_t(whole.channels);
  visit_leaves(stored, [&](std::span<const Leaf> leaves) {
    for (const Leaf& leaf : leaves) {
      ASSERT_EQ(leaf.origin, whole.leaves[seen].origin);
      ASSERT_EQ(std::memcmp(leaf.values, whole.leaves[seen].values, length * sizeof(float)), 0);
      ++seen;
    }
  });
  EXPECT_EQ(seen, whole.leaves.size());
}

TEST(VdbStoredValues, ValuesThatStayInTheFileAreThoseOfTheWhole) {
  const auto tiles = ball<openvdb::FloatGrid>("tiles", 20);
  auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(tiles)->tree();
  tree.addTile(1, Coord(-64, 8, 16), 7.0f, true);
  tree.addTile(2, Coord(-256, 0, 0), 3.0f, false);
  tree.addTile(3, Coord(8192, 0, -4096), 5.0f, true);
  const openvdb::GridCPtrVec grids{ball<openvdb::FloatGrid>("float", 40),
                                   ball<openvdb::FloatGrid>("half", 20, /*half=*/true),
                                   ball<openvdb::DoubleGrid>("double", 20),
                                   ball<openvdb::Int64Grid>("int64", 20),
                                   ball<openvdb::BoolGrid>("bool", 20),
                                   ball<openvdb::Vec3SGrid>("vec3s", 20),
                                   ball<openvdb::Vec3DGrid>("vec3d", 20, /*half=*/true),
                                   tiles};
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(grids, codec);
    for (const char* name :
         {"float", "half", "double", "int64", "bool", "vec3s", "vec3d", "tiles"}) {
      expect_stored_like_whole(path, name, {GridRole::attenuation});
      expect_stored_like_whole(path, name, {GridRole::data});
    }
  }
}

TEST(VdbStoredValues, BadValuesThatStayInTheFileAreReplacedAsInTheWhole) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const auto grid = ball<openvdb::FloatGrid>("density", 20);
  auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree();
  tree.setValue(Coord(1, 2, 3), infinite);
  tree.setValue(Coord(9, 2, 3), -infinite);
  tree.setValue(Coord(1, -2, 3), std::numeric_limits<float>::quiet_NaN());
  tree.setValue(Coord(-1, -2, 3), -4.0f);
  tree.addTile(1, Coord(-64, 8, 16), infinite, true);
  tree.addTile(1, Coord(-72, 8, 16), -1.0f, true);
  tree.addTile(1, Coord(-80, 8, 16), 900.0f, true);
  const auto path = written({grid}, openvdb::io::COMPRESS_ACTIVE_MASK);
  for (const GridRole role : {GridRole::attenuation, GridRole::data}) {
    expect_stored_like_whole(path, "density", {role});
    const ReadOptions strict{.role = role, .strict = true, .memory = 1};
    EXPECT_TRUE(
        has(input_error([&] { VolumeFile(path).read("density", strict); }), "refused by strict"));
  }
}

// It becomes the greatest of all values, here that of an inactive tile.
TEST(VdbStoredValues, AnActiveTileOfInfinityIsInTheActiveRange) {
  const auto grid = ball<openvdb::FloatGrid>("density", 20);
  auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree();
  tree.addTile(1, Coord(-64, 8, 16), std::numeric_limits<float>::infinity(), true);
  tree.addTile(1, Coord(-72, 8, 16), 900.0f, false);
  const auto path = written({grid}, openvdb::io::COMPRESS_ACTIVE_MASK);
  for (const std::uint64_t memory : {0, 1}) {
    const Field read = VolumeFile(path).read("density", {.role = GridRole::data, .memory = memory});
    EXPECT_EQ(read.active_range->y, 900);
  }
}

TEST(VdbStoredValues, APartReadsItsLeavesAlone) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  const Field whole = VolumeFile(path).read("density");
  const Field stored = VolumeFile(path).read("density", {.memory = 1});
  const Box box{glm::ivec3(-20, 3, 10), glm::ivec3(15, 16, 31)};
  part_of_field(stored, Box{glm::ivec3(0), glm::ivec3(0)});  // finds where all leaves are
  const Reads before = reads_of_process();
  const Field part = part_of_field(stored, box);
  const Reads after = reads_of_process();
  EXPECT_FALSE(part.reader);
  // from leaves -24..8, 0..16 and 8..24, which are 2113 bytes each, and gaps of one leaf at most
  EXPECT_EQ(part.leaves.size(), 5u * 3 * 3);
  EXPECT_LT(after.bytes - before.bytes, 45 * 2 * 2113);
  const FieldVoxels sampler(whole);
  for (const Leaf& leaf : part.leaves)
    EXPECT_EQ(double(leaf.values[74]), sampler.voxel(leaf.origin + glm::ivec3(1, 1, 2), 0));
  const Field same = part_of_field(whole, box);
  ASSERT_EQ(same.leaves.size(), part.leaves.size());
  std::filesystem::resize_file(path, 1000);
  EXPECT_TRUE(has(input_error([&] {
                    part_of_field(stored, Box{glm::ivec3(-60), glm::ivec3(60)});
                  }),
                  "cannot be read"));
}

/// What four ranks read of a file together, to know ranges, extinction and camera: the first reads
/// each value twice, and each rank the topology.
TEST(VdbStoredValues, OneRankLooksAtAllValuesForTheOthers) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  using namespace openvdb::io;
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)},
                            Archive::hasBloscCompression() ? COMPRESS_BLOSC : COMPRESS_ZIP);
  Scene scene;
  scene.input = path.string();
  const View alone = make_view(scene, VolumeFile(path));
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  const Reads before = reads_of_process();
  const auto errors = test::in_team(4, [&](const std::shared_ptr<Team>& team) {
    const View view = make_view(
        scene, read_fields(scene, VolumeFile(path), false, {.allowed = true, .team = team}));
    EXPECT_EQ(stored_range(*view.medium.density), stored_range(*alone.medium.density));
    EXPECT_EQ(view.camera.position, alone.camera.position);
    EXPECT_EQ(view.medium.extinction, alone.medium.extinction);
  });
  EXPECT_EQ(errors, std::vector<std::string>(4, ""));
  const auto reads = static_cast<double>(reads_of_process().bytes - before.bytes);
  // of about 1000 bytes that a leaf has, each rank reads 64 of topology and a few of its length
  EXPECT_LT(reads, (2 + 5 * 0.1) * size);
}

// What a view shows of values that stay in the file is what it shows of the whole: the same blocks,
// of voxels of any kind.
TEST(VdbStoredValues, AViewOfThemIsThatOfTheWhole) {
  const auto grid = ball<openvdb::FloatGrid>("density", 60);
  auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree();
  tree.setValue(Coord(1, 2, 3), 1e-7f);
  tree.setValue(Coord(-70, 2, 3), 1e-7f);  // alone in its leaf
  tree.setValue(Coord(-1, -2, 3), -4.0f);
  tree.setValue(Coord(33, 2, 3), std::numeric_limits<float>::infinity());
  tree.addTile(1, Coord(-64, 8, 80), 0.5f, true);
  const auto path = written({grid}, openvdb::io::COMPRESS_NONE);
  Scene scene;
  scene.input = path.string();
  const auto expect_same = [&] {
    const View whole = make_view(scene, VolumeFile(path));
    Scene small = scene;
    small.memory_limit = 64;
    const MediumFields fields = read_fields(small, VolumeFile(path), false, {.allowed = true});
    ASSERT_TRUE(fields.density->reader);
    const View stored = make_view(small, fields);
    EXPECT_EQ(stored.medium.extinction, whole.medium.extinction);
    ASSERT_EQ(stored.subject->grids.size(), 1u);
    const auto &is = stored.subject->grids[0].blocks, &was = whole.subject->grids[0].blocks;
    ASSERT_EQ(is.size(), was.size());
    for (std::size_t n = 0; n < was.size(); ++n) {
      EXPECT_EQ(is[n].min, was[n].min);
      EXPECT_EQ(is[n].max, was[n].max);
      EXPECT_EQ(is[n].amount, was[n].amount);
    }
  };
  expect_same();
  scene.colormap = Colormap::viridis;
  expect_same();
  set_parameter(scene, "range", "5%,90%");
  expect_same();
  set_parameter(scene, "value-scale", "log");
  expect_same();
}

TEST(VdbStoredValues, ABackgroundThatStaysInTheFileIsVacuumAsInTheWhole) {
  const auto grid = ball<openvdb::FloatGrid>("density", 20);
  const auto vectors = ball<openvdb::Vec3SGrid>("vectors", 20);
  openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree().root().setBackground(7, true);
  openvdb::gridPtrCast<openvdb::Vec3SGrid>(vectors)->tree().root().setBackground(openvdb::Vec3f(7),
                                                                                 true);
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written({grid, vectors}, codec);
    for (const char* name : {"density", "vectors"})
      expect_stored_like_whole(path, name, {GridRole::data});
  }
}

TEST(VdbStoredValues, AGridThatMustBeConvertedWholeIsRefusedBeyondItsMemory) {
  const auto grid = ball<openvdb::FloatGrid>("distance", 40);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree().root().setBackground(3.0f, true);
  const auto path = written({grid}, openvdb::io::COMPRESS_NONE);
  const auto expect_refused = [](const std::filesystem::path& file, const char* name,
                                 const ReadOptions& options, const char* why) {
    try {
      VolumeFile(file).read(name, options);
      ADD_FAILURE() << "no error";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::memory);
      EXPECT_TRUE(has(e.what(), why));
    }
  };
  expect_refused(path, "distance", {.memory = 1000}, "a level set is converted whole");
  expect_refused(path, "distance", {.active = true, .memory = 1000}, "active voxels are marked");
  const auto filled = ball<openvdb::FloatGrid>("filled", 40);
  openvdb::gridPtrCast<openvdb::FloatGrid>(filled)->tree().root().setBackground(3.0f, true);
  expect_refused(written({filled}, openvdb::io::COMPRESS_NONE, "filled.vdb"), "filled",
                 {.background = 2, .memory = 1000}, "a background is replaced");
}

}  // namespace
}  // namespace psivox
