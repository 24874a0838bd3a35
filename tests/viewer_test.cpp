// The viewer in a real window, driven by synthetic events. `psivox view` needs a display:
// with_display.sh provides one.

#include "view/viewer.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "base/text_file.h"
#include "ocio_config.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "thrown.h"
#include "view/benchmark.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

/// Once with the window system's own contexts, and once with EGL.
class Window_ : public ::testing::TestWithParam<bool> {};

TEST_P(Window_, RefinesToThePictureOfRender) {
  Hands hands(small(asset("blobs.vdb")), GetParam());
  hands.expect_rendered();
}

TEST(Viewer, ShowsAViewOfOcioAsRenderWritesIt) {
  Scene scene = small(asset("blobs.vdb"));
  scene.background = glm::dvec3(0.2, 0.5, 0.9);
  scene.exposure = 0.5;
  scene.ocio = testing::TempDir() + "/config.ocio";
  write_ocio_config(scene.ocio);
  for (const char* const view : {"Plain", "Warm"}) {
    scene.ocio_view = view;
    Scene resolved = scene;
    resolve_ocio(resolved);
    Hands hands(resolved);
    hands.key(GLFW_KEY_TAB);
    ASSERT_TRUE(hands.until_exact());
    hands.frames(4);
    const std::string window = testing::TempDir() + "/window.png",
                      file = testing::TempDir() + "/file.png";
    hands.viewer.photograph(window);
    hands.frames(4);
    render_by_program({asset("blobs.vdb"), "--quiet", "--look=plain", "--resolution=480x360",
                       "--background=0.2,0.5,0.9", "--exposure=0.5", "--ocio=" + scene.ocio,
                       std::string("--ocio-view=") + view, "-o", file});
    const auto shown = srgb_bytes(read_image(window), {}),
               written = srgb_bytes(read_image(file), {});
    ASSERT_EQ(shown.size(), written.size());
    int most = 0;
    for (std::size_t i = 0; i < shown.size() / 360 * 310; ++i)  // below stands a message
      most = std::max(most, std::abs(int(shown[i]) - int(written[i])));
    EXPECT_EQ(most, 0) << view;
  }
}

TEST_P(Window_, ANoisyHandHarmsNothing) {
  Opened hands(small(asset("blobs.vdb")), GetParam());
  hands.key(GLFW_KEY_TAB);
  const Scene before = hands.viewer.scene();
  hands.drag({200, 200}, {290, 160});
  hands.drag({200, 200}, {190, 160}, GLFW_MOUSE_BUTTON_MIDDLE);
  hands.post({Kind::wheel, {0, 2}});
  for (const int code : {GLFW_KEY_F, GLFW_KEY_1, GLFW_KEY_3, GLFW_KEY_7, GLFW_KEY_O, GLFW_KEY_T,
                         GLFW_KEY_X, GLFW_KEY_X, GLFW_KEY_X, GLFW_KEY_H, GLFW_KEY_H, GLFW_KEY_T})
    hands.key(code);
  hands.key(GLFW_KEY_3, GLFW_MOD_SHIFT);
  hands.post({Kind::key, {}, GLFW_KEY_W, true});
  hands.frames(5);
  hands.post({Kind::key, {}, GLFW_KEY_W, false});
  hands.drag({250, 150}, {200, 190});
  ASSERT_TRUE(hands.until_exact());
  const Scene after = hands.viewer.scene();
  EXPECT_NE(to_json(before), to_json(after));
  EXPECT_EQ(after.projection, Projection::orthographic);
  expect_same(*hands.viewer.exact_picture(), rendered(after));
}

TEST_P(Window_, SurvivesOnePixelAndBack) {
  Opened hands(small(asset("slab.vdb")), GetParam());
  hands.viewer.window().resize({1, 1});
  ASSERT_TRUE(hands.until([&] { return hands.viewer.window().size() == glm::ivec2(1, 1); }));
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  hands.viewer.window().resize({300, 200});
  ASSERT_TRUE(hands.until([&] { return hands.viewer.window().size() == glm::ivec2(300, 200); }));
  hands.frames(2);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.exact_picture()->width, 300);
}

TEST_P(Window_, ClosesWhileItLoads) {
  for (const int frames : {0, 1, 3, 10}) {
    Hands hands(small(asset("blobs.vdb")), GetParam());
    hands.frames(frames);
    hands.viewer.window().post({Kind::close});
    EXPECT_FALSE(hands.viewer.frame(0));
  }
}

INSTANTIATE_TEST_SUITE_P(Contexts, Window_, ::testing::Bool(),
                         [](const auto& context) { return context.param ? "egl" : "native"; });

TEST(Viewer, ABadFileLeavesTheOldOne) {
  Opened hands(small(asset("slab.vdb")));
  hands.drop(asset("rotated.vdb"));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(hands.viewer.scene().input, asset("rotated.vdb"));
  expect_same(*hands.viewer.exact_picture(), rendered(hands.viewer.scene()));
  hands.drop(asset("shells.json"));
  ASSERT_TRUE(hands.until_error());
  EXPECT_TRUE(has(hands.viewer.messages().last_error(), "shells.json"));
  EXPECT_EQ(hands.viewer.scene().input, asset("rotated.vdb"));
  hands.expect_rendered();
}

TEST(Viewer, ABadFileLeavesTheOneThatIsStillReadAndTheEmptyWindow) {
  for (const std::string& open : {asset("slab.vdb"), std::string()}) {
    Hands hands(small(open));
    hands.drop(asset("shells.json"));
    ASSERT_TRUE(hands.until_error());
    EXPECT_EQ(hands.viewer.scene().input, open);
    if (open.empty()) hands.drop(asset("slab.vdb"));
    hands.expect_rendered();
  }
}

TEST(Viewer, ASlowScreenIsNotTakenForRest) {
  // Where drawing the window takes long, its wishes come late while the camera moves: to refine
  // meanwhile would make it slower still.
  Opened hands(small(asset("slab.vdb")));
  hands.key(GLFW_KEY_TAB);
  ASSERT_TRUE(hands.until_exact());
  const std::uint64_t refined = hands.viewer.pictures().refined;
  hands.press({240, 180});
  for (int i = 1; i <= 4; ++i) {
    hands.viewer.window().post({Kind::move, glm::dvec2(240 + 9 * i, 180)});
    hands.viewer.frame(0);
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
  }
  hands.viewer.frame(0);
  EXPECT_GT(hands.viewer.pictures().shown, refined);
  EXPECT_EQ(hands.viewer.pictures().refined, refined);
  hands.release({276, 180});
  ASSERT_TRUE(hands.until_exact());
}

TEST(Viewer, TheBenchmarkOrdersItsTimes) {
  Hands hands(small(asset("blobs.vdb")));  // the panel covers the place of the drag
  const OrbitTimes times = benchmark_orbit(hands.viewer, 30);
  EXPECT_EQ(times.intervals_ms.size(), 30u);
  EXPECT_GT(std::ranges::min(times.intervals_ms), 0);
  EXPECT_GT(times.first_part_ms, 0);
  EXPECT_LE(times.first_part_ms, times.first_exact_ms);
}

TEST(Viewer, PanelsFollowTheDisplaysScale) {
  Opened hands(small(asset("blobs.vdb"), {1200, 800}));
  hands.viewer.panels().transfer = true;
  const auto scale = [&](double factor) {
    hands.post({Kind::scale, {factor, 0}});
    hands.frames(4);
  };
  const TransferEditor& editor = hands.viewer.transfer_editor();
  const auto width = [&] { return editor.place_of(2).value().x - editor.place_of(0).value().x; };
  scale(1);
  const double once = width();
  const gl::ObjectCounts before = gl::count_objects();
  scale(2);
  EXPECT_NEAR(width(), 2 * once, 4);
  const glm::dvec2 from = editor.place_of(1).value();
  hands.drag(from + glm::dvec2(9, 0), from + glm::dvec2(9, 60));  // also makes its disk wider
  EXPECT_EQ(editor.points().size(), 3u);
  EXPECT_GT(editor.place_of(1).value().y, from.y + 50);
  scale(1);
  EXPECT_NEAR(width(), once, 2);
  EXPECT_EQ(before, gl::count_objects());
}

TEST(Viewer, AnInputThatCannotBeReadIsTheProgramsError) {
  Hands hands(small("nowhere.vdb"));
  EXPECT_NE(input_error([&] { hands.viewer.run(); }), "no error");
}

/// Writes docs/preview.png, if PSIVOX_PHOTOGRAPHS names docs.
TEST(Viewer, ThePictureOfTheGuide) {
  if (!std::getenv("PSIVOX_PHOTOGRAPHS")) GTEST_SKIP() << "PSIVOX_PHOTOGRAPHS is not set";
  const fs::path folder = fs::absolute(std::getenv("PSIVOX_PHOTOGRAPHS"));
  const fs::path before = fs::current_path();
  fs::current_path(fs::path(assets).parent_path());  // for the file names in the scene
  Scene scene = open_look("assets/blobs.vdb");
  scene.resolution = {1280, 760};
  Opened hands(scene);
  hands.viewer.navigation().orbit({-100, 60});
  hands.viewer.navigation().pan({120, 0});
  hands.click({100, 228});  // unfolds slice and clip
  hands.click({27, 251});   // a box around all
  hands.move({900, 700});
  hands.frames(3);
  ASSERT_TRUE(hands.until_exact());
  hands.frames(4);
  hands.viewer.photograph((folder / "preview.png").string());
  fs::current_path(before);
}

TEST(Viewer, ADoubleClickPutsThePivotOnWhatIsSeen) {
  Scene scene = small(asset("slab.vdb"));
  scene.extinction = 1000;
  Opened hands(scene);
  hands.key(GLFW_KEY_TAB);
  const glm::dvec3 before = hands.viewer.navigation().pivot();
  for (int i = 0; i < 2; ++i) {
    hands.press({240, 180});
    hands.release({240, 180});
  }
  ASSERT_TRUE(hands.until([&] { return hands.viewer.navigation().pivot() != before; }));
  const glm::dvec3 pivot = hands.viewer.navigation().pivot();
  EXPECT_NEAR(pivot.x, before.x, 0.05);
  EXPECT_GT(pivot.z, before.z);  // on the camera's side
}

TEST(Viewer, TwoPicturesAreCompared) {
  Opened hands(small(asset("blobs.vdb"), {240, 180}));
  hands.key(GLFW_KEY_TAB);
  Scene coarse = hands.viewer.scene();
  coarse.step = 3;
  Scene reference = hands.viewer.scene();
  reference.renderer = RendererKind::reference;
  for (const Scene& other : {coarse, reference})
    for (const Comparison comparison : {Comparison::wipe, Comparison::difference}) {
      hands.viewer.compare(comparison, other);
      hands.frames(2);
      hands.expect_rendered();
      expect_same(*hands.viewer.complete_picture(1), rendered(other));
    }
}

TEST(Viewer, ShowsStepsDepthAndErrorOfRenderAsColours) {
  Scene scene = small(asset("blobs.vdb"));
  scene.step = 2;
  scene.filter = Filter::hardware;  // the exact picture needs its own textures
  Opened hands(scene);
  hands.key(GLFW_KEY_TAB);
  for (const ShownLayer layer : {ShownLayer::steps, ShownLayer::depth, ShownLayer::error}) {
    const char* name = shown_layers[static_cast<std::size_t>(layer)];
    SCOPED_TRACE(name);
    hands.viewer.show(layer);
    hands.frames(2);
    EXPECT_FALSE(hands.viewer.exact_picture());
    ASSERT_TRUE(hands.until([&] { return hands.viewer.complete_picture(); }));
    Image expected = rendered(hands.viewer.scene(), name);
    const glm::dvec2 range = show_layer(layer, {&expected, 1});
    EXPECT_LT(range.x, range.y);
    expect_same(*hands.viewer.complete_picture(), expected);
  }
  hands.viewer.show(ShownLayer::picture);
  hands.frames(2);
  hands.expect_rendered();
}

TEST(Viewer, ReadsChangedShadersAgain) {
  const fs::path folder = fs::path(testing::TempDir()) / "psivox_view_shaders";
  fs::remove_all(folder);
  fs::copy(PSIVOX_SHADERS, folder, fs::copy_options::recursive);
  setenv("PSIVOX_SHADER_DIR", folder.c_str(), 1);
  const auto edit = [&](const std::string& from, const std::string& to) {
    const std::string file = (folder / "march.frag").string();
    std::string text = read_text(file, "shader");
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    write_text(file, text.replace(at, from.size(), to));
  };
  Opened hands(small(asset("slab.vdb")));
  const auto first = [&] { return hands.viewer.exact_picture()->rgba()[0]; };
  const float before = first();
  EXPECT_NE(before, 0.25f);
  edit("out_picture = drawn(m, ray);", "out_picture = vec4(0.25);");
  hands.key(GLFW_KEY_R);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(first(), 0.25f);
  edit("out_picture = vec4(0.25);", "out_picture = vec4(0.25;");
  hands.key(GLFW_KEY_R);
  ASSERT_TRUE(hands.until_error());
  EXPECT_TRUE(has(hands.viewer.messages().last_error(), "march.frag:"));
  ASSERT_TRUE(hands.until_exact());
  EXPECT_EQ(first(), 0.25f);
  unsetenv("PSIVOX_SHADER_DIR");
  fs::remove_all(folder);
}

double resident_pages() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident;
}

TEST(Viewer, ManyFilesTakeTheMemoryAndTheObjectsOfOne) {
  std::vector<std::string> files;
  for (const char* name : {"blobs", "slab", "rotated", "tiles", "single_voxel", "ramp"})
    files.push_back(asset(name) + ".vdb");
  Opened hands(small(files.front()));
  hands.key(GLFW_KEY_TAB);
  const auto open_all_twice = [&] {
    for (std::size_t i = 1; i <= 2 * files.size(); ++i) {
      hands.drop(files[i % files.size()]);
      ASSERT_TRUE(hands.until_exact());
      hands.drag({240, 180}, {340, 200});
      ASSERT_TRUE(hands.until_exact());
    }
  };
  const auto objects = [&] {
    return std::pair(gl::count_objects(), hands.viewer.pictures().objects);
  };
  open_all_twice();
  const auto settled = objects();
  const double settled_pages = resident_pages();
  EXPECT_GT(settled.first[0], 0);
  EXPECT_GT(settled.second[0], 0);
  open_all_twice();
  EXPECT_EQ(objects(), settled);
#ifndef __SANITIZE_ADDRESS__  // which does not return freed memory
  EXPECT_LT(resident_pages(), 1.05 * settled_pages);
#endif
}

}  // namespace
}  // namespace psivox::view
