// Looks: which one a file gets, that its options give the same picture, and that default pictures
// can be shown.

#include "psivox/open.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <memory>

#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/picture_file.h"
#include "psivox/vdb.h"
#include "scene/transfer_function.h"
#include "scratch.h"
#include "showing.h"
#include "thrown.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

std::string asset(const char* name) { return std::string(PSIVOX_ASSETS) + "/" + name; }

Scene scene_of(const std::string& file) {
  Scene scene;
  scene.input = file;
  scene.resolution = {192, 108};
  return scene;
}

LookedScene auto_look(const Scene& scene) {
  return with_look(scene, VolumeFile(scene.input), "auto");
}

TEST(Look, IsOpenUnlessTheSceneSaysHowTheMediumShines) {
  const auto leaves_open = [](const std::string& setting) {
    const std::size_t equals = setting.find('=');
    Scene given;
    set_parameter(given, setting.substr(0, equals), setting.substr(equals + 1));
    return leaves_look_open(given);
  };
  for (const char* open : {"extinction=2", "camera-position=1,1,1", "tolerance=1e-3",
                           "clip=0,0,0,1,1,1", "range=10%,90%", "opacity=0:0,1:1", "isovalue=0.5",
                           "light=0,-1,0", "sky=1,1,1", "colormap=viridis", "mode=isosurface",
                           "mode=mip", "mode=back-to-front", "background=0,0,0", "emission-grid=e"})
    EXPECT_TRUE(leaves_open(open)) << open;
  // what says how a medium shines is the colour of a surface, whose lamps stay
  for (const char* colors : {"luminance", "luminance-grid", "temperature-grid"}) {
    Scene given;
    set_parameter(given, "isovalue", "0.5");
    set_parameter(given, colors, colors == std::string("luminance") ? "1,0,0" : "heat");
    EXPECT_TRUE(leaves_look_open(given)) << colors;
    EXPECT_TRUE(leaves_to_look(given, "light")) << colors;
    EXPECT_FALSE(leaves_to_look(given, "luminance")) << colors;
  }
  for (const char* shines : {"luminance=1,1,1", "luminance-grid=l", "temperature-grid=t",
                             "transfer-function=f.json", "mode=slice", "look=plain"})
    EXPECT_FALSE(leaves_open(shines)) << shines;
}

/// The look of a file beside these options, and what it leaves of the scene.
LookedScene beside(const char* file, const std::vector<Setting>& options) {
  Scene scene = scene_of(asset(file));
  apply_over(scene, options);
  return auto_look(scene);
}

TEST(Look, IsWhatOptionsLeave) {
  const Scene smoke = beside("tiles.vdb", {}).scene;
  ASSERT_EQ(smoke.lights.size(), 1u);
  // a light replaces the look's lights, and leaves its faint luminance
  for (const auto& option : {Setting{"sky", "0.2,0.2,0.2"}, {"light", "none"}}) {
    const Scene other = beside("tiles.vdb", {option}).scene;
    EXPECT_TRUE(other.lights.empty()) << option.name;
    EXPECT_EQ(other.luminance, smoke.luminance) << option.name;
    EXPECT_EQ(other.background, smoke.background) << option.name;
  }
  // a background replaces the background alone
  for (const char* color : {"0,0,0", "1,1,1"}) {
    Scene other = beside("tiles.vdb", {{"background", color}}).scene;
    EXPECT_NE(other.background, smoke.background);
    other.background = smoke.background;
    if (std::string(color) == "1,1,1") {  // before white, smoke is dark
      EXPECT_LT(other.albedo.x, 0.5);
      EXPECT_LT(other.luminance->x, smoke.luminance->x);
      other.albedo = smoke.albedo;
      other.luminance = smoke.luminance;
    }
    EXPECT_EQ(to_json(other), to_json(smoke)) << color;
  }
  EXPECT_FALSE(beside("tiles.vdb", {{"background", "none"}}).scene.background);
  // an emission replaces the look's, and leaves the smoke lit
  const LookedScene glows =
      beside("blobs.vdb", {{"emission-grid", "density"}, {"emission-scale", "1"}});
  EXPECT_EQ(glows.look, "fire");
  EXPECT_EQ(glows.scene.emission_scale, 1);
  EXPECT_EQ(glows.scene.emission_color, EmissionColor::white);
  EXPECT_EQ(glows.scene.lights.size(), 1u);
  // a default that is given is no less given
  const Scene front = beside("tiles.vdb", {{"azimuth", "0"}, {"elevation", "0"}}).scene;
  EXPECT_EQ(front.azimuth, 0);
  EXPECT_EQ(front.elevation, 0);
  EXPECT_NE(smoke.azimuth, 0);
  EXPECT_EQ(beside("tiles.vdb", {{"camera-position", "9,9,9"}}).scene.azimuth, 0);
  // these mean a look of their own
  EXPECT_EQ(beside("tiles.vdb", {{"isovalue", "0.5"}}).look, "surface");
  EXPECT_EQ(beside("tiles.vdb", {{"mode", "isosurface"}}).look, "surface");
  // no sky lights a surface
  EXPECT_EQ(beside("tiles.vdb", {{"isovalue", "0.5"}, {"sky", "1,0,0"}}).scene.lights.size(), 2u);
  const LookedScene mapped = beside("blobs.vdb", {{"colormap", "viridis"}});
  EXPECT_EQ(mapped.look, "scan");
  EXPECT_EQ(mapped.scene.colormap, Colormap::viridis);
  EXPECT_FALSE(mapped.scene.lights.empty());
  // what says how the medium shines replaces all sources of a look that is named
  const Scene named = beside("blobs.vdb", {{"look", "fire"}, {"luminance", "0.3,0,0"}}).scene;
  EXPECT_EQ(named.luminance, glm::dvec3(0.3, 0, 0));
  EXPECT_TRUE(named.lights.empty());
  EXPECT_TRUE(named.emission_grid.empty());
  EXPECT_TRUE(named.background);
}

TEST(Look, GoesByTheFilesGrids) {
  EXPECT_EQ(auto_look(scene_of(asset("blobs.vdb"))).look, "fire");
  EXPECT_EQ(auto_look(scene_of(asset("ramp.vdb"))).look, "scan");
  EXPECT_EQ(auto_look(scene_of(asset("single_voxel.vdb"))).look, "smoke");
  for (const auto& [file, look] : {std::pair("smoke.vdb", "smoke"),
                                   {"cloud_tiles.vdb", "smoke"},
                                   {"heptane.vdb", "scan"},
                                   {"mri_t1.vdb", "scan"},
                                   {"carotid.vdb", "scan"},
                                   {"edge/levelset_sphere.vdb", "surface"},
                                   {"edge/velocity_tiles.vdb", "vectors"},
                                   {"edge/torus_density100.vdb", "smoke"}}) {
    const fs::path path = shared_data() / file;
    if (!fs::exists(path)) continue;
    EXPECT_EQ(auto_look(scene_of(path.string())).look, look) << file;
  }
}

TEST(Look, OfARaysIntegralIsBlackBehindIt) {
  Scene scene = scene_of(asset("blobs.vdb"));
  apply_over(scene, std::vector<Setting>{{"mode", "xray"}});
  const LookedScene looked = auto_look(scene);
  EXPECT_EQ(looked.look, "xray");
  EXPECT_EQ(looked.scene.background, glm::dvec3(0));
  EXPECT_EQ(looked.scene.exposure, std::nullopt);
  EXPECT_TRUE(looked.scene.emission_grid.empty());
  // a given exposure stays, whatever its value
  scene.exposure = 0;
  EXPECT_EQ(auto_look(scene).scene.exposure, 0);
  // the look alone sets the mode and its exposure
  Scene other = scene_of(asset("blobs.vdb"));
  other.look = "xray";
  const LookedScene chosen = with_look(other, VolumeFile(other.input));
  EXPECT_EQ(chosen.scene.mode, Mode::xray);
  EXPECT_EQ(chosen.scene.exposure, std::nullopt);
}

TEST(Look, OfMaximaIsBlackBehindThem) {
  for (const char* mode : {"mip", "lmip"}) {
    const LookedScene looked = beside("blobs.vdb", {{"mode", mode}});
    EXPECT_EQ(looked.look, "mip");
    EXPECT_EQ(looked.scene.background, glm::dvec3(0));
    EXPECT_EQ(info(looked.scene.mode).name, std::string(mode));
    EXPECT_EQ(looked.scene.azimuth, 0);
  }
}

TEST(Look, RangeFollowsTheValues) {
  // a ramp has as many high values as low ones
  EXPECT_EQ(parameter_text(auto_look(scene_of(asset("ramp.vdb"))).scene, *find_parameter("range")),
            "2%,96%");
  const fs::path vessels = shared_data() / "carotid.vdb";
  if (!fs::exists(vessels)) return;
  Scene scene = scene_of(vessels.string());
  EXPECT_EQ(parameter_text(auto_look(scene).scene, "range"), "50%,99.5%");
  scene.look = "scan";
  set_parameter(scene, "range", "0.2,0.9");
  EXPECT_EQ(parameter_text(auto_look(scene).scene, "range"), "0.2,0.9");
}

// All light that may reach a point adds up to 1, so that a map's colours are those of the colour
// bar where it does, and darker elsewhere.
TEST(Look, ColoursOfAMapAreReachedAndNotExceeded) {
  for (const char* look : {"scan", "signed", "vectors"}) {
    Scene scene = scene_of(asset("slab.vdb"));
    scene.look = look;
    set_parameter(scene, "colormap", "gray");
    set_parameter(scene, "range", "0,2");
    // where the value is almost 1: colours are those of the value at the point
    set_parameter(scene, "opacity", "0:0,0.49:0,0.5:1");
    set_parameter(scene, "extinction", "100");
    const OpenedScene opened = open_scene(scene, VolumeFile(scene.input));
    const glm::dvec3 all = *opened.looked.scene.luminance + opened.looked.scene.lights.at(0).color;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(all[c], 1, 1e-15) << look;
    const Image image = Session(opened.view).draw(*open_double()).image;
    const auto scale = color_scale(opened.view);
    const double color = scale->colors[scale->colors.size() / 2].x;  // of the slab's value
    float greatest = 0;
    for (std::size_t i = 0; i < image.rgba().size(); i += 4)
      greatest = std::max(greatest, image.rgba()[i]);
    EXPECT_LE(double(greatest), 1.01 * color) << look;
    // A surface returns mu_l / (mu_l + mu_v) of a light by the cosines to light and viewer
    // (Seeliger), 0.4 if the light falls in at most one and a half times as obliquely.
    const Scene& looked = opened.looked.scene;
    const double seen = looked.luminance->x + 0.4 * looked.lights[0].color.x;
    EXPECT_GE(double(greatest), seen * color) << look;
  }
}

TEST(Look, IsTheSameForAnyMethod) {
  for (const char* file : {"blobs.vdb", "ramp.vdb"}) {  // by a draft: fire and scan
    const LookedScene looked = auto_look(scene_of(asset(file)));
    for (const std::vector<Setting>& method :
         {std::vector<Setting>{{"integrator", "cell-exact"}},
          {{"integrator", "psi-weighted"}, {"segments", "4"}},
          {{"sampling", "template"}, {"connectivity", "6"}, {"projection", "orthographic"}}}) {
      Scene scene = scene_of(asset(file));
      apply_over(scene, method);
      const LookedScene other = auto_look(scene);
      EXPECT_EQ(other.look, looked.look) << file;
      if (scene.projection != Projection::orthographic) {
        EXPECT_EQ(other.scene.emission_scale, looked.scene.emission_scale) << file;
        EXPECT_EQ(other.scene.luminance, looked.scene.luminance) << file;
      }
    }
  }
}

TEST(Look, NamesTheGridsThatThePictureDoesNotShow) {
  // without light nothing scatters, so that no colour is an albedo
  Scene scene = scene_of(asset("blobs.vdb"));
  EXPECT_EQ(auto_look(scene).scene.albedo_grid, "color");
  EXPECT_TRUE(auto_look(scene).unused_grids.empty());
  set_parameter(scene, "light", "none");
  EXPECT_EQ(auto_look(scene).scene.albedo_grid, "");
  EXPECT_EQ(auto_look(scene).unused_grids, std::vector<std::string>{"color"});
  EXPECT_EQ(auto_look(scene_of(asset("slab.vdb"))).unused_grids,
            std::vector<std::string>{"density_tiles"});
}

TEST(Look, SetsNothingUnlessAskedTo) {
  Scene scene = scene_of(asset("ramp.vdb"));
  scene.look = "smoke";
  scene.extinction = 2;
  EXPECT_EQ(auto_look(scene).scene.extinction, 2);
  EXPECT_TRUE(with_look(scene, VolumeFile(scene.input)).scene.background);
  EXPECT_FALSE(with_look(scene, VolumeFile(scene.input), "plain", false).scene.background);
  const LookedScene plain = with_look(scene_of(asset("ramp.vdb")), VolumeFile(asset("ramp.vdb")));
  EXPECT_EQ(plain.look, "plain");
  EXPECT_TRUE(plain.settings.empty());
}

/// 1 within 16 voxels of `origin` of its own index space, which `origin` moves back, and 0 beyond
/// 24; `tiles`: blocks of one value are tiles.
std::shared_ptr<const Field> ball(const glm::ivec3& origin, bool tiles) {
  const auto value = [&](const glm::ivec3& voxel) {
    return float(std::clamp(3 - glm::length(glm::dvec3(voxel - origin)) / 8, 0.0, 1.0));
  };
  Field field = make_field({origin - 23, origin + 23}, value,
                           glm::translate(glm::dmat4(1), -glm::dvec3(origin)));
  return share(tiles ? with_tiles(std::move(field)) : std::move(field));
}

/// The scene of a field alone, in its look.
Scene chosen(const std::shared_ptr<const Field>& field) {
  const VolumeFile file(field);
  LookedScene looked = with_look({}, file, "auto");
  return make_view(looked.scene, looked.fields).scene;
}

TEST(Look, OfFlatVoxelsIsDense) {
  // light from above passes along y, on a thousandth of the way
  const auto round = ball({0, 0, 0}, false);
  Field flat = *round;
  flat.world_from_index = glm::scale(glm::dmat4(1), glm::dvec3(1, 1e-3, 1));
  const double dense = *chosen(std::make_shared<const Field>(std::move(flat))).extinction;
  EXPECT_GT(dense, 300 * *chosen(round).extinction);
}

TEST(Look, OfEqualValuesIsEqual) {
  const auto voxels = ball({0, 0, 0}, false), tiles = ball({0, 0, 0}, true);
  ASSERT_FALSE(tiles->tiles.empty());
  EXPECT_EQ(to_json(chosen(tiles)), to_json(chosen(voxels)));
  const Scene moved = chosen(ball({3, 5, 6}, true)), at_rest = chosen(voxels);
  EXPECT_NEAR(*moved.extinction, *at_rest.extinction, 1e-12 * *at_rest.extinction);
  EXPECT_LE(glm::length(*moved.camera_position - *at_rest.camera_position),
            1e-6 * glm::length(*at_rest.camera_position));
}

TEST(Look, StudiosHaveTheirOwn) {
  const auto folder = test::scratch_dir();
  test::write_bytes("ours.json", R"({"luminance": [1, 0, 0]})");
  test::write_bytes("bad.json", R"({"luminence": [1, 0, 0]})");
  test::write_bytes("worse.json", R"({"choose": ["everything"]})");
  ::setenv("PSIVOX_LOOKS", ("/nowhere:" + folder.string()).c_str(), 1);
  Scene scene = scene_of(asset("ramp.vdb"));
  scene.look = "ours";
  EXPECT_EQ(with_look(scene, VolumeFile(scene.input)).scene.luminance, glm::dvec3(1, 0, 0));
  scene.look = (folder / "ours.json").string();
  EXPECT_EQ(with_look(scene, VolumeFile(scene.input)).scene.luminance, glm::dvec3(1, 0, 0));
  const auto refusal = [&](const char* look) {
    scene.look = look;
    return usage_error([&] { with_look(scene, VolumeFile(scene.input)); });
  };
  EXPECT_TRUE(has(refusal("bad"), "luminence"));
  EXPECT_TRUE(has(refusal("worse"), "everything"));
  EXPECT_TRUE(has(refusal("smok"), "smoke"));
  ::unsetenv("PSIVOX_LOOKS");
}

using LookPicture = GpuTest;

TEST_F(LookPicture, OptionsAndJsonGiveTheSamePicture) {
  for (const char* file : {"blobs.vdb", "ramp.vdb", "tiles.vdb"}) {
    const Scene given = scene_of(asset(file));
    const LookedScene looked = auto_look(given);
    const auto picture = [](const Scene& scene) {
      return Session(scene).draw(*Gpu::renderer()).image;
    };
    const Image own = picture(looked.scene);
    Scene again = given;
    for (const Setting& setting : looked.settings) set_parameter(again, setting.name, setting.text);
    EXPECT_EQ(compare_images(own, picture(again)).max, 0) << file;
    EXPECT_EQ(compare_images(own, picture(scene_from_json(to_json(looked.scene)))).max, 0) << file;
  }
}

TEST_F(LookPicture, DefaultPicturesCanBeShown) {
  std::vector<fs::path> files;
  for (const char* file :
       {"blobs.vdb", "ramp.vdb", "rotated.vdb", "single_voxel.vdb", "slab.vdb", "tiles.vdb"})
    files.push_back(asset(file));
  for (const char* file :
       {"smoke.vdb", "cloud_tiles.vdb", "heptane.vdb", "mri_t1.vdb", "frogtissue.vdb", "neghip.vdb",
        "carotid.vdb", "edge/levelset_sphere.vdb", "edge/levelset_unnamed.vdb",
        "edge/torus_density100.vdb", "edge/sphere.vdb", "edge/velocity_tiles.vdb",
        "edge/nan_and_negatives.vdb", "edge/three_same_names.vdb", "edge/cloud_voxelised.vdb",
        "edge/smoke_format222.vdb"})
    if (fs::exists(shared_data() / file)) files.push_back(shared_data() / file);
  for (const fs::path& file : files)
    expect_shown(file.filename().string(), auto_look(scene_of(file.string())));
}

}  // namespace
}  // namespace psivox
