// The camera as the user moves it, and other parts of the viewer that need no window.

#include "view/navigation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <semaphore>

#include "app/command_text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scratch.h"
#include "thrown.h"
#include "view/viewer.h"

namespace psivox::view {
namespace {

constexpr glm::dvec3 low{-1, -2, -3}, high{3, 2, 1};

Navigation over_box(const Scene& scene = {}) {
  Navigation navigation;
  navigation.reset(scene, box_subject(low, high));
  return navigation;
}

Camera camera_of(const Navigation& navigation, Scene scene = {}) {
  navigation.apply(scene);
  return make_camera(scene, low, high);
}

double distance(const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b); }

glm::dvec2 place(const Navigation& navigation, const glm::dvec3& point) {
  glm::dvec2 pixel{-1};
  EXPECT_TRUE(navigation.project(point, pixel));
  return pixel;
}

TEST(Navigation, ACameraThatIsNotMovedIsTheScenesOwn) {
  Scene scene;
  over_box().apply(scene);
  EXPECT_EQ(to_json(scene), to_json(Scene{}));
}

TEST(Navigation, OrbitsKeepThePivotInItsPlace) {
  Navigation navigation = over_box();
  const glm::dvec3 pivot{2, 1, 0};
  navigation.set_pivot(pivot);
  const glm::dvec2 before = place(navigation, pivot);
  const double away = distance(camera_of(navigation).position, pivot);
  navigation.orbit({137, -61});
  // numbers are rounded to a millionth of the distance
  EXPECT_NEAR(distance(camera_of(navigation).position, pivot), away, 1e-4);
  EXPECT_NEAR(place(navigation, pivot).x, before.x, 1e-6);
  EXPECT_NEAR(place(navigation, pivot).y, before.y, 1e-6);
}

TEST(Navigation, ARoundTripEndsWhereItBegan) {
  Navigation navigation = over_box();
  navigation.orbit({1, 0});
  const glm::dvec3 begin = camera_of(navigation).position;
  for (int i = 0; i < 36; ++i) navigation.orbit({40, 0});  // 720 pixels are half a turn
  EXPECT_NEAR(distance(camera_of(navigation).position, begin), 0, 1e-4);
}

TEST(Navigation, TheTurntableStopsAtThePoles) {
  Navigation navigation = over_box();
  navigation.orbit({0, 5000});
  const Camera below = camera_of(navigation);
  EXPECT_NEAR(below.forward.y, -1, 1e-6);
  EXPECT_NEAR(below.right.x, 1, 1e-6);
  navigation.orbit({360, 0});  // a quarter turn at the pole turns the picture
  EXPECT_NEAR(std::abs(camera_of(navigation).right.z), 1, 1e-5);
  navigation.orbit({0, -10});
  EXPECT_GT(camera_of(navigation).up.y, 0);
}

TEST(Navigation, PanFollowsThePointerAtThePivotsDepth) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    Scene scene;
    scene.projection = projection;
    Navigation navigation = over_box(scene);
    const glm::dvec3 point = navigation.pivot();
    const glm::dvec2 before = place(navigation, point);
    navigation.pan({30, -20});
    EXPECT_NEAR(place(navigation, point).x, before.x + 30, 1e-6);
    EXPECT_NEAR(place(navigation, point).y, before.y - 20, 1e-6);
  }
}

TEST(Navigation, DollyGoesATenthOfTheWayAndNeverThrough) {
  Navigation navigation = over_box();
  const double before = distance(camera_of(navigation).position, navigation.pivot());
  navigation.dolly(1);
  EXPECT_NEAR(distance(camera_of(navigation).position, navigation.pivot()), 0.9 * before, 1e-4);
  navigation.dolly(-1);
  EXPECT_NEAR(distance(camera_of(navigation).position, navigation.pivot()), before, 1e-4);
  navigation.dolly(1000);
  const Camera close = camera_of(navigation);
  EXPECT_GT(glm::dot(navigation.pivot() - close.position, close.forward), -1e-3);
}

TEST(Navigation, FrameAllShowsEveryCornerFromAnySide) {
  for (const bool orthographic : {false, true}) {
    Navigation navigation = over_box();
    if (orthographic) navigation.toggle_projection();
    navigation.orbit({321, 123});
    navigation.dolly(17);
    navigation.frame_all();
    double reach = 0;
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 corner{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y,
                              i & 4 ? high.z : low.z};
      const glm::dvec2 p = place(navigation, corner) / glm::dvec2(1280, 720) * 2.0 - 1.0;
      reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
    }
    EXPECT_NEAR(reach, 0.9, 1e-9);
  }
}

TEST(Navigation, AxisViewsAreBlenders) {
  Navigation navigation = over_box();
  navigation.look(Axis::right, false);
  EXPECT_NEAR(camera_of(navigation).forward.x, -1, 1e-9);
  navigation.look(Axis::top, false);
  EXPECT_NEAR(camera_of(navigation).forward.y, -1, 1e-9);
  EXPECT_NEAR(camera_of(navigation).right.x, 1, 1e-9);
  navigation.look(Axis::front, true);
  EXPECT_NEAR(camera_of(navigation).forward.z, 1, 1e-9);
  Scene scene;
  scene.camera_up = glm::dvec3(0, 0, 1);
  Navigation upright = over_box(scene.camera_position ? scene : [&] {
    scene.camera_position = glm::dvec3{1, -9, 1};
    return scene;
  }());
  upright.look(Axis::front, false);
  EXPECT_NEAR(camera_of(upright, scene).forward.y, 1, 1e-9);
  EXPECT_NEAR(camera_of(upright, scene).right.x, 1, 1e-9);
}

TEST(Navigation, FacesAPlaneFromTheNearerSide) {
  for (const glm::dvec3 normal : {glm::dvec3(1, 0, 0), {0, 1, 0}, {0, 0, -1}, {1, 2, -3}}) {
    Navigation navigation = over_box();
    navigation.orbit({40, 30});
    const glm::dvec3 pivot = navigation.pivot(), before = navigation.forward();
    const double away = distance(camera_of(navigation).position, pivot);
    navigation.face(normal);
    const Camera camera = camera_of(navigation);
    // numbers are rounded to a millionth of the distance
    EXPECT_NEAR(std::abs(glm::dot(camera.forward, glm::normalize(normal))), 1, 1e-9);
    EXPECT_GT(glm::dot(camera.forward, before), 0);
    EXPECT_NEAR(distance(camera.position, pivot), away, 1e-5 * away);
    EXPECT_GE(camera.up.y, -1e-9);
  }
}

TEST(Navigation, TheOtherProjectionKeepsTheSizeAtThePivot) {
  Navigation navigation = over_box();
  navigation.orbit({50, 30});
  const Camera before = camera_of(navigation);
  const glm::dvec3 aside = navigation.pivot() + before.right;
  const glm::dvec2 pixel = place(navigation, aside);
  navigation.toggle_projection();
  EXPECT_TRUE(camera_of(navigation).orthographic);
  EXPECT_NEAR(place(navigation, aside).x, pixel.x, 1e-4);  // the camera's numbers are rounded
  navigation.toggle_projection();
  EXPECT_NEAR(place(navigation, aside).x, pixel.x, 1e-4);  // the camera's numbers are rounded
  EXPECT_NEAR(distance(camera_of(navigation).position, before.position), 0, 1e-4);
}

TEST(Pace, FindsARungWithinTheBudget) {
  Pace pace(33);
  const auto time_of = [](const Rung& rung) {
    return 3 + 400 * (0.3 + 0.7 / rung.step) / (rung.divisor * rung.divisor);
  };
  for (int i = 0; i < 20; ++i) pace.took(pace.rung(), time_of(pace.rung()));
  EXPECT_LE(time_of(pace.rung()), 33 * 1.05);
  EXPECT_GE(time_of(pace.rung()), 33 * 0.5);
  const Rung settled = pace.rung();
  pace.took(settled, time_of(settled));
  EXPECT_EQ(pace.rung(), settled);
  for (int i = 0; i < 40; ++i) pace.took(pace.rung(), 2.5);
  EXPECT_EQ(pace.rung(), (Rung{1, 1}));
}

TEST(Pace, PreviewsOfEverySceneAreValid) {
  for (const char* line : {"mode isosurface", "sampling template", "integrator cell-exact",
                           "step 0.25", "mode mip", "colormap viridis"}) {
    Scene scene;
    const std::string text = line;
    const std::size_t space = text.find(' ');
    if (text == "sampling template") scene.projection = Projection::orthographic;
    set_parameter(scene, text.substr(0, space), text.substr(space + 1));
    const Scene preview = preview_scene(scene, {4, 2});
    EXPECT_NO_THROW(validate(preview)) << line;
    EXPECT_EQ(preview.resolution, glm::ivec2(320, 180));
  }
}

TEST(CommandText, IsWhatRenderReads) {
  Scene scene;
  scene.input = "it's a file.vdb";
  scene.extinction = 0.1;
  scene.camera_position = {-1.5, 2, 1e-7};
  scene.split_knots = true;
  scene.colormap = Colormap::turbo;
  EXPECT_EQ(render_command_line(scene, "out.exr"),
            "psivox render 'it'\\''s a file.vdb' --output=out.exr --extinction=0.1 "
            "--colormap=turbo --camera-position=-1.5,2,1e-07 --split-knots=true --look=plain");
  scene.input = "-a.vdb";
  EXPECT_EQ(render_arguments(scene, "out.exr").front(), "./-a.vdb");
}

TEST(Window, PlacesAreThoseOfTheFramebuffer) {
  EXPECT_EQ(framebuffer_place({300, 50.5}, {640, 360}, {1280, 720}), glm::dvec2(600, 101));
  EXPECT_EQ(framebuffer_place({30, 20}, {640, 360}, {640, 360}), glm::dvec2(30, 20));
  EXPECT_EQ(framebuffer_place({3, 2}, {0, 0}, {0, 0}), glm::dvec2(0, 0));  // minimised
}

TEST(Volume, TellsHowFarItIs) {
  Scene scene;
  scene.input = PSIVOX_ASSETS "/blobs.vdb";
  std::vector<std::string> stages;
  double last = 0;
  int steps = 0;
  const auto progress = [&](const std::string& stage, double fraction) {
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
    EXPECT_LE(fraction, 1);
    if (fraction == 0) return;
    EXPECT_GT(fraction, last);
    last = fraction;
    ++steps;
  };
  std::shared_ptr<const Subject> subject;
  prepare_volume(scene, {}, 0, nullptr, progress, [&](const auto& known) { subject = known; });
  EXPECT_EQ(stages, (std::vector<std::string>{"reading", "converting"}));
  EXPECT_GE(steps, 2);
  EXPECT_GT(last, 0.5);
  EXPECT_TRUE(subject);
  // an exception of a newer wish ends the reading
  struct Ended {};
  const auto end = [](const std::string&, double fraction) {
    if (fraction > 0) throw Ended();
  };
  EXPECT_THROW(prepare_volume(scene, {}, 0, nullptr, end, {}), Ended);
}

TEST(RecentFiles, AreTheLastTenOnceEach) {
  namespace fs = std::filesystem;
  const fs::path state = fs::path(testing::TempDir()) / "psivox_state";
  fs::remove_all(state);
  setenv("XDG_STATE_HOME", state.c_str(), 1);
  EXPECT_TRUE(recent_files().empty());
  for (int i = 0; i < 12; ++i) remember_file("/a/" + std::to_string(i) + ".vdb");
  remember_file("/a/5.vdb");
  const std::vector<std::string> files = recent_files();
  EXPECT_EQ(files.size(), 10u);
  EXPECT_EQ(files.at(0), "/a/5.vdb");
  EXPECT_EQ(files.at(1), "/a/11.vdb");
  EXPECT_EQ(std::count(files.begin(), files.end(), "/a/5.vdb"), 1);
  unsetenv("XDG_STATE_HOME");
  fs::remove_all(state);
}

TEST(Keys, AreAllInTheGuide) {
  const std::string guide = read_text(PSIVOX_ASSETS "/../docs/preview.md", "guide");
  for (const Command& row : commands())
    EXPECT_TRUE(has(guide, std::string("\n| ") + row.keys + " |")) << row.keys;
}

TEST(Sequence, IsTheFilesThatDifferInTheirLastNumber) {
  namespace fs = std::filesystem;
  const fs::path folder = test::empty_scratch_dir();
  for (const char* name : {"v2_0001.vdb", "v2_0002.vdb", "v2_0004.vdb", "v3_0001.vdb", "other.vdb"})
    test::write_bytes(name, "");
  const auto at = [&](const char* name) { return (folder / name).string(); };
  Sequence sequence = Sequence::of({at("v2_0002.vdb")});
  EXPECT_EQ(sequence.first(), 1);
  EXPECT_EQ(sequence.last(), 4);
  EXPECT_EQ(sequence.current(), 2);
  EXPECT_EQ(sequence.missing(), std::vector<std::int64_t>{3});
  EXPECT_TRUE(sequence.samples().empty());
  EXPECT_EQ(sequence.next(), 4);
  sequence.go_to(9);
  EXPECT_EQ(sequence.current(), 4);
  EXPECT_EQ(sequence.next(), 1);
  EXPECT_EQ(sequence.previous(), 2);
  EXPECT_EQ(sequence.path(), at("v2_0004.vdb"));
  sequence.go_to(0);
  EXPECT_EQ(sequence.current(), 1);
  EXPECT_EQ(sequence.previous(), 4);
  EXPECT_TRUE(Sequence::of({at("other.vdb")}).empty());
  EXPECT_TRUE(Sequence::of({"nowhere/a1.vdb"}).empty());
  // a named sequence: auto chooses from its first, middle and last frame
  const std::vector<std::string> samples{at("v2_0001.vdb"), at("v2_0002.vdb"), at("v2_0004.vdb")};
  for (const char* pattern : {"v2_####.vdb", "v2_%04d.vdb", "v2_$F4.vdb"}) {
    EXPECT_EQ(Sequence::of({at(pattern)}).current(), 1) << pattern;
    EXPECT_EQ(Sequence::of({at(pattern)}).samples(), samples) << pattern;
  }
  EXPECT_EQ(Sequence::of(samples).missing(), std::vector<std::int64_t>{3});
  EXPECT_EQ(Sequence::of({at("other.vdb"), at("v3_0001.vdb")}).last(), 2);
  EXPECT_THROW(Sequence::of({at("v4_####.vdb")}), Error);
}

TEST(CurrentVolume, ASubjectAndAVolumeThatArriveTogetherAreTheVolume) {
  std::counting_semaphore<> told(0);
  CurrentVolume current([&] { told.release(); });
  Scene scene;
  scene.input = std::string(PSIVOX_ASSETS) + "/slab.vdb";
  EXPECT_FALSE(current.wish(scene, {}));
  for (int n = 0; n < 2; ++n) told.acquire();  // of the subject, and of the volume
  const CurrentVolume::News news = current.take_news();
  EXPECT_TRUE(news.volume);
  EXPECT_FALSE(current.first_subject());
}

TEST(CurrentVolume, AnErrorOfAReplacedWishIsNotTold) {
  std::counting_semaphore<> news{0};
  CurrentVolume current([&] { news.release(); });
  Scene scene;
  scene.input = "missing.vdb";
  EXPECT_FALSE(current.wish(scene, {}));
  news.acquire();  // refused, and nobody has asked
  scene.input = PSIVOX_ASSETS "/blobs.vdb";
  EXPECT_FALSE(current.wish(scene, {}));
  news.acquire();  // the box
  news.acquire();  // the volume
  const CurrentVolume::News told = current.take_news();
  EXPECT_TRUE(told.volume);
  EXPECT_FALSE(told.error);
}

}  // namespace
}  // namespace psivox::view
