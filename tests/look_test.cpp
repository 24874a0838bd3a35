// Looks: which one a file gets, that its options give the same picture, and that default pictures
// can be shown.

#include "psivox/look.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "look/draft.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/vdb.h"
#include "showing.h"
#include "usage_error.h"

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

LookedScene auto_look(const Scene& scene) { return with_look(scene, VdbFile(scene.input), "auto"); }

TEST(Look, IsOpenUnlessSomethingOfItIsGiven) {
  Scene scene;
  EXPECT_TRUE(leaves_look_open(scene));
  scene.extinction = 2;
  scene.camera_position = glm::dvec3(1);
  scene.tolerance = 1e-3;
  // what cuts a part off, or says which values are shown, does so in any look
  set_parameter(scene, "clip", "0,0,0,1,1,1");
  set_parameter(scene, "clip-plane", "x=3");
  set_parameter(scene, "range", "10%,90%");
  set_parameter(scene, "opacity", "0:0,1:1");
  set_parameter(scene, "isovalue", "0.5");
  EXPECT_TRUE(leaves_look_open(scene));
  for (const auto& [name, text] : {std::pair("luminance", "1,1,1"),
                                   {"light", "0,-1,0"},
                                   {"sky", "1,1,1"},
                                   {"colormap", "viridis"},
                                   {"mode", "mip"},
                                   {"background", "0,0,0"},
                                   {"look", "plain"},
                                   {"temperature-grid", "t"},
                                   {"emission-grid", "e"},
                                   {"transfer-function", "f.json"}}) {
    Scene given = scene;
    set_parameter(given, name, text);
    EXPECT_FALSE(leaves_look_open(given)) << name;
  }
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
  const LookedScene chosen = with_look(other, VdbFile(other.input));
  EXPECT_EQ(chosen.scene.mode, Mode::xray);
  EXPECT_EQ(chosen.scene.exposure, std::nullopt);
}

TEST(Look, RangeFollowsTheValues) {
  // a ramp has as many high values as low ones
  EXPECT_EQ(parameter_text(auto_look(scene_of(asset("ramp.vdb"))).scene, *find_parameter("range")),
            "2%,96%");
  const fs::path vessels = shared_data() / "carotid.vdb";
  if (!fs::exists(vessels)) return;
  Scene scene = scene_of(vessels.string());
  EXPECT_EQ(parameter_text(auto_look(scene).scene, *find_parameter("range")), "50%,99.5%");
  scene.look = "scan";
  set_parameter(scene, "range", "0.2,0.9");
  EXPECT_EQ(parameter_text(auto_look(scene).scene, *find_parameter("range")), "0.2,0.9");
}

TEST(Look, DraftByRaysIsAsBrightAsThePicture) {
  Scene scene = scene_of(asset("blobs.vdb"));
  scene.grid = "density";
  set_parameter(scene, "light", "camera:0.8,-1,-0.7");
  set_parameter(scene, "luminance", "0.3,0.3,0.3");
  set_parameter(scene, "colormap", "inferno");
  const MediumFields fields = read_fields(scene, VdbFile(scene.input));
  double whole = 0;
  for (const auto& [plane, part] : {std::pair("none", 1.0), {"x=0", 0.5}, {"-z=0.2", 1.0}}) {
    set_parameter(scene, "clip-plane", plane);
    const Draft drawn = make_draft(scene, fields);
    const std::optional<Draft> by_rays = ray_draft(make_view(scene, fields));
    ASSERT_TRUE(by_rays);
    // steps of a voxel instead of two, and about 300 pixels instead of 700, or this part of them
    const double near = 0.05 / std::sqrt(part);
    EXPECT_NEAR(by_rays->mean_luminance() / drawn.mean_luminance(), 1, near) << plane;
    EXPECT_NEAR(by_rays->level(0.03) / drawn.level(0.03), 1, near) << plane;
    if (scene.clip_plane) {  // what is cut off makes a difference
      EXPECT_GT(std::abs(by_rays->mean_luminance() / whole - 1), 0.02) << plane;
    } else {
      whole = by_rays->mean_luminance();
    }
  }
  set_parameter(scene, "sky", "1,1,1");
  EXPECT_FALSE(ray_draft(make_view(scene, fields)));
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
  EXPECT_EQ(auto_look(scene_of(asset("blobs.vdb"))).unused_grids,
            std::vector<std::string>{"color"});
  EXPECT_EQ(auto_look(scene_of(asset("slab.vdb"))).unused_grids,
            std::vector<std::string>{"density_tiles"});
}

TEST(Look, WhatIsGivenCounts) {
  Scene scene = scene_of(asset("ramp.vdb"));
  scene.look = "smoke";
  scene.luminance = glm::dvec3(0.3);
  scene.extinction = 2;
  const LookedScene looked = with_look(scene, VdbFile(scene.input));
  EXPECT_EQ(looked.look, "smoke");
  EXPECT_EQ(looked.scene.luminance, glm::dvec3(0.3));
  EXPECT_EQ(looked.scene.extinction, 2);
  EXPECT_EQ(looked.scene.lights.size(), 1u);
  EXPECT_TRUE(looked.scene.background);
  EXPECT_FALSE(with_look(scene, VdbFile(scene.input), "plain", false).scene.background);
  // without a look, nothing is set
  const LookedScene plain = with_look(scene_of(asset("ramp.vdb")), VdbFile(asset("ramp.vdb")));
  EXPECT_EQ(plain.look, "plain");
  EXPECT_TRUE(plain.settings.empty());
}

TEST(Look, StudiosHaveTheirOwn) {
  const fs::path folder = fs::path(testing::TempDir()) / "psivox_looks";
  fs::create_directories(folder);
  std::ofstream(folder / "ours.json") << R"({"luminance": [1, 0, 0]})";
  std::ofstream(folder / "bad.json") << R"({"luminence": [1, 0, 0]})";
  std::ofstream(folder / "worse.json") << R"({"choose": ["everything"]})";
  ::setenv("PSIVOX_LOOKS", ("/nowhere:" + folder.string()).c_str(), 1);
  Scene scene = scene_of(asset("ramp.vdb"));
  scene.look = "ours";
  EXPECT_EQ(with_look(scene, VdbFile(scene.input)).scene.luminance, glm::dvec3(1, 0, 0));
  scene.look = (folder / "ours.json").string();
  EXPECT_EQ(with_look(scene, VdbFile(scene.input)).scene.luminance, glm::dvec3(1, 0, 0));
  const auto refusal = [&](const char* look) {
    scene.look = look;
    return usage_error([&] { with_look(scene, VdbFile(scene.input)); });
  };
  EXPECT_NE(refusal("bad").find("luminence"), std::string::npos);
  EXPECT_NE(refusal("worse").find("everything"), std::string::npos);
  EXPECT_NE(refusal("smok").find("smoke"), std::string::npos);
  ::unsetenv("PSIVOX_LOOKS");
  fs::remove_all(folder);
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
