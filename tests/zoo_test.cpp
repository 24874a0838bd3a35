// A file of each kind that other programs write draws without an option, in the look and of the
// grid that a user expects, and its picture can be shown. PSIVOX_ZOO=FOLDER keeps the files there,
// for tools/contact-sheet.sh.

#include <functional>
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
  std::function<Grids()> grids;
  Floors floors{};
  /// Changes of the file's bytes, of the same length.
  std::vector<std::pair<std::string, std::string>> changes{};
};

FloatGrid::Ptr density() { return filled("density", cloud); }

/// A density, and grids beside it that hold nothing, or a fire.
std::vector<Animal> side_grids() {
  const auto scaled = [](double k) { return [=](const Coord& p) { return k * cloud(p); }; };
  return {
      {"blender_smoke", "smoke", "density",
       [=] {
         Grids grids{filled<Vec3SGrid>("velocity", whirl), density(), constant("shadow", -1, 16),
                     filled("temperature", scaled(0.4))};
         for (const char* name : {"flame", "fuel", "react", "color_r", "color_g", "color_b"})
           grids.push_back(named(name));
         return grids;
       }},
      {"flame_of_zeros", "smoke", "density",
       [] {
         return Grids{density(), constant("flame", 0), constant("heat", 0)};
       }},
      {"colour_of_zeros", "smoke", "density",
       [] {
         const auto zeros = named<Vec3SGrid>("Cd");
         zeros->fill(CoordBBox(Coord(-12), Coord(12)), Vec3s(0), true);
         return Grids{density(), zeros, named<Vec3SGrid>("vel")};
       }},
      {"fire_flame", "fire", "density",
       [] {
         return Grids{density(), filled("flame", flame)};
       }},
      {"fire_kelvin", "fire", "density",
       [] {
         const auto kelvin = [](const Coord& p) {
           return flame(p) > 0 ? 700 + 1300 * flame(p) : 0;
         };
         return Grids{density(), filled("temperature", kelvin)};
       }},
      {"fire_heat", "fire", "density",
       [] {
         return Grids{density(), filled("heat", [](const Coord& p) { return 0.76 * flame(p); })};
       }},
      {"density_empty", "smoke", "temperature",
       [=] {
         return Grids{named("density"), filled("temperature", scaled(2))};
       }},
      {"density_zero", "smoke", "soot",
       [] {
         return Grids{constant("density", 0), filled("soot", cloud)};
       }},
  };
}

std::vector<Animal> choices() {
  return {
      {"most_vectors", "vectors", "v:length",
       [] {
         return Grids{filled<Vec3SGrid>("rest", whirl, 4), filled<Vec3SGrid>("v", whirl)};
       }},
      {"level_sets_without_names", "surface", "[0]",
       [] {
         return Grids{level_set(""), level_set("")};
       }},
      {"rho_beside_p", "smoke", "rho",
       [] {
         return Grids{of_no_class(filled("p", waves)), of_no_class(filled("rho", cloud))};
       }},
      {"no_name", "smoke", "[0]", [] { return Grids{filled("", cloud)}; }},
      // phi is the liquid's surface: negative inside it, in all voxels of the domain
      {"blender_liquid", "surface", "phi",
       [] {
         const auto phi = of_class(filled("phi", torus), openvdb::GRID_LEVEL_SET);
         const auto obstacle = [](const Coord& p) { return 0.5 + (p.y() + 13); };
         return Grids{of_class(filled<Vec3SGrid>("velocity", whirl), openvdb::GRID_STAGGERED),
                      of_class(filled("phi_obstacle", obstacle, 14), openvdb::GRID_LEVEL_SET),
                      of_class(constant("phi_out", 10000, 14), openvdb::GRID_LEVEL_SET), phi,
                      points("particles")};
       }},
  };
}

std::vector<Animal> backgrounds() {
  const auto one = [](const auto& grid) { return on_background(grid, 1.0f); };
  const auto negative = [](const Coord& p) {
    return 2 * hues(p) - (cloud(p) > 0 ? Vec3d(1) : Vec3d(0));
  };
  return {
      {"background_one", "smoke", "density", [=] { return Grids{one(density())}; }},
      {"colours_on_white", "colors", "Cd:active",
       [] { return Grids{on_background(filled<Vec3SGrid>("Cd", hues), Vec3s(1))}; }},
      {"colours_on_minus_one", "colors", "colorGrid:active",
       [] { return Grids{on_background(filled<Vec3SGrid>("colorGrid", hues), Vec3s(-1))}; }},
      {"negative_colours", "colors", "Cd:active",
       [=] { return Grids{filled<Vec3SGrid>("Cd", negative)}; }},
      {"smoke_with_colours", "smoke", "density",
       [] {
         return Grids{density(), on_background(filled<Vec3SGrid>("Cd", hues), Vec3s(1))};
       }},
  };
}

std::vector<Animal> point_files() {
  return {
      {"points", "points", "points", [] { return Grids{points("points")}; }},
      {"points_of_unknown_codec",
       "points",
       "particles",
       [] { return Grids{points("particles")}; },
       {},
       {{"null", "trnc"}}},
      {"points_and_velocity", "points", "particles",
       [] {
         return Grids{filled<Vec3SGrid>("velocity", whirl), points("particles")};
       }},
  };
}

/// Each type of voxel. Integers have 100 where the cloud has 1.
std::vector<Animal> types() {
  const auto hundred = [](const Coord& p) { return int(100 * cloud(p)); };
  const auto inside = [](const Coord& p) { return torus(p) < 0; };
  const auto eight_bits = [](const Coord& p) { return std::round(255 * cloud(p)) / 255; };
  const auto labels = [](const Coord& p) {
    return torus(p) < 0 ? 1 + (p.x() + 16) / 3 + 10 * (p.z() > 0) : 0;
  };
  return {
      {"double", "smoke", "density", [] { return Grids{filled<DoubleGrid>("density", cloud)}; }},
      {"half", "smoke", "density",
       [] {
         const auto grid = density();
         grid->setSaveFloatAsHalf(true);
         return Grids{grid};
       }},
      {"int32", "smoke", "density", [=] { return Grids{filled<Int32Grid>("density", hundred)}; }},
      {"int64", "smoke", "density", [=] { return Grids{filled<Int64Grid>("density", hundred)}; }},
      {"bool", "labels", "inside",
       [=] { return Grids{of_no_class(filled<BoolGrid>("inside", inside))}; }},
      {"mask", "labels", "mask",
       [=] {
         const auto mask = named<openvdb::MaskGrid>("mask");
         for (const Coord& p : CoordBBox(Coord(-13), Coord(13)))
           if (inside(p)) mask->tree().setValueOn(p);
         return Grids{mask};
       }},
      {"vec3s", "vectors", "v:length", [] { return Grids{filled<Vec3SGrid>("v", whirl)}; }},
      {"vec3d", "vectors", "v:length", [] { return Grids{filled<Vec3DGrid>("v", whirl)}; }},
      {"vec3i", "vectors", "v:length",
       [] { return Grids{filled<Vec3IGrid>("v", [](const Coord& p) { return 9 * whirl(p); })}; }},
      {"staggered", "vectors", "vel:length",
       [] { return Grids{of_class(filled<Vec3SGrid>("vel", whirl), openvdb::GRID_STAGGERED)}; }},
      {"level_set", "surface", "torus", [] { return Grids{level_set("torus")}; }},
      {"level_set_double", "surface", "torus",
       [] { return Grids{level_set<DoubleGrid>("torus")}; }},
      {"level_set_of_no_class", "surface", "torus",
       [] { return Grids{of_no_class(level_set("torus"))}; }},
      {"distances_in_a_box", "surface", "sdf",
       [] { return Grids{of_no_class(filled("sdf", torus))}; }},
      {"distances_cut_off", "surface", "tsdf",
       [] {
         return Grids{of_no_class(
             filled("tsdf", [](const Coord& p) { return std::clamp(torus(p) / 3, -1.0, 1.0); }))};
       }},
      // in the world, where voxels are no cubes
      {"distances_between_slices", "surface", "distance",
       [] {
         const auto ball = [](const Coord& p) {
           return (p.asVec3d() * Vec3d(1, 1, 0.4)).length() - 6;
         };
         return Grids{placed(of_no_class(filled("distance", ball)),
                             axes({1, 0, 0}, {0, 1, 0}, {0, 0, 0.4}))};
       }},
      {"fog_of_wrong_class", "smoke", "fog",
       [] { return Grids{of_class(filled("fog", cloud), openvdb::GRID_LEVEL_SET)}; }},
      {"undershoots", "smoke", "smoke",
       [=] { return Grids{filled("smoke", [](const Coord& p) { return cloud(p) - 0.03; })}; }},
      {"faulty_voxel", "smoke", "smoke",
       [=] {
         return Grids{
             filled("smoke", [](const Coord& p) { return p == Coord(1) ? -5 : cloud(p); })};
       }},
      {"signed", "signed", "charge", [] { return Grids{of_no_class(filled("charge", waves))}; }},
      {"scan_of_8_bits", "scan", "ct",
       [=] { return Grids{of_no_class(filled("ct", eight_bits))}; }},
      // a box of values up to its faces is a scan, unless its name or class says smoke
      {"scan_of_floats", "scan", "mri",
       [=] {
         return Grids{of_no_class(filled("mri", [](const Coord& p) {
           return 0.001 + 0.002 * ((p.x() + p.y() * p.z()) & 3) + cloud(p);
         }))};
       }},
      {"density_of_no_class", "smoke", "density",
       [=] {
         return Grids{of_no_class(
             filled("density", [](const Coord& p) { return cloud(p) > 0.1 ? cloud(p) : 0; }))};
       }},
      // what fills the volume is the outside, though all of it is below 0
      {"logarithms", "scan", "log_rho",
       [=] {
         return Grids{
             of_no_class(filled("log_rho", [](const Coord& p) { return 6 * cloud(p) - 24; }))};
       }},
      {"fill_values_in_tiles", "scan", "temp",
       [=] {
         const auto grid = of_no_class(filled(
             "temp", [](const Coord& p) { return cloud(p) > 0 ? 280 + 20 * cloud(p) : 9.96921e36; },
             24));
         grid->pruneGrid();
         return Grids{grid};
       }},
      {"labels", "labels", "labels",
       [=] { return Grids{of_no_class(filled<Int32Grid>("labels", labels))}; }},
      // of a thousand cells, in floats
      {"instances", "labels", "cells",
       [=] {
         const auto cell = [](const Coord& p) {
           return 1.0 + (p.z() + 20) / 4 + 10 * ((p.y() + 20) / 4) + 100 * ((p.x() + 20) / 4);
         };
         return Grids{of_no_class(filled("cells", cell, 19))};
       }},
  };
}

/// Where voxels are, and how they are stored.
std::vector<Animal> places() {
  const auto at = [](const Transform::Ptr& transform) {
    return [=] { return Grids{placed(density(), transform)}; };
  };
  const auto tiles = [](const std::string& name) {
    auto grid = named(name);
    for (const Coord& p : {Coord(0, 0, 0), Coord(8, 0, 0), Coord(0, 8, 0), Coord(0, 0, 8)})
      grid->tree().addTile(1, p, 0.5f + 0.05f * float(p.x()), true);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
  };
  const auto frustum = Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(-13), Vec3d(13)),
                                                         /*taper=*/0.5, /*depth=*/2);
  return {
      {"tiles", "smoke", "density", [=] { return Grids{tiles("density")}; }},
      {"tiles_and_voxels", "smoke", "density",
       [=] {
         const auto grid = tiles("density");
         for (const Coord& p : CoordBBox(Coord(8, 0, 8), Coord(15, 7, 15)))
           grid->tree().setValue(p, 0.1f + float(cloud(p - Coord(11, 3, 11))));
         return Grids{grid};
       }},
      {"one_voxel", "smoke", "density", [] { return Grids{constant("density", 1, 0)}; }},
      {"sheet", "smoke", "density",
       [] {
         return Grids{filled("density", [](const Coord& p) { return p.z() == 0 ? cloud(p) : 0; })};
       }},
      // a solid of a few hundred voxels that does not fade to 0, as Houdini's VDB from Polygons has
      // it
      {"small_fog", "smoke", "density",
       [] {
         return Grids{filled("density", [](const Coord& p) {
           return p.asVec3d().lengthSqr() < 20 ? 0.3 + 0.7 * cloud(p) : 0;
         })};
       }},
      {"bad_values", "smoke", "density",
       [] {
         const auto grid = density();
         grid->tree().setValue(Coord(1, 2, 3), kNan);
         grid->tree().setValue(Coord(3, 2, 1), kInfinity);
         grid->tree().setValue(Coord(2, 2, 1), -kInfinity);
         return Grids{grid};
       }},
      {"anisotropic", "smoke", "density", at(axes({1, 0, 0}, {0, 0.4, 0}, {0, 0, 2}))},
      {"rotated", "smoke", "density",
       at(axes({0.8, 0.6, 0}, {-0.6, 0.8, 0}, {0, 0, 1}, {3, 0, 0}))},
      {"sheared", "smoke", "density", at(axes({1, 0, 0}, {0.7, 1, 0.3}, {0, 0, 1}))},
      {"mirrored", "smoke", "density", at(axes({-1, 0, 0}, {0, 1, 0}, {0, 0, 1}))},
      {"frustum", "smoke", "density", at(frustum)},
      {"far_away", "smoke", "density",
       at(axes({0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}, {1e5, -3e5, 2e5}))},
      {"tiny_voxels", "smoke", "density", at(Transform::createLinearTransform(2e-5))},
      {"huge_voxels", "smoke", "density", at(Transform::createLinearTransform(1e5))},
  };
}

/// Writes an animal's file.
std::filesystem::path caught(const Animal& animal) {
  const auto file = write_vdb(animal.grids(), animal.name + ".vdb");
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
    const LookedScene looked = with_look(scene, VdbFile(scene.input), "auto");
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

TEST_F(Zoo, FilesWithSideGrids) { expect_drawn(side_grids()); }
TEST_F(Zoo, FilesWithoutADensity) { expect_drawn(choices()); }
TEST_F(Zoo, FilesWithBackgroundsAndColours) { expect_drawn(backgrounds()); }
TEST_F(Zoo, FilesWithPoints) { expect_drawn(point_files()); }
TEST_F(Zoo, FilesOfEachType) { expect_drawn(types()); }
TEST_F(Zoo, FilesOfEachPlace) { expect_drawn(places()); }

/// The first animal of each look.
std::vector<Animal> one_of_each_look() {
  std::map<std::string, Animal> found;
  for (const auto& animals : {side_grids(), choices(), backgrounds(), point_files(), types()})
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
      const LookedScene looked = with_look(scene, VdbFile(scene.input), "auto");
      EXPECT_EQ(looked.look, animal.look) << color;
      Session session(make_view(looked.scene, looked.fields));
      const Image image = session.draw(*Gpu::renderer()).image;
      EXPECT_EQ(blank_reason(session.view(), image), "") << animal.look << " on " << color;
    }
  }
}

}  // namespace
}  // namespace psivox
