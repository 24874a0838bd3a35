// VolumeFile on files made here: names of grids, parts of vectors, and grids that cannot be
// rendered.

#include <openvdb/tools/Interpolation.h>

#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "psivox/vdb.h"
#include "scene/transfer_function.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox {
namespace {

using namespace test;

TEST(VdbNames, GridsAreListedInFileOrderAndFoundByName) {
  const VolumeFile vdb(
      write_vdb({voxel("z", 1), voxel("", 2), voxel("a", 3), voxel("", 4), voxel("a", 5)}));
  EXPECT_EQ(vdb.names(), (std::vector<std::string>{"z", "[0]", "a[0]", "[1]", "a[1]"}));
  const auto value = [&](const std::string& name) {
    return FieldVoxels(vdb.read(name)).voxel({0, 0, 0}, 0);
  };
  EXPECT_EQ(value("z"), 1);
  EXPECT_EQ(value("[0]"), 2);
  EXPECT_EQ(value(""), 2);
  EXPECT_EQ(value("[1]"), 4);
  EXPECT_EQ(value("a[1]"), 5);
  EXPECT_EQ(value("a"), 3);
  EXPECT_TRUE(
      has(input_error([&] { vdb.read("b"); }), "has no grid 'b'; it has 'z' '[0]' '[1]' 'a[0]'"));
  EXPECT_EQ(vdb.default_grid(), "z");
  EXPECT_TRUE(has(input_error([&] { VolumeFile(write_vdb({})).default_grid(); }), "holds no grid"));
}

TEST(VdbNames, ControlCharactersAreEscaped) {
  std::string bytes = test::file_bytes(write_vdb({voxel("densitx", 2)}));
  const std::string odd("de\x1b[2\0y", 7);
  for (std::size_t at; (at = bytes.find("densitx")) != std::string::npos;)
    bytes.replace(at, odd.size(), odd);
  const VolumeFile vdb(test::write_bytes("odd_name.vdb", bytes));
  const std::string name = "de\\x1b[2\\x00y";
  EXPECT_EQ(vdb.names(), std::vector{name});
  EXPECT_EQ(vdb.info().front().name, name);
  EXPECT_EQ(vdb.info().front().problem, "");
  EXPECT_EQ(FieldVoxels(vdb.read(name)).voxel({0, 0, 0}, 0), 2.0);
}

TEST(VdbNames, NamesThatAnotherWriterRepeatedAreNumbered) {
  std::string bytes = test::file_bytes(write_vdb({voxel("density", 1), voxel("densitx", 2)}));
  for (std::size_t at; (at = bytes.find("densitx")) != std::string::npos;) bytes[at + 6] = 'y';
  const VolumeFile vdb(test::write_bytes("repeated.vdb", bytes));
  EXPECT_EQ(vdb.names(), (std::vector<std::string>{"density[0]", "density[1]"}));
  EXPECT_EQ(FieldVoxels(vdb.read("density[1]")).voxel({0, 0, 0}, 0), 2.0);
  EXPECT_EQ(vdb.read("density").notices,
            std::vector<std::string>{"grid 'density': 2 grids have this name; took 'density[0]'"});
}

TEST(VdbFiles, AGridOfAnUnknownTypeLeavesTheOthers) {
  const openvdb::GridCPtrVec grids{voxel("density", 1), voxel("other", 2)};
  std::string bytes = test::file_bytes(write_vdb(grids));
  bytes.replace(bytes.find("Tree_float"), 10, "Tree_quark");
  const VolumeFile vdb(test::write_bytes("unknown.vdb", bytes));
  EXPECT_EQ(vdb.names(), (std::vector<std::string>{"density", "other"}));
  EXPECT_EQ(vdb.info().at(0).channels, 0);
  EXPECT_TRUE(has(vdb.info().at(0).problem, "has type Tree_quark_5_4_3"));
  EXPECT_EQ(FieldVoxels(vdb.read("other")).voxel({0, 0, 0}, 0), 2.0);
  EXPECT_TRUE(
      has(input_error([&] { vdb.read("density"); }), "supported value types: float, double"));

  // without positions, only those before it
  bytes = piped_bytes(grids);
  bytes.replace(bytes.find("Tree_float"), 10, "Tree_quark");
  const std::vector<GridInfo> rows = VolumeFile(test::write_bytes("piped.vdb", bytes)).info();
  ASSERT_EQ(rows.size(), 1u);
  for (const char* text : {"has type Tree_quark_5_4_3", "; 1 more behind it cannot be found"})
    EXPECT_TRUE(has(rows[0].problem, text));
}

TEST(VdbFiles, AnUnknownTransformIsNamedAndIsNoCut) {
  const auto grid = voxel("density", 1);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  const std::string piped = piped_bytes({grid});
  for (std::string bytes : {piped, test::file_bytes(write_vdb({grid}))}) {
    const std::size_t at = bytes.find("UniformScaleMap");
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 15, "QuarkyScaleMaps");
    const VolumeFile file(test::write_bytes("quarky.vdb", bytes));
    file.check_whole();
    EXPECT_TRUE(has(input_error([&] { file.read(file.default_grid()); }), "QuarkyScaleMaps"));
  }
  // what is cut short has nothing that a look could draw
  const std::string cut = piped.substr(0, piped.size() - 100);
  const std::string message =
      input_error([&] { VolumeFile(test::write_bytes("cut.vdb", cut)).check_whole(); });
  EXPECT_TRUE(has(message, "is cut short"));
  EXPECT_EQ(message.find("--look"), std::string::npos);
}

TEST(VdbFiles, GridsThatShareATreeAndFilesWithoutPositions) {
  const auto a = voxel("a", -4, Coord(1, 2, 3));
  const openvdb::GridBase::Ptr b = a->copyGrid();  // the same tree
  b->setName("b");
  const auto shared = write_vdb({a, b});
  EXPECT_EQ(FieldVoxels(VolumeFile(shared).read("b", {GridRole::data})).voxel({1, 2, 3}, 0), -4.0);

  const VolumeFile vdb(test::write_bytes("piped.vdb", piped_bytes({a, b})));
  EXPECT_EQ(vdb.names(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(vdb.read("b").notices.at(0), "grid 'b': 1 negative value taken as 0");
  EXPECT_EQ(FieldVoxels(vdb.read("b", {GridRole::data})).voxel({1, 2, 3}, 0), -4.0);
}

TEST(VdbFiles, WhatCannotBeRenderedIsRefused) {
  const auto far = voxel("far", 1), huge = voxel("huge", 1),
             hollow = of_class(voxel("hollow", 0.1f), openvdb::GRID_LEVEL_SET);
  far->tree().setValue(Coord(1 << 30, 0, 0), 1.0f);
  hollow->tree().root().setBackground(0.3f, /*updateChildNodes=*/false);
  huge->setTransform(openvdb::math::Transform::createLinearTransform(1e80));
  const VolumeFile vdb(write_vdb({far, hollow, huge}));
  EXPECT_TRUE(has(input_error([&] { vdb.read("huge"); }), "beyond 1e75"));
  EXPECT_TRUE(has(input_error([&] { vdb.read("far"); }), "2^30 or more apart"));
  EXPECT_TRUE(has(input_error([&] { vdb.read("hollow"); }), "level set without an inside"));
}

TEST(Vectors, AreDrawnByLengthOrComponent) {
  const auto velocity =
      voxel<openvdb::Vec3SGrid>("velocity", openvdb::Vec3s(2, -3, 6), Coord(1, 2, 3));
  velocity->tree().setValue(Coord(1, 2, 4), openvdb::Vec3s(0, 1, 0));
  const VolumeFile vdb(write_vdb({voxel("a", 1), voxel("b", 2), velocity}));
  const auto at = [&](const std::string& name) {
    Scene scene;
    scene.grid = name;
    const View view = make_view(scene, vdb);
    EXPECT_EQ(view.scene.grid, name.find(':') == name.npos ? name + ":length" : name);
    EXPECT_NE(view.medium.transfer, nullptr);
    return view;
  };
  const auto value = [](const View& view) {
    return FieldVoxels(*view.medium.density).voxel({1, 2, 3}, 0);
  };
  EXPECT_EQ(value(at("velocity")), 7);
  EXPECT_EQ(value(at("velocity:length")), 7);
  EXPECT_EQ(value(at("velocity:x")), 2);
  EXPECT_EQ(value(at("velocity:z")), 6);
  const View y = at("velocity:y");
  EXPECT_EQ(value(y), -3);
  EXPECT_EQ(y.scene.colormap, Colormap::coolwarm);
  EXPECT_EQ(y.scene.range, glm::dvec2(-3, 3));
  EXPECT_EQ(y.medium.transfer->at(-3).attenuation, 3);
  EXPECT_EQ(y.medium.transfer->at(1).attenuation, 1);
  // the printed scene draws the same
  EXPECT_EQ(to_json(make_view(y.scene, vdb).scene), to_json(y.scene));

  const auto refused = [&](const std::string& name) {
    Scene scene;
    scene.grid = name;
    return input_error([&] { make_view(scene, vdb); });
  };
  EXPECT_TRUE(has(refused("velocity:w"), "a vector has x, y, z, length and active"));
  EXPECT_TRUE(has(refused("a:x"), "is scalar"));
  EXPECT_TRUE(has(refused("c:x"), "has no grid 'c:x'"));
  // percentiles are of what is read
  constexpr double median[] = {50};
  for (const auto& [name, count] : {std::pair("a", 1u), {"velocity:length", 0u}}) {
    Scene scene;
    scene.grid = name;
    scene.colormap = Colormap::viridis;
    const MediumFields fields = read_fields(scene, vdb, false, {}, {.percentiles = median});
    EXPECT_EQ(fields.density->active_percentiles.size(), count) << name;
  }
  // the only grid of vectors, where no grid is scalar
  EXPECT_EQ(VolumeFile(write_vdb({velocity})).default_grid(), "velocity");
  // a grid whose own name has a colon
  const VolumeFile odd(write_vdb({voxel("fire:x", 5)}));
  Scene scene;
  scene.grid = "fire:x";
  EXPECT_EQ(read_fields(scene, odd).density->name, "fire:x");
}

/// A file of format 221, as no library writes it any more, with one leaf whose voxel i has i.
/// Without `places` it is one that was written to a pipe.
std::string file_of_format_221(bool places) {
  std::string bytes;
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto put_text = [&](const std::string& text) {
    put(std::uint32_t(text.size()));
    bytes += text;
  };
  const auto put_first_of = [&](std::size_t bits) {  // a mask
    bytes += '\1';
    bytes.append(bits / 8 - 1, '\0');
  };
  const auto put_zeros = [&](std::size_t count) { bytes.append(count, '\0'); };
  put(std::int64_t{0x56444220});
  for (const std::uint32_t number : {221u, 1u, 0u}) put(number);
  put(char(places));
  put(char(0));  // not compressed
  bytes += "00000000-0000-0000-0000-000000000000";
  put(std::uint32_t{0});  // metadata
  put(std::int32_t{1});   // grids
  for (const char* text : {"density", "Tree_float_5_4_3", ""}) put_text(text);
  const std::size_t places_at = bytes.size(), begin = places_at + 3 * sizeof(std::int64_t);
  for (int n = 0; n < 3; ++n) put(std::int64_t(begin));
  put(std::uint32_t{0});  // metadata
  put_text("UniformScaleMap");
  for (int n = 0; n < 15; ++n) put(0.5);
  for (const std::uint32_t number : {1u, 0u, 0u, 1u}) put(number);  // buffers ... tiles, nodes
  put_zeros(3 * sizeof(int));
  for (const std::size_t values : {32768, 4096}) {
    put_first_of(values);
    put_zeros(values / 8 + (values - 1) * sizeof(float));
  }
  bytes.append(64, '\xff');
  bytes.append(64, '\xff');
  put_zeros(3 * sizeof(int));
  put(char(1));  // buffers
  for (int i = 0; i < 512; ++i) put(float(i));
  return with(bytes, places_at + 2 * sizeof(std::int64_t), std::int64_t(bytes.size()));
}

TEST(VdbFiles, AFileBeforeFormat222IsReadByOpenVdb) {
  for (const bool places : {true, false}) {
    const VolumeFile file(write_bytes("old.vdb", file_of_format_221(places)));
    const Field field = file.read("density");
    EXPECT_EQ(field.world_from_index[1][1], 0.5);
    EXPECT_EQ(field.active_voxels, 512u);
    const FieldVoxels voxels(field);
    EXPECT_EQ(voxels.voxel({0, 0, 7}, 0), 7);
    EXPECT_EQ(voxels.voxel({7, 0, 0}, 0), 448);
    EXPECT_EQ(file.info().at(0).transform, "UniformScaleMap");
  }
}

}  // namespace
}  // namespace psivox
