// The viewer's files: it saves the pictures that `psivox render` draws, and reloads files that
// change.

#include <gtest/gtest.h>

#include <filesystem>

#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/text_file.h"
#include "psivox/image.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "scene/camera_file.h"
#include "scratch.h"
#include "thrown.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

TEST(ViewerFiles, ReadsAChangedFileAgain) {
  const fs::path file = fs::path(testing::TempDir()) / "psivox_watched.vdb";
  fs::copy_file(asset("slab.vdb"), file, fs::copy_options::overwrite_existing);
  Opened hands(small(file.string()), false, true);
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
  Opened hands(scene);
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
  Scene scene = small(asset("blobs.vdb"), {900, 600});
  ASSERT_TRUE(leaves_method_open(scene));  // uses the default tolerance
  Opened hands(scene);
  const glm::dvec2 from = hands.edit().place_of(1).value();
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
  Scene scene = small(asset("slab.vdb"), {400, 420});  // room for the panel
  Opened hands(scene);
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
  Opened hands(small(asset("blobs.vdb")));
  hands.click({60, 44});  // the section of files
  const std::uint64_t wished = hands.viewer.pictures().wished;
  hands.click({60, 107});  // its button
  ASSERT_TRUE(hands.until_exact());
  EXPECT_GT(hands.viewer.pictures().wished, wished);
}

// --- sequences -----------------------------------------------------------------------------------

/// A folder of frames, copied from assets.
class Frames {
 public:
  Frames(const char* name, const std::vector<std::string>& sources)
      : folder_(fs::path(testing::TempDir()) / name) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    for (std::size_t i = 0; i < sources.size(); ++i)
      fs::copy_file(asset(sources[i]), file(int(i) + 1));
  }
  ~Frames() { fs::remove_all(folder_); }
  std::string file(int frame) const { return path("f_" + std::to_string(frame) + ".vdb"); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  fs::path folder_;
};

/// What is constant in a sequence, but for lights, which the window turns into the world's. The
/// method is chosen for each picture.
std::string constant_part(Scene scene) {
  scene.input.clear();
  scene.lights.clear();
  for (const Parameter& p : parameters())
    if (p.group == ParameterGroup::accuracy) set_default(scene, p);
  return to_json(scene);
}

::testing::AssertionResult shows(Hands& hands, const std::string& file) {
  return hands.until([&] {
    return hands.viewer.volume() && hands.viewer.volume()->scene.input == file &&
           !hands.viewer.loading() && hands.viewer.exact_picture();
  });
}

TEST(ViewerSequence, FramesOfASequenceFollowEachOther) {
  const fs::path folder = test::empty_scratch_dir();
  const char* names[] = {"slab.vdb", "tiles.vdb", "ramp.vdb"};
  const int numbers[] = {1, 2, 4};
  for (int i = 0; i < 3; ++i)
    fs::copy_file(asset(names[i]), folder / ("f_" + std::to_string(numbers[i]) + ".vdb"));
  Opened hands(small((folder / "f_#.vdb").string()));
  EXPECT_EQ(hands.viewer.scene().input, (folder / "f_1.vdb").string());
  hands.key(GLFW_KEY_LEFT);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.scene().input, (folder / "f_4.vdb").string());
  hands.key(GLFW_KEY_SPACE);
  ASSERT_TRUE(hands.until(
      [&] { return hands.viewer.volume()->scene.input == (folder / "f_2.vdb").string(); }));
  hands.key(GLFW_KEY_SPACE);
  ASSERT_TRUE(hands.until_exact());
}

TEST(ViewerSequence, WhatAutoChoosesIsChosenOnceAndABadFrameIsPassed) {
  const Frames frames("psivox_frozen", {"blobs.vdb", "shells.json", "slab.vdb", "blobs.vdb"});
  const Scene start = open_look(frames.path("f_#.vdb"));
  Hands hands(start);
  ASSERT_TRUE(shows(hands, frames.file(1)));
  EXPECT_EQ(hands.viewer.look().text(), "auto: fire");
  EXPECT_TRUE(has(hands.viewer.messages().shown(), "look fire, chosen by auto from 3 frames: "));
  // as render chooses it
  Scene asked = start;
  asked.look = "auto";
  const std::vector<std::string> samples{frames.file(1), frames.file(3), frames.file(4)};
  Scene chosen = resolve_sequence(asked, samples).scene;
  chosen.look = "plain";
  const std::string constant = constant_part(hands.viewer.scene());
  EXPECT_EQ(constant, constant_part(chosen));
  EXPECT_TRUE(leaves_method_open(hands.viewer.scene()));

  // a frame that cannot be read: the last one stays
  hands.key(GLFW_KEY_RIGHT);
  ASSERT_TRUE(hands.until_error());
  EXPECT_TRUE(has(hands.viewer.messages().last_error(), "f_2.vdb"));
  hands.frames(5);
  EXPECT_EQ(hands.viewer.volume()->scene.input, frames.file(1));
  EXPECT_EQ(hands.viewer.sequence().current(), 2);

  // a frame without the flame's grid
  hands.key(GLFW_KEY_RIGHT);
  ASSERT_TRUE(shows(hands, frames.file(3)));
  EXPECT_EQ(constant_part(hands.viewer.scene()), constant);
  Scene smoke = hands.viewer.scene();
  smoke.emission_grid.clear();
  // The window may keep other light than a fresh session chooses; each is within the tolerance.
  EXPECT_LE(compare_images(*hands.viewer.exact_picture(), rendered(smoke)).rms,
            2 * default_tolerance);

  // played: it goes on behind the last frame, and past the bad one
  hands.key(GLFW_KEY_SPACE);
  const auto plays = [&](int frame) {
    return hands.until([&] { return hands.viewer.volume()->scene.input == frames.file(frame); });
  };
  ASSERT_TRUE(plays(4));
  ASSERT_TRUE(plays(1));
  ASSERT_TRUE(plays(3));
  hands.key(GLFW_KEY_SPACE);
  EXPECT_EQ(constant_part(hands.viewer.scene()), constant);
}

TEST(ViewerSequence, OpensThoughItsLastFrameIsUnreadable) {
  const Frames frames("psivox_bad_end", {"blobs.vdb", "slab.vdb", "shells.json"});
  Hands hands(open_look(frames.path("f_#.vdb")));
  ASSERT_TRUE(shows(hands, frames.file(1)));
  EXPECT_EQ(hands.viewer.look().text(), "auto: fire");
}

TEST(ViewerSequence, WhatAFileWasShownWithCountsForTheFilesBesideIt) {
  const Frames frames("psivox_beside", {"blobs.vdb", "ramp.vdb"});
  Hands hands(small(frames.file(1)));
  ASSERT_TRUE(shows(hands, frames.file(1)));
  EXPECT_FALSE(hands.viewer.scene().extinction);  // as render draws the file alone
  const double extinction = hands.viewer.volume()->extinction;
  hands.key(GLFW_KEY_RIGHT);
  ASSERT_TRUE(shows(hands, frames.file(2)));
  EXPECT_EQ(hands.viewer.scene().extinction, extinction);
  expect_same(*hands.viewer.exact_picture(), rendered(hands.viewer.scene()));
  // another file has a choice of its own
  hands.drop(asset("slab.vdb"));
  ASSERT_TRUE(shows(hands, asset("slab.vdb")));
  EXPECT_FALSE(hands.viewer.scene().extinction);
}

TEST(ViewerSequence, SeveralFilesThatAreDroppedAreOne) {
  Opened hands(small(asset("slab.vdb")));
  EXPECT_TRUE(hands.viewer.sequence().empty());
  hands.post({Kind::drop, {}, 0, false, 0, {asset("ramp.vdb"), asset("tiles.vdb")}});
  ASSERT_TRUE(shows(hands, asset("ramp.vdb")));
  EXPECT_EQ(hands.viewer.sequence().last(), 2);
  hands.key(GLFW_KEY_LEFT);
  ASSERT_TRUE(shows(hands, asset("tiles.vdb")));
}

}  // namespace
}  // namespace psivox::view
