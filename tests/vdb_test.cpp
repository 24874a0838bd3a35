// VolumeFile on files from others, on assets and on broken files: every file of shared/data gives
// either the field that OpenVDB's own sampler sees or the error given here.

#include "psivox/vdb.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <random>

#include "scratch.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox {
namespace {

using test::assets_dir;
using test::data_dir;
using test::openvdb_grid;

#define SKIP_WITHOUT_DATA()                                                    \
  if (!std::filesystem::is_directory(data_dir())) {                            \
    GTEST_SKIP() << "no folder '" << data_dir().string() << "' (PSIVOX_DATA)"; \
  }

/// Compares field and grid at random points of the domain, on lattice points and half-way.
///
/// Tolerance: both interpolate floats; OpenVDB in float (7 lerps, each of relative error 2^-24 of
/// the largest corner), the test in double. 1e-6 of the largest corner leaves a factor of 2.
template <typename GridT>
void expect_same_values(const Field& field, const GridT& grid) {
  const FieldVoxels sampler(field);
  const Box domain = field.domain();
  std::mt19937 random(7);
  for (int n = 0; n < 3000; ++n) {
    glm::dvec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = std::uniform_real_distribution<double>(domain.min[axis], domain.max[axis])(random);
      if (n % 3 == 1) p[axis] = std::round(p[axis]);
      if (n % 3 == 2) p[axis] = std::round(p[axis] * 2.0) / 2.0;
    }
    const auto value =
        openvdb::tools::BoxSampler::sample(grid.tree(), openvdb::Vec3R(p.x, p.y, p.z));
    for (int c = 0; c < field.channels; ++c) {
      double expected;
      if constexpr (openvdb::VecTraits<typename GridT::ValueType>::IsVec) {
        expected = static_cast<double>(value[c]);
      } else {
        expected = static_cast<double>(value);
      }
      const double actual = sampler.trilinear(p, c);
      ASSERT_NEAR(actual, expected, 1e-6 * std::max(1.0, std::abs(expected) * 16.0))
          << field.name << " at " << p.x << ' ' << p.y << ' ' << p.z << " channel " << c;
    }
  }
}

/// A file that reads without a notice, and the contents of its directory and tree.
struct GoodGrid {
  const char* file;
  const char* grid;
  const char* value_type;
  int channels;
  std::uint64_t active_voxels;
  std::size_t leaves;
  std::size_t tiles;
};

void PrintTo(const GoodGrid& grid, std::ostream* os) { *os << grid.file << " " << grid.grid; }

class GoodGridTest : public testing::TestWithParam<GoodGrid> {};

TEST_P(GoodGridTest, HasTheValuesThatOpenVdbSamples) {
  SKIP_WITHOUT_DATA();
  const GoodGrid& expected = GetParam();
  const auto path = data_dir() / expected.file;
  // `data` keeps negative components, as OpenVDB does.
  const Field field = VolumeFile(path).read(expected.grid, {GridRole::data, /*strict=*/true});
  EXPECT_EQ(field.name, expected.grid);
  EXPECT_EQ(field.value_type, expected.value_type);
  EXPECT_EQ(field.channels, expected.channels);
  EXPECT_EQ(field.active_voxels, expected.active_voxels);
  EXPECT_EQ(field.leaves.size(), expected.leaves);
  EXPECT_EQ(field.tiles.size(), expected.tiles);
  EXPECT_TRUE(field.notices.empty());

  const auto grid = openvdb_grid(path, expected.grid);
  const auto box = grid->evalActiveVoxelBoundingBox();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(field.active_box.min[axis], box.min()[axis]);
    EXPECT_EQ(field.active_box.max[axis], box.max()[axis]);
  }
  const auto world = grid->indexToWorld(openvdb::Vec3d(3, -5, 7));
  const glm::dvec4 p = field.world_from_index * glm::dvec4(3, -5, 7, 1);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(p[axis], world[axis], 1e-12 * world.length());

  if (field.channels == 1) {
    expect_same_values(field, *openvdb::gridPtrCast<openvdb::FloatGrid>(grid));
  } else {
    expect_same_values(field, *openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid));
  }
}

INSTANTIATE_TEST_SUITE_P(
    SharedData, GoodGridTest,
    testing::Values(GoodGrid{"smoke.vdb", "density", "float", 1, 1049275, 3117, 0},
                    GoodGrid{"cloud_tiles.vdb", "density", "float", 1, 415642, 1241, 130},
                    GoodGrid{"heptane.vdb", "density", "float", 1, 6147151, 15098, 0},
                    GoodGrid{"mri_t1.vdb", "density", "float", 1, 1088315, 2786, 0},
                    GoodGrid{"neghip.vdb", "density", "float", 1, 88184, 385, 0},
                    GoodGrid{"frogtissue.vdb", "density", "float", 1, 1156957, 6597, 179},
                    GoodGrid{"carotid.vdb", "density", "float", 1, 136077, 415, 0},
                    GoodGrid{"carotid.vdb", "velocity", "vec3s", 3, 167561, 420, 0},
                    GoodGrid{"edge/smoke_format222.vdb", "density", "float", 1, 1049275, 3117, 0},
                    GoodGrid{"edge/cloud_voxelised.vdb", "density", "float", 1, 415642, 1371, 0},
                    GoodGrid{"edge/sphere.vdb", "density", "float", 1, 9047, 56, 0},
                    GoodGrid{"edge/three_same_names.vdb", "density[0]", "float", 1, 491, 8, 0},
                    GoodGrid{"edge/three_same_names.vdb", "density[1]", "float", 1, 2222, 28, 0},
                    GoodGrid{"edge/three_same_names.vdb", "density[2]", "float", 1, 803, 8, 0},
                    GoodGrid{"edge/torus_density100.vdb", "voxel_fog_density", "float", 1, 2450, 20,
                             0},
                    GoodGrid{"edge/velocity_tiles.vdb", "vel", "vec3s", 3, 1000000, 469, 1728}));

TEST(VdbData, LevelSetsBecomeOpenVdbsFogWithANotice) {
  SKIP_WITHOUT_DATA();
  for (const auto& [file, name] : {std::pair("edge/levelset_sphere.vdb", "ls_sphere"),
                                   std::pair("edge/levelset_unnamed.vdb", "[0]")}) {
    const VolumeFile vdb(data_dir() / file);
    EXPECT_EQ(vdb.default_grid(), name);
    EXPECT_EQ(vdb.info().at(0).problem, "");
    EXPECT_EQ(vdb.info().at(0).grid_class, "level set");
    const Field field = vdb.read(name, {GridRole::attenuation, /*strict=*/true});
    ASSERT_EQ(field.notices.size(), 1u);
    EXPECT_TRUE(has(field.notices[0], "level set converted to fog"));
    const auto fog =
        openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb_grid(data_dir() / file, name));
    openvdb::tools::sdfToFogVolume(*fog);
    expect_same_values(field, *fog);
  }
  // The empty name is the grid without a name.
  EXPECT_EQ(VolumeFile(data_dir() / "edge/levelset_unnamed.vdb").read("").name, "[0]");
}

TEST(VdbData, InfoCountsWhatTheTreeHolds) {
  SKIP_WITHOUT_DATA();
  const GridInfo smoke = VolumeFile(data_dir() / "smoke.vdb").info().at(0);
  EXPECT_EQ(smoke.name, "density");
  EXPECT_EQ(smoke.type, "Tree_float_5_4_3");
  EXPECT_EQ(smoke.grid_class, "fog volume");
  EXPECT_TRUE(smoke.saved_as_half);
  EXPECT_EQ(smoke.leaves, 3117u);
  EXPECT_EQ(smoke.active_box, (Box{{1, 2, 1}, {111, 223, 112}}));
  EXPECT_EQ(smoke.transform, "UniformScaleTranslateMap");
  EXPECT_NEAR(smoke.voxel_size.y, 0.476, 5e-4);
  EXPECT_EQ(VolumeFile(data_dir() / "cloud_tiles.vdb").info().at(0).active_tiles, 130u);
  EXPECT_NEAR(VolumeFile(data_dir() / "frogtissue.vdb").info().at(0).voxel_size.z, 1.5, 1e-12);
}

TEST(VdbData, GridsBeforeTheCutCanBeRead) {
  SKIP_WITHOUT_DATA();
  const std::string bytes = test::file_bytes(data_dir() / "edge/three_same_names.vdb");
  const VolumeFile vdb(test::write_bytes("cut.vdb", bytes.substr(0, 120000)));
  EXPECT_EQ(vdb.read("density[0]").active_voxels, 491u);
  EXPECT_TRUE(has(vdb.info().at(1).problem,
                  "is cut short: it needs 166005 bytes, the file has"
                  " 120000; 1 more behind it cannot be found"));
  EXPECT_TRUE(has(input_error([&] { vdb.read("density[1]"); }), "is cut short"));
  // what is not there may have been cut off
  EXPECT_TRUE(has(input_error([&] { vdb.check_whole(); }), "2 grids are not whole"));
  EXPECT_THROW(vdb.read("flame", {.empty = true}), Error);
  VolumeFile(data_dir() / "edge/three_same_names.vdb").check_whole();
}

TEST(VdbFileErrors, FilesThatAreNoneAreNamed) {
  const auto dir = test::scratch_dir();
  EXPECT_TRUE(
      has(input_error([&] { VolumeFile(dir / "absent.vdb"); }), "absent.vdb: no such file"));
  EXPECT_TRUE(has(input_error([&] { VolumeFile{dir}; }), "is a directory"));
  EXPECT_TRUE(has(input_error([&] { VolumeFile{"/dev/null"}; }), "is no regular file"));
  const auto text = test::write_bytes("text.vdb", "This is a text, not a volume.\n");
  EXPECT_TRUE(has(input_error([&] { VolumeFile{text}; }), "text.vdb: begins as no volume"));
  const auto nothing = test::write_bytes("nothing.vdb", "");
  EXPECT_TRUE(has(input_error([&] { VolumeFile{nothing}; }), "nothing.vdb: is empty"));
  const auto nano = test::write_bytes("nano.nvdb", "NanoVDB1 and what follows");
  EXPECT_TRUE(
      has(input_error([&] { VolumeFile{nano}; }), "nano.nvdb: is a damaged NanoVDB file: "));
  EXPECT_TRUE(has(input_error([&] { VolumeFile("/dev/null"); }), "/dev/null"));
}

TEST(VdbAssets, AreReadAsMade) {
  const Field slab = VolumeFile(assets_dir() / "slab.vdb").read("density");
  EXPECT_EQ(slab.active_box, (Box{{3, 5, 2}, {42, 28, 17}}));
  EXPECT_TRUE(slab.tiles.empty());
  const Field tiled = VolumeFile(assets_dir() / "slab.vdb").read("density_tiles");
  EXPECT_EQ(tiled.tiles.size(), 8u);
  EXPECT_EQ(tiled.active_voxels, slab.active_voxels);
  expect_same_values(tiled, *openvdb::gridPtrCast<openvdb::FloatGrid>(
                                openvdb_grid(assets_dir() / "slab.vdb", "density")));

  const Field ramp = VolumeFile(assets_dir() / "ramp.vdb").read("density");
  EXPECT_EQ(FieldVoxels(ramp).trilinear({10.5, 3, 4}, 0), 11.5 / 32.0);

  const Field single = VolumeFile(assets_dir() / "single_voxel.vdb").read("density");
  EXPECT_EQ(single.domain(), (Box{{-1, -1, -1}, {1, 1, 1}}));
  EXPECT_EQ(FieldVoxels(single).trilinear({-0.5, -0.5, 0.5}, 0), 0.125);

  const VolumeFile blobs(assets_dir() / "blobs.vdb");
  EXPECT_EQ(blobs.names(), (std::vector<std::string>{"density", "temperature", "color"}));
  EXPECT_EQ(blobs.default_grid(), "density");
  EXPECT_EQ(blobs.read("color").channels, 3);
  const Field density = blobs.read("density");
  const double fraction = static_cast<double>(density.active_voxels) / (64.0 * 64.0 * 64.0);
  EXPECT_GT(fraction, 0.2);
  EXPECT_LT(fraction, 0.4);

  // Two active tiles, and an inactive one that stores a value.
  const Field tiles = VolumeFile(assets_dir() / "tiles.vdb").read("density");
  ASSERT_EQ(tiles.tiles.size(), 3u);
  expect_same_values(tiles, *openvdb::gridPtrCast<openvdb::FloatGrid>(
                                openvdb_grid(assets_dir() / "tiles.vdb", "density")));

  EXPECT_EQ(VolumeFile(assets_dir() / "rotated.vdb").info().at(0).transform, "AffineMap");
}

TEST(UpAxis, IsKnownByTheCreatorAndTheGrids) {
  const auto grid = [](const std::string& name) { return test::voxel(name, 1); };
  const auto written = [&](const std::string& creator, const openvdb::GridCPtrVec& grids) {
    openvdb::initialize();
    const auto path = test::scratch_dir() / "made.vdb";
    openvdb::MetaMap metadata;
    if (!creator.empty()) metadata.insertMeta("creator", openvdb::StringMetadata(creator));
    openvdb::io::File(path.string()).write(grids, metadata);
    return VolumeFile(path).z_up();
  };
  EXPECT_EQ(written("", {grid("density")}), "");
  EXPECT_EQ(written("Houdini/SOP_OpenVDB_Write", {grid("density")}), "");
  EXPECT_EQ(written("Blender/OpenVDBWriter", {grid("density")}), "written by Blender");
  EXPECT_EQ(written("Blender/Smoke", {grid("density")}), "written by Blender");
  const auto smoke = grid("density");
  smoke->setCreator("Blender/Smoke");
  EXPECT_EQ(written("", {grid("heat"), smoke}), "written by Blender");
  EXPECT_EQ(written("Houdini/SOP_OpenVDB_Write", {smoke}), "");  // which has turned it
  EXPECT_EQ(written("", {grid("density"), grid("shadow")}), "a grid 'shadow', as Blender names it");
  EXPECT_EQ(written("", {grid("shadow")}), "");
  const auto cache = grid("density");
  cache->insertMeta("file_base_resolution", openvdb::Vec3IMetadata({16, 16, 16}));
  EXPECT_EQ(written("", {grid("heat"), cache}), "a cache of Blender's fluids");
}

}  // namespace
}  // namespace psivox
