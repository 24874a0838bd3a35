// The viewer's files: it saves the pictures that `psivox render` draws, and reloads files that
// change.

#include <gtest/gtest.h>
#include <filesystem>

#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/text_file.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "scene/camera_file.h"
#include "scratch.h"
#include "thrown.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

TEST(ViewerFiles, ReadsAChangedFileAgain) {
  const fs::path file = fs::path(testing::TempDir()) / "psivox_watched.vdb";
  fs::copy_file(asset("slab.vdb"), file, fs::copy_options::overwrite_existing);
  Hands hands(small(file.string()), false, true);
  ASSERT_TRUE(hands.until_exact());
  const Volume* before = hands.viewer.volume();
  hands.frames(80);
  EXPECT_EQ(hands.viewer.volume(), before);
  fs::copy_file(asset("tiles.vdb"), file, fs::copy_options::overwrite_existing);
  ASSERT_TRUE(hands.until([&] { return hands.viewer.volume() != before; }));
  hands.expect_rendered();
  fs::remove(file);
}

TEST(ViewerFiles, TheSavedPictureIsThatOfTheCopiedCommandLine) {
  const fs::path folder = test::empty_scratch_dir();
  Scene scene = small(asset("blobs.vdb"));
  scene.lights = {{{0.5, -1, -0.6}, {2, 2, 2}}};
  scene.background = glm::dvec3(0.1, 0.2, 0.3);
  Hands hands(scene);
  ASSERT_TRUE(hands.until_exact());
  hands.key(GLFW_KEY_TAB);
  hands.drag({200, 200}, {263, 171});
  ASSERT_TRUE(hands.until_exact());
  const std::string saved = (folder / "saved.exr").string();
  hands.viewer.save_picture(saved);
  ASSERT_TRUE(hands.until([&] { return !hands.viewer.saving(); }));

  std::string line = hands.viewer.copy_command_line();
  ASSERT_TRUE(line.starts_with("psivox "));
  line = PSIVOX_PROGRAM + line.substr(6) + " 2> /dev/null";
  ASSERT_EQ(std::system(("cd '" + folder.string() + "' && " + line).c_str()), 0) << line;
  expect_same(read_image(saved), read_image(folder / "picture.exr"));

  // the window's picture is the same before its background is put behind it
  const Scene alone = hands.viewer.scene();
  Image drawn = *hands.viewer.exact_picture();
  add_background(drawn, alone.background->color, {});
  expect_same(drawn, read_image(saved));
  hands.viewer.save_scene((folder / "scene.json").string());
  const Scene read = scene_from_json(read_text((folder / "scene.json").string(), "scene"));
  EXPECT_EQ(to_json(read), to_json(alone));
  hands.viewer.save_scene((folder / "camera.gltf").string());
  const FileCamera camera = read_camera((folder / "camera.gltf").string(), false);
  ASSERT_TRUE(alone.camera_position);
  EXPECT_LE(glm::length(camera.position - *alone.camera_position), 1e-9);
}

TEST(ViewerFiles, TheCopiedCommandLineHasTheEditedTransferFunction) {
  const fs::path folder = test::empty_scratch_dir();
  const fs::path before = fs::current_path();
  fs::current_path(folder);  // the function is saved here
  Scene scene = small(asset("blobs.vdb"));
  scene.resolution = {900, 600};
  ASSERT_TRUE(leaves_method_open(scene));  // uses the default tolerance
  Hands hands(scene);
  ASSERT_TRUE(hands.until_exact());
  hands.viewer.panels().transfer = true;
  hands.frames(4);
  const glm::dvec2 from = hands.viewer.transfer_editor().place_of(1).value();
  hands.drag(from, from + glm::dvec2(40, -30));
  ASSERT_TRUE(hands.until_exact());
  const Image shown = *hands.viewer.exact_picture();
  hands.viewer.save_picture("saved.exr");
  ASSERT_TRUE(hands.until([&] { return !hands.viewer.saving(); }));
  std::string line = hands.viewer.copy_command_line();
  EXPECT_TRUE(has(line, "--transfer-function=transfer.json"));
  line = PSIVOX_PROGRAM + line.substr(6) + " 2> /dev/null";
  ASSERT_EQ(std::system(line.c_str()), 0) << line;
  expect_same(read_image("saved.exr"), read_image("picture.exr"));
  expect_same(shown, read_image("picture.exr"));
  ASSERT_TRUE(hands.until_exact());  // uses the saved function, which is the same
  expect_same(*hands.viewer.exact_picture(), shown);

  // what was saved opens again, with its file
  hands.viewer.save_scene("saved.json");
  for (const char* saved : {"saved.exr", "saved.json"}) {
    hands.drop(asset("slab.vdb"));
    ASSERT_TRUE(hands.until([&] { return hands.viewer.input() == asset("slab.vdb"); }));
    ASSERT_TRUE(hands.until_exact());
    hands.drop((folder / saved).string());
    ASSERT_TRUE(hands.until([&] { return hands.viewer.input() != asset("slab.vdb"); }));
    ASSERT_TRUE(hands.until_exact());
    expect_same(*hands.viewer.exact_picture(), shown);
  }
  fs::current_path(before);
}

TEST(ViewerFiles, ASizeThatIsNoneIsSaidAndHarmsNothing) {
  Scene scene = small(asset("slab.vdb"));
  scene.resolution = {400, 420};  // room for the panel
  Hands hands(scene);
  ASSERT_TRUE(hands.until_exact());
  hands.click({120, 323});  // the field `size`
  hands.type("abc");
  hands.click({90, 346});  // `copy as command line`
  EXPECT_EQ(hands.viewer.messages().error_count(), 1);
  EXPECT_TRUE(has(hands.viewer.messages().last_error(), "abc"));
  hands.key(GLFW_KEY_S, GLFW_MOD_CONTROL);
  hands.key(GLFW_KEY_C, GLFW_MOD_CONTROL);
  EXPECT_EQ(hands.viewer.messages().error_count(), 3);
  hands.errors = 3;
  EXPECT_FALSE(hands.viewer.saving());
  ASSERT_TRUE(hands.until_exact());
}

// The program that draws the window's picture is replaced while the panel is drawn.
TEST(ViewerFiles, TheReloadButtonLeavesOpenGlInOrder) {
  Hands hands(small(asset("blobs.vdb")));
  ASSERT_TRUE(hands.until_exact());
  hands.click({60, 44});  // the section of files
  const std::uint64_t wished = hands.viewer.pictures().wished;
  hands.click({60, 107});  // its button
  ASSERT_TRUE(hands.until_exact());
  EXPECT_GT(hands.viewer.pictures().wished, wished);
}

}  // namespace
}  // namespace psivox::view
