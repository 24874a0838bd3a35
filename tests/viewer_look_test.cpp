// The window's looks, slices and clips.

#include <gtest/gtest.h>
#include <filesystem>

#include <cstdlib>

#include "base/text_file.h"
#include "psivox/image.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "scratch.h"
#include "thrown.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

/// What `auto` chooses for the scene's file; lights are left out, which the window turns into the
/// world's.
Scene auto_scene(Scene scene) {
  scene.look = "auto";
  scene = with_look(scene, VolumeFile(scene.input)).scene;
  scene.lights.clear();
  return scene;
}

Scene without_lights(Scene scene) {
  scene.lights.clear();
  return scene;
}

TEST(ViewerLook, OpenedAndDroppedFilesGetTheLookAuto) {
  const Scene start = open_look(asset("blobs.vdb"));
  Opened hands(start);
  EXPECT_TRUE(has(hands.viewer.messages().shown(), "look fire, chosen by auto: --background="));
  EXPECT_EQ(hands.viewer.look().text(), "auto: fire");
  EXPECT_EQ(to_json(without_lights(hands.viewer.scene())), to_json(auto_scene(start)));
  ASSERT_EQ(hands.viewer.scene().lights.size(), 1u);
  EXPECT_FALSE(hands.viewer.scene().lights[0].of_camera);
  // The window may keep other light than a fresh session chooses; each is within the tolerance.
  EXPECT_LE(compare_images(*hands.viewer.exact_picture(), rendered(hands.viewer.scene())).rms,
            2 * default_tolerance);

  hands.drop(asset("ramp.vdb"));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "auto: scan");
  EXPECT_EQ(to_json(without_lights(hands.viewer.scene())),
            to_json(auto_scene(open_look(asset("ramp.vdb")))));
}

TEST(ViewerLook, AStartWithoutALookGivesNoneToDroppedFiles) {
  Scene scene = open_look(asset("ramp.vdb"));
  scene.luminance = glm::dvec3(0.3, 0, 0);
  Opened hands(scene);
  hands.drop(asset("slab.vdb"));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "plain");
  EXPECT_EQ(hands.viewer.scene().luminance, glm::dvec3(0.3, 0, 0));
  EXPECT_TRUE(hands.viewer.scene().lights.empty());
}

TEST(ViewerLook, AChosenLookReplacesTheLookAndKeepsTheCamera) {
  Opened hands(open_look(asset("blobs.vdb")));
  hands.drag({400, 200}, {460, 220});
  ASSERT_TRUE(hands.until_exact());
  const Scene before = hands.viewer.scene();
  ASSERT_FALSE(before.emission_grid.empty());
  hands.viewer.choose_look("smoke");
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  Scene after = hands.viewer.scene();
  EXPECT_EQ(hands.viewer.look().text(), "smoke");
  EXPECT_TRUE(after.emission_grid.empty());
  EXPECT_EQ(after.luminance, glm::dvec3(0.07, 0.085, 0.115));
  EXPECT_EQ(after.camera_position, before.camera_position);
  EXPECT_EQ(after.camera_target, before.camera_target);
  // render draws it without the background, before which the window chose its step: each keeps the
  // tolerance
  EXPECT_LE(compare_images(*hands.viewer.exact_picture(), rendered(after)).rms,
            2 * default_tolerance);

  // what is changed afterwards stays
  after.luminance = glm::dvec3(0.3);
  after.background = glm::dvec3(0.1);
  hands.viewer.set_scene(after);
  ASSERT_TRUE(hands.until_exact());
  hands.viewer.reload();
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.scene().luminance, glm::dvec3(0.3));
  EXPECT_EQ(hands.viewer.scene().background, glm::dvec3(0.1));

  hands.viewer.choose_look("plain");
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  const Scene plain = hands.viewer.scene();
  EXPECT_TRUE(plain.lights.empty());
  EXPECT_FALSE(plain.luminance);
  EXPECT_FALSE(plain.background);
  EXPECT_FALSE(plain.extinction);
  EXPECT_EQ(plain.camera_position, before.camera_position);
}

TEST(ViewerLook, AnotherColourMapIsDrawnAsRenderDrawsItAndIsUndone) {
  const Scene start = open_look(asset("blobs.vdb"));
  Opened hands(start);
  const Scene before = hands.viewer.scene();
  Scene mapped = before;
  apply_over(mapped, std::vector<Setting>{{"colormap", "viridis"}});
  hands.viewer.set_scene(mapped);
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "auto: scan");
  Scene asked = start;
  asked.colormap = Colormap::viridis;
  EXPECT_EQ(to_json(without_lights(hands.viewer.scene())), to_json(auto_scene(asked)));
  hands.key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "auto: fire");
  EXPECT_EQ(to_json(hands.viewer.scene()), to_json(before));
}

TEST(ViewerLook, TheMenuHasTheLooksOfAStudio) {
  const fs::path folder = test::scratch_dir();
  write_text((folder / "amber.json").string(), R"({"luminance": [1, 0.6, 0.1]})");
  write_text((folder / "broken.json").string(), R"({"luminance": "bright"})");
  setenv("PSIVOX_LOOKS", folder.c_str(), 1);
  const std::vector<std::string> expected{"amber", "broken",  "colors",  "fire", "labels",
                                          "mip",   "plain",   "points",  "scan", "signed",
                                          "smoke", "surface", "vectors", "xray"};
  EXPECT_EQ(available_looks(), expected);
  Opened hands(open_look(asset("slab.vdb")));
  const Scene before = hands.viewer.scene();
  hands.click({100, 67});  // the menu
  hands.frames(3);
  hands.click({60, 113});  // its second row, after auto
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "amber");
  EXPECT_EQ(hands.viewer.scene().luminance, glm::dvec3(1, 0.6, 0.1));
  const Scene amber = hands.viewer.scene();
  // a look that cannot be read changes nothing
  hands.viewer.choose_look("broken");
  ASSERT_TRUE(hands.until_error());
  EXPECT_TRUE(has(hands.viewer.messages().last_error(), "broken.json"));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.look().text(), "amber");
  EXPECT_EQ(to_json(hands.viewer.scene()), to_json(amber));
  unsetenv("PSIVOX_LOOKS");
}

TEST(ViewerLook, SmokeIsDarkBeforeAWhiteBackground) {
  Scene start = open_look(asset("blobs.vdb"));
  start.look = "smoke";
  Opened hands(start);
  const Scene before = hands.viewer.scene();
  Scene white = before;
  set_parameter(white, "background", "white");
  hands.viewer.set_scene(white);
  ASSERT_TRUE(hands.until([&] { return hands.viewer.scene().albedo != before.albedo; }));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.scene().albedo, dark_contrast * before.albedo);
  set_parameter(white = hands.viewer.scene(), "background", "black");
  hands.viewer.set_scene(white);
  ASSERT_TRUE(hands.until([&] { return hands.viewer.scene().albedo == before.albedo; }));
}

TEST(ViewerLook, TheModeXrayShowsItsDensestRaysJustBelowWhite) {
  Scene scene = open_look(asset("blobs.vdb"));
  apply_over(scene, std::vector<Setting>{{"mode", "xray"}});
  Opened hands(scene);
  EXPECT_EQ(hands.viewer.look().text(), "auto: xray");
  EXPECT_LT(hands.viewer.exposure(), -1);
  // an exposure of 0 has to be said
  scene = hands.viewer.scene();
  scene.exposure = 0;
  const std::vector<std::string> words = render_arguments(scene, "a.png");
  EXPECT_EQ(std::ranges::count(words, "--exposure=0"), 1);
  scene.exposure.reset();
  EXPECT_EQ(std::ranges::count(render_arguments(scene, "a.png"), "--exposure=auto"), 1);
}

/// A window with its panel scrolled to the controls of slice and clip.
Scene cut_scene(Mode mode) {
  Scene scene = small(asset("blobs.vdb"), {900, 640});
  scene.mode = mode;
  return scene;
}

TEST(ViewerCuts, ASliceFollowsItsSliderAndTheCameraFacesIt) {
  Opened hands(cut_scene(Mode::slice));
  const Volume* volume = hands.viewer.volume();
  const std::uint64_t wished = hands.viewer.pictures().wished;
  Scene scene = hands.viewer.scene();
  ASSERT_FALSE(scene.slice);
  hands.press({117, 274});  // the slider of its place
  for (int i = 1; i <= 3; ++i) {
    hands.move({117 + 10 * i, 274});
    ASSERT_TRUE(hands.until([&] {
      const PictureState& pictures = hands.viewer.pictures();
      return pictures.wished >= wished + std::uint64_t(i) && pictures.shown == pictures.wished;
    }));
  }
  hands.release({147, 274});
  ASSERT_TRUE(hands.until_exact());
  scene = hands.viewer.scene();
  ASSERT_TRUE(scene.slice && scene.slice->point);
  EXPECT_EQ(scene.slice->normal, glm::dvec3(0, 0, 1));
  EXPECT_EQ(hands.viewer.volume(), volume);  // nothing is converted again
  expect_same(*hands.viewer.exact_picture(), rendered(scene));
  // another axis: the camera, which was never moved, faces the plane
  scene.slice = Plane{{1, 0, 0}};
  hands.viewer.set_scene(scene);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_NEAR(std::abs(hands.viewer.navigation().forward().x), 1, 1e-12);
}

TEST(ViewerCuts, BoxAndPlaneFollowTheirSliders) {
  Opened hands(cut_scene(Mode::alpha));
  const Volume* volume = hands.viewer.volume();
  const Subject& subject = *volume->subject;
  hands.click({100, 228});  // unfolds the section
  hands.click({27, 251});   // clip box
  ASSERT_TRUE(hands.viewer.scene().clip);
  EXPECT_EQ(hands.viewer.scene().clip->min, subject.box_min);
  EXPECT_EQ(hands.viewer.scene().clip->max, subject.box_max);
  hands.drag({210, 274}, {117, 274});  // the upper end along x
  hands.drag({23, 297}, {60, 297});    // the lower end along y
  ASSERT_TRUE(hands.until_exact());
  const WorldBox box = *hands.viewer.scene().clip;
  const glm::dvec3 size = subject.box_max - subject.box_min;
  // one pixel of the slider is a 190th of its range
  EXPECT_NEAR(box.max.x, subject.box_max.x - 93.0 / 188 * size.x, 0.02 * size.x);
  EXPECT_NEAR(box.min.y, subject.box_min.y + 37.0 / 188 * size.y, 0.02 * size.y);
  EXPECT_EQ(box.min.x, subject.box_min.x);
  EXPECT_EQ(box.max.y, subject.box_max.y);
  EXPECT_EQ(hands.viewer.volume(), volume);  // nothing is converted again
  expect_same(*hands.viewer.exact_picture(), rendered(hands.viewer.scene()));
  hands.drag({70, 274}, {90, 274});  // the bar between the ends
  const WorldBox shifted = *hands.viewer.scene().clip;
  EXPECT_GT(shifted.min.x, box.min.x);
  EXPECT_NEAR(shifted.max.x - shifted.min.x, box.max.x - box.min.x, 0.002 * size.x);
  hands.click({27, 251});
  EXPECT_FALSE(hands.viewer.scene().clip);

  hands.click({27, 274});  // clip plane, now below
  ASSERT_TRUE(hands.viewer.scene().clip_plane);
  EXPECT_EQ(hands.viewer.scene().clip_plane->normal, glm::dvec3(1, 0, 0));
  const double middle = hands.viewer.scene().clip_plane->point->x;
  hands.drag({117, 320}, {140, 320});
  EXPECT_GT(hands.viewer.scene().clip_plane->point->x, middle);
  ASSERT_TRUE(hands.until_exact());
  hands.click({50, 343});  // other side
  EXPECT_EQ(hands.viewer.scene().clip_plane->normal, glm::dvec3(-1, 0, 0));
  hands.expect_rendered();
}

}  // namespace
}  // namespace psivox::view
