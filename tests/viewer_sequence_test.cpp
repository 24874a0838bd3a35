// Sequences in the window.

#include <gtest/gtest.h>
#include <filesystem>

#include "psivox/image.h"
#include "psivox/parameters.h"
#include "psivox/sequence.h"
#include "scratch.h"
#include "thrown.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

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
  Hands hands(small((folder / "f_#.vdb").string()));
  ASSERT_TRUE(hands.until_exact());
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
  Hands hands(small(asset("slab.vdb")));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_TRUE(hands.viewer.sequence().empty());
  hands.post({Kind::drop, {}, 0, false, 0, {asset("ramp.vdb"), asset("tiles.vdb")}});
  ASSERT_TRUE(shows(hands, asset("ramp.vdb")));
  EXPECT_EQ(hands.viewer.sequence().last(), 2);
  hands.key(GLFW_KEY_LEFT);
  ASSERT_TRUE(shows(hands, asset("tiles.vdb")));
}

}  // namespace
}  // namespace psivox::view
