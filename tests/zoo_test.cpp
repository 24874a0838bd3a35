// A file of each kind that other programs write draws without an option, in the look and of the
// grid that a user expects, and its picture can be shown. PSIVOX_ZOO=FOLDER keeps the files there,
// for tools/contact-sheet.sh.

#include <map>

#include "scratch.h"
#include "showing.h"
#include "vdb_zoo_grids.h"

namespace psivox {
namespace {

using namespace test;
using openvdb::BoolGrid;
using openvdb::DoubleGrid;
using openvdb::Int32Grid;
using openvdb::Int64Grid;
using openvdb::Vec3DGrid;
using openvdb::Vec3IGrid;
using openvdb::Vec3SGrid;
using Grids = openvdb::GridCPtrVec;

struct Animal {
  std::string name;  ///< of its file
  std::string look, grid;
  Grids grids;
  Floors floors{};
  /// Changes of the file's bytes, of the same length.
  std::vector<std::pair<std::string, std::string>> changes{};
};

FloatGrid::Ptr density() { return filled("density", cloud); }

/// A density, and grids beside it that hold nothing, or a fire.
std::vector<Animal> side_grids() {
  const auto scaled = [](double k) { return [=](const Coord& p) { return k * cloud(p); }; };
  const auto kelvin = [](const Coord& p) { return flame(p) > 0 ? 700 + 1300 * flame(p) : 0; };
  const auto heat = [](const Coord& p) { return 0.76 * flame(p); };
  Grids blenders{filled<Vec3SGrid>("velocity", whirl), density(), constant("shadow", -1, 16),
                 filled("temperature", scaled(0.4))};
  for (const char* name : {"flame", "fuel", "react", "color_r", "color_g", "color_b"})
    blenders.push_back(named(name));
  const Grids cold_flame{density(), constant("flame", 0), constant("heat", 0)};
  const Grids heat_alone{named("density"), filled("temperature", scaled(2))};
  const auto zeros = named<Vec3SGrid>("Cd");
  zeros->fill(CoordBBox(Coord(-12), Coord(12)), Vec3s(0), true);
  return {
      {"blender_smoke", "smoke", "density", blenders},
      {"flame_of_zeros", "smoke", "density", cold_flame},
      {"colour_of_zeros", "smoke", "density", {density(), zeros, named<Vec3SGrid>("vel")}},
      {"fire_flame", "fire", "density", {density(), filled("flame", flame)}},
      {"fire_kelvin", "fire", "density", {density(), filled("temperature", kelvin)}},
      {"fire_heat", "fire", "density", {density(), filled("heat", heat)}},
      {"density_empty", "smoke", "temperature", heat_alone},
      {"density_zero", "smoke", "soot", {constant("density", 0), filled("soot", cloud)}},
  };
}

std::vector<Animal> choices() {
  const Grids vectors{filled<Vec3SGrid>("rest", whirl, 4), filled<Vec3SGrid>("v", whirl)};
  const Grids gas{of_no_class(filled("p", waves)), of_no_class(filled("rho", cloud))};
  // phi is the liquid's surface: negative inside it, in all voxels of the domain
  const auto obstacle = [](const Coord& p) { return 0.5 + (p.y() + 13); };
  const Grids liquid{of_class(filled<Vec3SGrid>("velocity", whirl), openvdb::GRID_STAGGERED),
                     of_class(filled("phi_obstacle", obstacle, 14), openvdb::GRID_LEVEL_SET),
                     of_class(constant("phi_out", 10000, 14), openvdb::GRID_LEVEL_SET),
                     of_class(filled("phi", torus), openvdb::GRID_LEVEL_SET), points("particles")};
  return {
      {"most_vectors", "vectors", "v:length", vectors},
      {"level_sets_without_names", "surface", "[0]", {level_set(""), level_set("")}},
      {"rho_beside_p", "smoke", "rho", gas},
      {"no_name", "smoke", "[0]", {filled("", cloud)}},
      {"blender_liquid", "surface", "phi", liquid},
  };
}

std::vector<Animal> backgrounds() {
  const auto negative = [](const Coord& p) {
    return 2 * hues(p) - (cloud(p) > 0 ? Vec3d(1) : Vec3d(0));
  };
  const auto colours = [](const std::string& name, float background) {
    return on_background(filled<Vec3SGrid>(name, hues), Vec3s(background));
  };
  return {
      {"background_one", "smoke", "density", {on_background(density(), 1.0f)}},
      {"colours_on_white", "colors", "Cd:active", {colours("Cd", 1)}},
      {"colours_on_minus_one", "colors", "colorGrid:active", {colours("colorGrid", -1)}},
      {"negative_colours", "colors", "Cd:active", {filled<Vec3SGrid>("Cd", negative)}},
      {"smoke_with_colours", "smoke", "density", {density(), colours("Cd", 1)}},
  };
}

std::vector<Animal> point_files() {
  const Grids particles{points("particles")};
  const Grids moving{filled<Vec3SGrid>("velocity", whirl), points("particles")};
  return {
      {"points", "points", "points", {points("points")}},
      {"points_of_unknown_codec", "points", "particles", particles, {}, {{"null", "trnc"}}},
      {"points_and_velocity", "points", "particles", moving},
  };
}

/// Each type of voxel. Integers have 100 where the cloud has 1.
std::vector<Animal> types() {
  const auto hundred = [](const Coord& p) { return int(100 * cloud(p)); };
  const auto inside = [](const Coord& p) { return torus(p) < 0; };
  const auto of_vectors = [](const Coord& p) { return 9 * whirl(p); };
  const auto staggered = of_class(filled<Vec3SGrid>("vel", whirl), openvdb::GRID_STAGGERED);
  const auto halves = density();
  halves->setSaveFloatAsHalf(true);
  const auto mask = named<openvdb::MaskGrid>("mask");
  for (const Coord& p : CoordBBox(Coord(-13), Coord(13)))
    if (inside(p)) mask->tree().setValueOn(p);
  return {
      {"double", "smoke", "density", {filled<DoubleGrid>("density", cloud)}},
      {"half", "smoke", "density", {halves}},
      {"int32", "smoke", "density", {filled<Int32Grid>("density", hundred)}},
      {"int64", "smoke", "density", {filled<Int64Grid>("density", hundred)}},
      {"bool", "labels", "inside", {of_no_class(filled<BoolGrid>("inside", inside))}},
      {"mask", "labels", "mask", {mask}},
      {"vec3s", "vectors", "v:length", {filled<Vec3SGrid>("v", whirl)}},
      {"vec3d", "vectors", "v:length", {filled<Vec3DGrid>("v", whirl)}},
      {"vec3i", "vectors", "v:length", {filled<Vec3IGrid>("v", of_vectors)}},
      {"staggered", "vectors", "vel:length", {staggered}},
  };
}

std::vector<Animal> surfaces() {
  const auto cut_off = [](const Coord& p) { return std::clamp(torus(p) / 3, -1.0, 1.0); };
  // in the world, where voxels are no cubes
  const auto ball = [](const Coord& p) { return (p.asVec3d() * Vec3d(1, 1, 0.4)).length() - 6; };
  const auto between_slices =
      placed(of_no_class(filled("distance", ball)), axes({1, 0, 0}, {0, 1, 0}, {0, 0, 0.4}));
  return {
      {"level_set", "surface", "torus", {level_set("torus")}},
      {"level_set_double", "surface", "torus", {level_set<DoubleGrid>("torus")}},
      {"level_set_of_no_class", "surface", "torus", {of_no_class(level_set("torus"))}},
      {"distances_in_a_box", "surface", "sdf", {of_no_class(filled("sdf", torus))}},
      {"distances_cut_off", "surface", "tsdf", {of_no_class(filled("tsdf", cut_off))}},
      {"distances_between_slices", "surface", "distance", {between_slices}},
  };
}

/// What values say of a grid's kind.
std::vector<Animal> kinds() {
  const auto grid = [](const std::string& name, auto shape, int radius = 13) {
    return of_no_class(filled(name, shape, radius));
  };
  const auto fog = of_class(filled("fog", cloud), openvdb::GRID_LEVEL_SET);
  const auto undershoots = [](const Coord& p) { return cloud(p) - 0.03; };
  const auto faulty = [](const Coord& p) { return p == Coord(1) ? -5 : cloud(p); };
  const auto eight_bits = [](const Coord& p) { return std::round(255 * cloud(p)) / 255; };
  // a box of values up to its faces is a scan, unless its name or class says smoke
  const auto up_to_faces = [](const Coord& p) {
    return 0.001 + 0.002 * ((p.x() + p.y() * p.z()) & 3) + cloud(p);
  };
  const auto thick = [](const Coord& p) { return cloud(p) > 0.1 ? cloud(p) : 0; };
  // what fills the volume is the outside, though all of it is below 0
  const auto logarithms = [](const Coord& p) { return 6 * cloud(p) - 24; };
  const auto kelvin = [](const Coord& p) {
    return cloud(p) > 0 ? 280 + 20 * cloud(p) : 9.96921e36;
  };
  const auto fill_values = grid("temp", kelvin, 24);
  fill_values->pruneGrid();
  const auto labels = [](const Coord& p) {
    return torus(p) < 0 ? 1 + (p.x() + 16) / 3 + 10 * (p.z() > 0) : 0;
  };
  // of 5832 cells, in floats
  const auto cell = [](const Coord& p) {
    return 1.0 + (p.z() + 27) / 3 + 18 * ((p.y() + 27) / 3) + 324 * ((p.x() + 27) / 3);
  };
  return {
      {"fog_of_wrong_class", "smoke", "fog", {fog}},
      {"undershoots", "smoke", "smoke", {filled("smoke", undershoots)}},
      {"faulty_voxel", "smoke", "smoke", {filled("smoke", faulty)}},
      {"signed", "signed", "charge", {grid("charge", waves)}},
      {"scan_of_8_bits", "scan", "ct", {grid("ct", eight_bits)}},
      {"scan_of_floats", "scan", "mri", {grid("mri", up_to_faces)}},
      {"density_of_no_class", "smoke", "density", {grid("density", thick)}},
      {"logarithms", "scan", "log_rho", {grid("log_rho", logarithms)}},
      {"fill_values_in_tiles", "scan", "temp", {fill_values}},
      {"labels", "labels", "labels", {of_no_class(filled<Int32Grid>("labels", labels))}},
      {"instances", "labels", "cells", {grid("cells", cell, 26)}},
  };
}

/// Where voxels are, and how they are stored.
std::vector<Animal> places() {
  const auto at = [](const Transform::Ptr& transform) { return placed(density(), transform); };
  const auto tiles = [] {
    auto grid = named("density");
    for (const Coord& p : {Coord(0, 0, 0), Coord(8, 0, 0), Coord(0, 8, 0), Coord(0, 0, 8)})
      grid->tree().addTile(1, p, 0.5f + 0.05f * float(p.x()), true);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
  };
  const auto voxels_too = tiles();
  for (const Coord& p : CoordBBox(Coord(8, 0, 8), Coord(15, 7, 15)))
    voxels_too->tree().setValue(p, 0.1f + float(cloud(p - Coord(11, 3, 11))));
  const auto sheet = [](const Coord& p) { return p.z() == 0 ? cloud(p) : 0; };
  // a solid of a few hundred voxels that does not fade to 0, as Houdini's VDB from Polygons has it
  const auto solid = [](const Coord& p) {
    return p.asVec3d().lengthSqr() < 20 ? 0.3 + 0.7 * cloud(p) : 0;
  };
  const auto bad_values = density();
  bad_values->tree().setValue(Coord(1, 2, 3), kNan);
  bad_values->tree().setValue(Coord(3, 2, 1), kInfinity);
  bad_values->tree().setValue(Coord(2, 2, 1), -kInfinity);
  const auto frustum = Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(-13), Vec3d(13)),
                                                         /*taper=*/0.5, /*depth=*/2);
  const Vec3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {
      {"tiles", "smoke", "density", {tiles()}},
      {"tiles_and_voxels", "smoke", "density", {voxels_too}},
      {"one_voxel", "smoke", "density", {constant("density", 1, 0)}},
      {"sheet", "smoke", "density", {filled("density", sheet)}},
      {"small_fog", "smoke", "density", {filled("density", solid)}},
      {"bad_values", "smoke", "density", {bad_values}},
      {"anisotropic", "smoke", "density", {at(axes(x, 0.4 * y, 2 * z))}},
      {"rotated", "smoke", "density", {at(axes({0.8, 0.6, 0}, {-0.6, 0.8, 0}, z, 3 * x))}},
      {"sheared", "smoke", "density", {at(axes(x, {0.7, 1, 0.3}, z))}},
      {"mirrored", "smoke", "density", {at(axes(-x, y, z))}},
      {"frustum", "smoke", "density", {at(frustum)}},
      {"far_away", "smoke", "density", {at(axes(0.1 * x, 0.1 * y, 0.1 * z, {1e5, -3e5, 2e5}))}},
      {"tiny_voxels", "smoke", "density", {at(Transform::createLinearTransform(2e-5))}},
      {"huge_voxels", "smoke", "density", {at(Transform::createLinearTransform(1e5))}},
  };
}

/// Writes an animal's file.
std::filesystem::path caught(const Animal& animal) {
  const auto file = write_vdb(animal.grids, animal.name + ".vdb");
  if (animal.changes.empty()) return file;
  std::string bytes = file_bytes(file);
  for (const auto& [from, to] : animal.changes)
    for (std::size_t at = 0; (at = bytes.find(from, at)) != std::string::npos; at += to.size())
      bytes.replace(at, from.size(), to);
  return write_bytes(animal.name + ".vdb", bytes);
}

void expect_drawn(const Animal& animal) {
  SCOPED_TRACE(animal.name);
  Scene scene;
  scene.input = caught(animal).string();
  scene.resolution = {192, 108};
  if (const char* folder = std::getenv("PSIVOX_ZOO"))
    std::filesystem::copy_file(scene.input, std::filesystem::path(folder) / (animal.name + ".vdb"),
                               std::filesystem::copy_options::overwrite_existing);
  try {
    const LookedScene looked = with_look(scene, VolumeFile(scene.input), "auto");
    EXPECT_EQ(looked.look, animal.look);
    EXPECT_EQ(looked.fields.density->name, animal.grid);
    expect_shown(animal.name, looked, animal.floors);
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what();
  }
}

void expect_drawn(const std::vector<Animal>& animals) {
  for (const Animal& animal : animals) expect_drawn(animal);
}

using Zoo = GpuTest;

/// Nothing shows which sign a program gives the inside.
TEST_F(Zoo, DistancesMayBePositiveInside) {
  const auto inside_out = of_no_class(filled("sdf", [](const Coord& p) { return -torus(p); }));
  const auto band = on_background(of_no_class(level_set("sdf")), -3.0F);  // inactive values follow
  for (auto value = band->beginValueOn(); value; ++value) value.setValue(-*value);
  const auto picture_of = [](const FloatGrid::Ptr& grid) {
    Scene scene;
    scene.input = write_vdb({grid}, "inside.vdb").string();
    scene.resolution = {96, 54};
    set_parameter(scene, "camera-position", "10,40,60");
    const LookedScene looked = with_look(scene, VolumeFile(scene.input), "auto");
    return Session(make_view(looked.scene, looked.fields)).draw(*Gpu::renderer()).image;
  };
  const Image full = picture_of(of_no_class(filled("sdf", torus)));
  EXPECT_LE(difference("full", picture_of(inside_out), full).rms, 1e-4);
  EXPECT_LE(difference("band", picture_of(band), full).rms, 1e-4);
}

TEST_F(Zoo, FilesWithSideGrids) { expect_drawn(side_grids()); }
TEST_F(Zoo, FilesWithoutADensity) { expect_drawn(choices()); }
TEST_F(Zoo, FilesWithBackgroundsAndColours) { expect_drawn(backgrounds()); }
TEST_F(Zoo, FilesWithPoints) { expect_drawn(point_files()); }
TEST_F(Zoo, FilesOfEachType) {
  expect_drawn(types());
  expect_drawn(surfaces());
  expect_drawn(kinds());
}
TEST_F(Zoo, FilesOfEachPlace) { expect_drawn(places()); }

TEST_F(Zoo, ADefaultPictureReadsItsDensityOnce) {
  const auto plume = [](const Coord& p) { return 0.001 + cloud(p); };
  const std::pair<const char*, FloatGrid::Ptr> files[] = {
      {"smoke", filled("smoke", cloud, 40)}, {"scan", of_no_class(filled("mri", plume, 40))}};
  for (const auto& [look, density] : files) {
    Scene scene;
    scene.input = write_vdb({density}).string();
    int readings = 0;
    const VolumeFile file(scene.input, [&](double done) { readings += done == 1; });
    EXPECT_EQ(with_look(scene, file, "auto").look, look);
    EXPECT_EQ(readings, 1) << look;
  }
}

TEST_F(Zoo, ColoursOnAPlaneAreColours) {
  const auto plane_of = [](const openvdb::GridBase::Ptr& grid) {
    Scene scene;
    scene.input = write_vdb({grid}).string();
    scene.mode = Mode::slice;
    return with_look(scene, VolumeFile(scene.input), "auto").scene;
  };
  EXPECT_EQ(plane_of(filled<Vec3SGrid>("Cd", hues)).luminance_grid, "Cd");
  EXPECT_EQ(plane_of(filled<Vec3SGrid>("v", whirl)).luminance_grid, "");
}

/// The first animal of each look.
std::vector<Animal> one_of_each_look() {
  std::map<std::string, Animal> found;
  for (const auto& animals :
       {side_grids(), choices(), backgrounds(), point_files(), types(), surfaces(), kinds()})
    for (const Animal& animal : animals) found.emplace(animal.look, animal);
  std::vector<Animal> all;
  for (const auto& [look, animal] : found) all.push_back(animal);
  return all;
}

TEST_F(Zoo, EveryLookIsSeenOnAnyBackground) {
  const std::vector<Animal> animals = one_of_each_look();
  EXPECT_EQ(animals.size(), look_names().size() - 3) << "all but plain, mip and xray";
  for (const Animal& animal : animals) {
    Scene scene;
    scene.input = caught(animal).string();
    scene.resolution = {96, 54};
    scene.tolerance = 3e-3;
    for (const char* color : {"white", "black", "#ff8000"}) {
      set_parameter(scene, "background", color);
      const LookedScene looked = with_look(scene, VolumeFile(scene.input), "auto");
      EXPECT_EQ(looked.look, animal.look) << color;
      Session session(make_view(looked.scene, looked.fields));
      const Image image = session.draw(*Gpu::renderer()).image;
      EXPECT_EQ(blank_reason(session.view(), image), "") << animal.look << " on " << color;
    }
  }
}

}  // namespace
}  // namespace psivox
