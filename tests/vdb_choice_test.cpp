// Which grids of a file hold something, and which of them is drawn.

#include <limits>

#include "field/field_index.h"
#include "psivox/draw.h"
#include "psivox/field.h"
#include "psivox/medium.h"
#include "psivox/open.h"
#include "thrown.h"
#include "vdb/grid_names.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using namespace test;

FloatGrid::Ptr voxels(const std::string& name, float value, int count = 1) {
  const auto grid = named<FloatGrid>(name);
  for (int i = 0; i < count; ++i) grid->tree().setValue(Coord(8 * i, 0, 0), value);
  return grid;
}

TEST(VdbContent, AGridHoldsSomethingIfAnActiveValueIsNot0) {
  const auto late = voxels("late", 0, 100), tile = voxels("tile", 0), off = voxels("off", 0);
  late->tree().setValue(Coord(8 * 60, 0, 0), -0.5f);
  tile->tree().addTile(2, Coord(1024, 0, 0), 3.0f, true);
  off->tree().setValueOff(Coord(1, 0, 0), 7.0f);
  off->tree().addTile(1, Coord(64, 0, 0), 7.0f, false);
  const auto vectors = voxel<openvdb::Vec3SGrid>("vectors", openvdb::Vec3f(0, 0, 1));
  const VolumeFile file(write_vdb({late, tile, off, vectors, named<FloatGrid>("empty"),
                                   voxels("zeros", 0, 5000), voxels("again", 1), voxels("again", 0),
                                   voxels("nan", std::numeric_limits<float>::quiet_NaN())}));
  for (const char* name : {"late", "tile", "vectors", "again", "again[0]"})
    EXPECT_TRUE(file.holds_something(name)) << name;
  EXPECT_EQ(file.content("late").active_voxels, 100u);
  EXPECT_EQ(file.content("tile").active_voxels, 1u + 128 * 128 * 128);
  for (const char* name : {"off", "zeros", "again[1]", "nan"})
    EXPECT_EQ(file.content(name).nothing, "is 0 everywhere") << name;
  EXPECT_EQ(file.content("zeros").active_voxels, 5000u);
  EXPECT_EQ(file.content("empty").nothing, "has no active voxel");
  EXPECT_FALSE(file.holds_something("no such grid"));
}

TEST(VdbContent, AFirstValueIsEnough) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path = written({ball<FloatGrid>("density", 60)}, openvdb::io::COMPRESS_ACTIVE_MASK);
  const Reads reads = reads_of(path, [](const VolumeFile& file) {
    EXPECT_TRUE(file.holds_something("density"));
    EXPECT_TRUE(file.holds_something("density"));
  });
  EXPECT_LT(reads.bytes, std::int64_t(std::filesystem::file_size(path)) / 4);
}

TEST(VdbContent, IsKnownOfGridsInMemory) {
  const auto file_of = [](float value) {
    DenseField dense("a", {8, 8, 8}, 1, glm::dmat4(1));
    dense.add(std::vector<float>(512, value));
    return std::make_shared<VolumeFile>(std::make_shared<const Field>(dense.finish()));
  };
  const VolumeFile both({{"some", file_of(2), "a"}, {"none", file_of(0), "a"}});
  EXPECT_TRUE(both.holds_something("some"));
  EXPECT_EQ(both.content("some").active_voxels, 512u);
  EXPECT_EQ(both.content("none").nothing, "has no active voxel");
}

/// The grid that is drawn of these.
std::string chosen(const openvdb::GridCPtrVec& grids) {
  return VolumeFile(write_vdb(grids)).default_grid();
}

openvdb::Vec3SGrid::Ptr vectors(const std::string& name) {
  return voxel<openvdb::Vec3SGrid>(name, openvdb::Vec3f(1));
}

TEST(VdbChoice, KnownNamesComeFirstThenClassesThenTheMostVoxels) {
  const auto few = [](const std::string& name) { return voxels(name, 1); };
  const auto many = [](const std::string& name) { return voxels(name, 1, 9); };
  EXPECT_EQ(chosen({many("heat"), many("SMOKE"), few("Density")}), "Density");
  EXPECT_EQ(chosen({many("flame"), few("smoke"), many("temperature")}), "smoke");
  EXPECT_EQ(chosen({many("other"), many("flame"), few("temperature")}), "temperature");
  const auto fog = openvdb::GRID_FOG_VOLUME, level_set = openvdb::GRID_LEVEL_SET;
  EXPECT_EQ(chosen({many("a"), of_class(many("b"), level_set), of_class(few("c"), fog),
                    of_class(many("d"), fog)}),
            "d");
  EXPECT_EQ(chosen({many("a"), of_class(few("b"), level_set), vectors("v")}), "b");
  EXPECT_EQ(chosen({vectors("v"), few("a"), many("b")}), "b");
  EXPECT_EQ(chosen({vectors("v"), vectors("w")}), "v");
}

TEST(VdbChoice, NamesMayHaveAnyCaseAndOtherWordsBefore) {
  const auto many = [](const std::string& name) { return voxels(name, 1, 9); };
  const auto few = [](const std::string& name) { return voxels(name, 1); };
  for (const char* name : {"voxel_fogDensity", "fluid_density", "SmokeDensity", "smoke density",
                           "DENSITY_2", "Clouds"})
    EXPECT_EQ(chosen({many("other"), many("Temperature"), few(name)}), name);
  EXPECT_EQ(chosen({many("fuel_density"), few("density")}), "density") << "a whole name";
  EXPECT_EQ(chosen({many("densitometry"), few("b_heat")}), "b_heat");
  const VolumeFile file(write_vdb({many("Flames"), many("voxel_temperature"), vectors("CD")}));
  EXPECT_EQ(grid_saying(file, "flame", 1), "Flames");
  EXPECT_EQ(grid_saying(file, "temperature", 1), "voxel_temperature");
  EXPECT_EQ(grid_saying(file, "cd", 3), "CD");
  EXPECT_EQ(grid_saying(file, "cd", 1), "");
}

TEST(VdbChoice, ThreeComponentsAreOneVector) {
  std::vector<FloatGrid::Ptr> parts;
  for (int c = 0; c < 3; ++c) {
    parts.push_back(named<FloatGrid>(std::string("vel.") + "xyz"[c]));
    parts.back()->tree().setValue(Coord(c, 0, 0), float(c + 1));
    parts.back()->tree().setValue(Coord(20, 0, 0), float(-c));
  }
  const auto path = write_vdb({parts[0], parts[1], parts[2]});
  const VolumeFile file(path);
  EXPECT_EQ(file.names(), std::vector<std::string>{"vel"});
  EXPECT_EQ(file.default_grid(), "vel");
  EXPECT_EQ(file.channels("vel"), 3);
  const Field field = file.read("vel", {.role = GridRole::data});
  const FieldIndex index(field);
  EXPECT_EQ(index.at(glm::ivec3(1, 0, 0)), glm::dvec3(0, 2, 0));
  EXPECT_EQ(index.at(glm::ivec3(20, 0, 0)), glm::dvec3(0, -1, -2));
  EXPECT_EQ(field.active_box.max, glm::ivec3(20, 0, 0));
  EXPECT_EQ(file.read("vel.y", {.role = GridRole::data}).channels, 1) << "named, it is a scalar";
  const View view = make_view(with_look({}, file, "auto").scene, file);
  EXPECT_EQ(view.scene.grid, "vel:length");

  parts[2]->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  EXPECT_TRUE(has(input_error([&] {
                    VolumeFile(write_vdb({parts[0], parts[1], parts[2]})).read("vel");
                  }),
                  "different lattices"));
  const auto own = named<FloatGrid>("vel");
  EXPECT_EQ(VolumeFile(write_vdb({parts[0], parts[1], parts[2], own})).names().size(), 4u);
}

TEST(VdbChoice, GridsOfASolverAreNotDrawnBesideADensity) {
  const auto many = [](const std::string& name) { return voxels(name, 1, 9); };
  for (const char* name : {"shadow", "uv_grid_0", "uv_gridU", "phi_out", "phi", "Pressure"}) {
    EXPECT_EQ(chosen({many(name), voxels("density", 0)}), "density") << name;
    EXPECT_EQ(chosen({many(name), voxels("other", 1)}), "other") << name;
    EXPECT_EQ(chosen({many(name)}), name) << "there is no other";
  }
  // Blender's file before the first smoke
  auto density = named<FloatGrid>("density");
  density->insertMeta("file_base_resolution", openvdb::Vec3IMetadata({64, 64, 64}));
  const std::string path = write_vdb({density, vectors("velocity"), many("shadow")});
  EXPECT_EQ(VolumeFile(path).default_grid(), "density");
  const OpenedScene opened = open_scene({}, VolumeFile(path));
  EXPECT_EQ(opened.view.medium.density->active_voxels, 0u);
  const Image image = Session(opened.view).draw(*open_double()).image;
  EXPECT_EQ(blank_reason(opened.view, image),
            "the picture is empty: grid 'density' has no active voxel");
}

TEST(VdbChoice, AGridThatHoldsNothingDoesNotCount) {
  EXPECT_EQ(chosen({voxels("density", 0), voxels("heat", 0, 5), vectors("v")}), "v");
  EXPECT_EQ(chosen({voxels("a", 1), voxels("density", 0), named<FloatGrid>("flame")}), "a");
  EXPECT_EQ(chosen({named<FloatGrid>("density")}), "density");  // reading it says what is wrong
  const VolumeFile nothing(write_vdb({voxels("density", 0), named<FloatGrid>("flame")}));
  EXPECT_TRUE(has(input_error([&] { nothing.default_grid(); }),
                  "has nothing to draw: grid 'density' is 0 everywhere; grid 'flame' has no"
                  " active voxel"));
  EXPECT_EQ(nothing.default_grid(/*empty=*/true), "density");
}

TEST(VdbChoice, IsSaidWhereItWasNotObvious) {
  using Notices = std::vector<std::string>;
  const auto notices = [](const openvdb::GridCPtrVec& grids, const std::string& grid) {
    Scene scene;
    scene.grid = grid;
    return read_fields(scene, VolumeFile(write_vdb(grids))).density->notices;
  };
  const openvdb::GridCPtrVec three{voxels("b", 1), voxels("heat", 1), voxels("c", 1)};
  EXPECT_EQ(notices(three, ""), Notices{"grid 'heat' of 3; --grid NAME chooses another"});
  EXPECT_EQ(notices(three, "heat"), Notices{});
  EXPECT_EQ(notices({voxels("density", 1), voxels("b", 1)}, ""), Notices{});
  EXPECT_EQ(notices({voxels("b", 1)}, ""), Notices{});
}

TEST(VdbChoice, ARepeatedNameIsItsFirstGridThatHoldsSomething) {
  EXPECT_EQ(chosen({voxels("density", 1), voxels("density", 1, 9)}), "density");
  EXPECT_EQ(chosen({voxels("density", 0), voxels("density", 1)}), "density[1]");
}

}  // namespace
}  // namespace psivox
