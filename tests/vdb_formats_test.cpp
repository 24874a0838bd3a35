// Rows of docs/formats.md that no other test covers. Each file is made here, and drawn by the march
// in double, by the GPU where there is one, and by the reference.

#include <openvdb/openvdb.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "made_fields.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "psivox/open.h"
#include "scratch.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox {
namespace {

using namespace test;

/// Null on a machine without a device for OpenGL.
Marcher* gpu() {
  static const std::shared_ptr<Marcher> opened = []() -> std::shared_ptr<Marcher> {
    try {
      return open_gpu();
    } catch (const Error& error) {
      std::printf("  the GPU's part is skipped: %s\n", error.what());
      return nullptr;
    }
  }();
  return opened.get();
}

/// A block of 14 x 11 x 9 voxels of different values up to `largest`, across leaves.
FloatGrid::Ptr block(float largest, const Transform::Ptr& transform = nullptr,
                     float background = 0) {
  auto grid = named("density");
  grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
  for (const Coord& c : CoordBBox(Coord(0), Coord(13, 10, 8))) {
    const int n = (c.x() * 7 + c.y() * 5 + c.z() * 3) % 11;
    grid->tree().setValue(c + Coord(-3, 2, 5), largest * float(n + 1) / 11);
  }
  if (transform) grid->setTransform(transform);
  return grid;
}

/// Draws the file by the three marchers and compares. Returns the reference's picture.
///
/// The luminance is constant or its rays meet none, so cells have no step error. In double what is
/// left is that both pictures are stored in float32, which rounds by 6e-8 each. The GPU adds up the
/// optical depth, 3 in the mean and at most 12, of some 30 cells, whose values and lengths are off
/// by 2^-24: 30 roundings of 6e-8 times x e^-x, which is 0.37 at most. Roundings grow with a
/// radiance above 1. Emission is a sum, each of whose roundings counts in full: slope 1.
Image expect_reference(const std::string& what, Scene scene, const std::filesystem::path& file,
                       double slope = 0.37) {
  scene.input = file.string();
  scene.resolution = {32, 24};
  scene.sampling = Sampling::cells;
  scene.early_termination = 0;
  Session session(scene);
  const Image exact = session.draw(*open_reference()).image;
  EXPECT_GE(mean_alpha(exact), 0.01) << what;
  EXPECT_LE(mean_alpha(exact), 0.999) << what;
  double largest = 1;
  for (const float value : exact.rgba()) largest = std::max(largest, double(value));
  const auto compare = [&](const char* marcher, const Image& image, double bound) {
    const Comparison c = compare_images(image, exact);
    std::printf("  %-28s %-7s max %.1e\n", what.c_str(), marcher, c.max);
    EXPECT_EQ(c.not_finite, 0u) << what;
    EXPECT_LE(c.max, bound * largest) << what << ", " << marcher;
  };
  compare("double", session.draw(*open_double()).image, 1.2e-7);
  if (gpu()) compare("GPU", session.draw(*gpu()).image, 30 * 6e-8 * slope);
  return exact;
}

TEST(Formats, TransformsOfEverySizeAndHand) {
  for (const double size : {2e-5, 1e6})
    expect_reference("voxels of " + std::to_string(size), {},
                     write_vdb({block(1, Transform::createLinearTransform(size))}));
  const auto mirrored = Transform::createLinearTransform(0.5);
  mirrored->preScale(openvdb::Vec3d(1, -1, 1));
  expect_reference("negative determinant", {}, write_vdb({block(1, mirrored)}));
  const auto sheared = mirrored->copy();
  sheared->postShear(0.7, openvdb::math::X_AXIS, openvdb::math::Z_AXIS);
  sheared->preScale(openvdb::Vec3d(1, 2, 0.25));
  expect_reference("sheared, too", {}, write_vdb({block(1, sheared)}));
}

TEST(Formats, ValuesOfEverySize) {
  for (const float largest : {1e-30f, 1e30f}) {
    expect_reference("values up to " + std::to_string(std::log10(largest)), {},
                     write_vdb({block(largest)}));
    for (const double size : {2e-5, 1e6})
      expect_reference("and voxels of " + std::to_string(size), {},
                       write_vdb({block(largest, Transform::createLinearTransform(size))}));
  }
}

TEST(Formats, OneVoxelAnywhere) {
  for (const Coord& at : {Coord(0), Coord(-1), Coord(7, 8, 9), Coord(1000000, -1000000, 5)})
    expect_reference("one voxel at " + std::to_string(at.x()), {},
                     write_vdb({voxel("density", 2, at)}));
}

TEST(Formats, NoVoxelAndNoGridAreErrors) {
  const auto error = [](const openvdb::GridCPtrVec& grids) {
    const VolumeFile file(write_vdb(grids));
    return input_error([&] { file.read(file.default_grid()); });
  };
  EXPECT_TRUE(has(error({named("density")}), "grid 'density' has no active voxel"));
  EXPECT_TRUE(has(error({}), "holds no grid"));
}

TEST(Formats, ALevelSetWithDistancesOfTheOtherSignIsRefused) {
  const auto grid = of_class(voxel("sdf", 0.1f), openvdb::GRID_LEVEL_SET);
  grid->tree().root().setBackground(-0.15f, /*updateChildNodes=*/false);
  const VolumeFile file(write_vdb({grid}));
  for (const bool distances : {false, true})
    EXPECT_TRUE(has(input_error([&] { file.read("sdf", {.distances = distances}); }),
                    "a level set whose background is -0.15: its distances have the opposite sign"));
  EXPECT_TRUE(has(file.info(true).at(0).problem, "opposite sign"));
}

TEST(Formats, DoublesBeyondFloatsAreInfinite) {
  const auto grid = voxel<openvdb::DoubleGrid>("density", 1e300);
  grid->tree().setValue(Coord(1), 1e-300);
  grid->tree().setValue(Coord(2), 3);
  const Field field = VolumeFile(write_vdb({grid})).read("density");
  EXPECT_EQ(field.notices.at(0), "grid 'density': 1 +Inf taken as 3");
  EXPECT_EQ(FieldVoxels(field).voxel({1, 1, 1}, 0), 0);
}

TEST(Formats, AStaggeredGridIsTakenAtItsVoxels) {
  const auto grid = voxel<openvdb::Vec3SGrid>("velocity", {1, -2, 3}, Coord(1, 2, 3));
  grid->setGridClass(openvdb::GRID_STAGGERED);
  const Field field = VolumeFile(write_vdb({grid})).read("velocity", {.role = GridRole::data});
  EXPECT_EQ(FieldVoxels(field).voxel({1, 2, 3}, 1), -2);
  ASSERT_EQ(field.notices.size(), 1u);
  EXPECT_TRUE(has(field.notices[0], "staggered"));
}

// --- a background other than 0 -------------------------------------------------------------------

/// The block with a hole that stores the background, and a tile that does.
template <typename GridT>
typename GridT::Ptr with_background(typename GridT::ValueType background) {
  using ValueT = typename GridT::ValueType;
  auto grid = named<GridT>("density");
  grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
  for (const Coord& c : CoordBBox(Coord(0), Coord(9))) grid->tree().setValue(c, ValueT(4));
  grid->tree().setValueOff(Coord(5), background);
  grid->tree().setValueOff(Coord(6), ValueT(2));
  grid->tree().addTile(1, Coord(0, 0, 16), background, false);
  grid->tree().addTile(1, Coord(0, 0, 24), background, true);
  grid->tree().addTile(1, Coord(6000, 0, 0), ValueT(4), true);
  return grid;
}

template <typename GridT>
void expect_background_as(typename GridT::ValueType background, double given) {
  const VolumeFile file(write_vdb({with_background<GridT>(background)}));
  EXPECT_TRUE(has(input_error([&] { file.read("density", {.strict = true}); }),
                  "--background-value 0 leaves the outside empty"));
  EXPECT_NO_THROW(file.read("density", {.strict = true, .background = 0}));
  if (given == 0)
    for (const GridRole role : {GridRole::attenuation, GridRole::luminance, GridRole::data}) {
      const Field chosen = file.read("density", {.role = role});
      EXPECT_EQ(chosen.notices.at(0), file.read("density", {.background = 0}).notices.at(0) +
                                          "; --background-value gives another value");
      EXPECT_TRUE(same(chosen.tiles, file.read("density", {.background = 0}).tiles));
      EXPECT_EQ(FieldVoxels(chosen).voxel({5, 5, 5}, 0), 0);
    }
  const Field field = file.read("density", {.background = given});
  ASSERT_EQ(field.notices.size(), 1u);
  EXPECT_TRUE(has(field.notices[0], "grid 'density': its background "));
  EXPECT_EQ(field.active_box, (Box{{0, 0, 0}, {6007, 9, 31}}));
  const FieldVoxels sampler(field);
  for (int c = 0; c < field.channels; ++c) {
    EXPECT_EQ(sampler.voxel({4, 4, 4}, c), 4);
    EXPECT_EQ(sampler.voxel({6, 6, 6}, c), 2);           // inactive, of a value of its own
    EXPECT_EQ(sampler.voxel({5, 5, 5}, c), given);       // inactive
    EXPECT_EQ(sampler.voxel({3, 3, 17}, c), given);      // in an inactive tile
    EXPECT_EQ(sampler.voxel({3, 3, 25}, c), 1);          // active: the file means it
    EXPECT_EQ(sampler.voxel({9, 12, 3}, c), given);      // in no leaf, in a node
    EXPECT_EQ(sampler.voxel({3, -1, 3}, c), given);      // in no node, at the domain's face
    EXPECT_EQ(sampler.voxel({6008, 10, 32}, c), given);  // its last corner
  }
}

TEST(Formats, ABackgroundOtherThan0IsVacuumOrAnotherValue) {
  for (const double given : {0.0, 3.0}) {
    expect_background_as<FloatGrid>(1, given);
    expect_background_as<openvdb::DoubleGrid>(1, given);
    expect_background_as<openvdb::Int32Grid>(1, given);
    expect_background_as<openvdb::Int64Grid>(1, given);
    expect_background_as<openvdb::Vec3SGrid>(openvdb::Vec3s(1), given);
    expect_background_as<openvdb::Vec3DGrid>(openvdb::Vec3d(1), given);
    expect_background_as<openvdb::Vec3IGrid>(openvdb::Vec3i(1), given);
  }
  const auto nan = voxel("density", 1);
  nan->tree().root().setBackground(std::nanf(""), /*updateChildNodes=*/false);
  nan->tree().setValueOff(Coord(1), std::nanf(""));
  const Field field = VolumeFile(write_vdb({nan})).read("density", {.background = 0});
  EXPECT_EQ(field.notices,
            std::vector<std::string>{"grid 'density': its background nan is taken as 0"});
}

TEST(Formats, ABackgroundThatDoesNotFitIsAnError) {
  const auto error = [](const openvdb::GridBase::Ptr& grid, double given) {
    const VolumeFile file(write_vdb({grid}));
    return input_error([&] { file.read("density", {.background = given}); });
  };
  EXPECT_TRUE(has(error(with_background<openvdb::Int32Grid>(1), 0.5), "has no value 0.5"));
  EXPECT_TRUE(has(error(with_background<openvdb::Int32Grid>(1), 3e9), "has no value 3e+09"));
  EXPECT_TRUE(has(error(with_background<FloatGrid>(1), 1e39), "has no value 1e+39"));
  auto wide = with_background<FloatGrid>(1);
  wide->tree().setValue(Coord(500000000, 500000000, 500000000), 1);
  EXPECT_TRUE(has(error(wide, 3), "too wide"));
  EXPECT_EQ(VolumeFile(write_vdb({wide})).read("density", {.background = 0}).tiles.size(), 2u);
}

TEST(Formats, ABackgroundIsDrawnWithinTheDomain) {
  auto grid = block(1, nullptr, /*background=*/1);
  for (const Coord& c : CoordBBox(Coord(12, 2, 5), Coord(25, 6, 9)))
    grid->tree().setValue(c, 0.25f);
  grid->tree().setValueOff(Coord(2, 5, 8), 1);
  const auto file = write_vdb({grid});
  Scene scene;
  scene.background_value = 0;
  const Image empty = expect_reference("background 0", scene, file);
  scene.background_value = 0.125;
  const Image filled = expect_reference("background 0.125", scene, file);
  EXPECT_GT(compare_images(empty, filled).max, 0.1);
}

// --- several grids -------------------------------------------------------------------------------

TEST(Formats, GridsWhoseBoxesDoNotTouch) {
  auto color = named<openvdb::Vec3SGrid>("Cd");
  color->setTransform(Transform::createLinearTransform(0.3));
  color->tree().fill(CoordBBox(Coord(200, 0, 0), Coord(220, 9, 9)), openvdb::Vec3s(1, 0.5f, 0.2f));
  const auto file = write_vdb({block(1), color});
  Scene scene;
  scene.grid = "density";
  scene.luminance_grid = "Cd";
  const Image dark = expect_reference("luminance elsewhere", scene, file);
  for (std::size_t i = 0; i < dark.rgba().size(); ++i)
    if (i % 4 != 3) {
      ASSERT_EQ(dark.rgba()[i], 0);
    }

  // The camera frames the density, 14 voxels wide; the source lies beside it and is in view.
  scene.luminance_grid.clear();
  scene.luminance = glm::dvec3(0);
  scene.emission_grid = "Cd";
  scene.camera_position = glm::dvec3(30, 5, 150);
  scene.camera_target = glm::dvec3(30, 5, 5);
  scene.extinction = 0.5;
  expect_reference("emission elsewhere", scene, file, /*slope=*/1);
}

TEST(Formats, WhatIsTooLargeToLightIsPlainUnlessLightIsAskedFor) {
  auto wide = named("density");
  wide->tree().addTile(3, Coord(0), 0.5f, true);  // 512^3 blocks, 2^24 can be lit
  Scene scene;
  scene.input = write_vdb({wide}).string();
  scene.resolution = {32, 24};
  const auto looked = [&] { return with_look(scene, VolumeFile(scene.input), "auto"); };
  const auto error = [&](const LookedScene& given) {
    return error_of(ExitCode::memory,
                    [&] { Session(make_view(given.scene, given.fields)).draw(*open_double()); });
  };
  EXPECT_EQ(looked().look, "plain");
  EXPECT_TRUE(has(looked().dark_because, "too many to light"));
  EXPECT_EQ(error(looked()), "no error");
  scene.lights = {{{0, -1, 0}, {1, 1, 1}}};
  EXPECT_EQ(looked().scene.lights.size(), 1u);
  EXPECT_TRUE(has(error(looked()), "too many to light; leave light out"));

  // light over 2 MiB of values, which fits without a limit alone
  scene.lights.clear();
  auto dense = named("density");
  dense->denseFill(openvdb::CoordBBox(Coord(0), Coord(79)), 1.0f);
  for (const Coord& c : CoordBBox(Coord(0), Coord(79)))
    dense->tree().setValue(c, float(c.x() % 7 + 1));
  scene.input = write_vdb({dense}).string();
  EXPECT_EQ(looked().dark_because, "");
  EXPECT_NE(looked().look, "plain");
  scene.memory_limit = 3 << 20;
  EXPECT_TRUE(has(looked().dark_because, "light needs"));
  EXPECT_EQ(looked().look, "plain");
}

TEST(Formats, ADamagedGridLeavesTheOthers) {
  auto heat = block(1);
  heat->setName("heat");
  heat->setTransform(Transform::createLinearTransform(0.5));
  std::string bytes = test::file_bytes(write_vdb({heat, block(1)}));
  const std::size_t map = bytes.find("UniformScaleMap");
  ASSERT_LT(map, bytes.rfind("density"));  // that of the first grid
  bytes[map] = 'X';
  const VolumeFile file(test::write_bytes("damaged.vdb", bytes));
  EXPECT_TRUE(has(file.info().at(0).problem, "cannot be read"));
  EXPECT_TRUE(has(input_error([&] { file.read("heat"); }), "grid 'heat' cannot be read"));
  EXPECT_EQ(file.read("density").active_voxels, 14u * 11 * 9);
}

}  // namespace
}  // namespace psivox
