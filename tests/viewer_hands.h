#pragma once

#include <gtest/gtest.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/command_text.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "view/viewer.h"

// A viewer driven by a test, and the program whose pictures it must show.

namespace psivox::view {

namespace fs = std::filesystem;
using Kind = Event::Kind;

inline constexpr const char* assets = PSIVOX_ASSETS;

inline std::string asset(const std::string& name) { return std::string(assets) + "/" + name; }

/// Runs `psivox render` in a separate process.
inline void render_by_program(const std::vector<std::string>& arguments) {
  std::string line = PSIVOX_PROGRAM " render";
  for (const std::string& word : arguments) line += " '" + word + "'";
  if (std::system(line.c_str()) != 0) throw Error(ExitCode::failure, "psivox render failed");
}

/// The picture that `psivox render` draws of a scene, without a background; with layers if they are
/// named.
inline Image rendered(Scene scene, const std::string& layers = "") {
  scene.background.reset();
  const fs::path file = fs::path(testing::TempDir()) / "psivox_rendered.exr";
  std::vector<std::string> arguments = render_arguments(scene, file.string());
  arguments.insert(arguments.begin(), "--quiet");
  if (!layers.empty()) arguments.insert(arguments.begin(), "--aov=" + layers);
  render_by_program(arguments);
  Image image = read_image(file);
  fs::remove(file);
  return image;
}

inline Scene small(const std::string& input, const glm::ivec2& size = {480, 360}) {
  Scene scene;
  scene.input = input;
  scene.look = "plain";
  scene.resolution = size;
  return scene;
}

/// A scene that leaves its look open, as `psivox view FILE` does.
inline Scene open_look(const std::string& input) {
  Scene scene = small(input, {600, 420});
  scene.look.clear();
  return scene;
}

inline void expect_same(const Image& a, const Image& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  const auto left = a.rgba(), right = b.rgba();
  EXPECT_TRUE(std::equal(left.begin(), left.end(), right.begin(), right.end()))
      << "largest difference " << compare_images(a, b).max;
}

/// A viewer and its simulated input.
class Hands {
 public:
  explicit Hands(const Scene& scene, bool egl = false, bool watch = false)
      : viewer(scene, {.frame_budget_ms = 0,  // the cheapest previews, however fast the machine is
                       .watch = watch,
                       .egl = egl,
                       .debug = true,
                       .quiet = true,
                       .count_objects = true,
                       .render = render_by_program}) {}

  ~Hands() {
    if (errors) {
      EXPECT_EQ(viewer.messages().error_count(), *errors) << viewer.messages().last_error();
    }
  }

  void frames(int count) {
    for (int i = 0; i < count; ++i) viewer.frame(0.01);
  }
  template <typename Condition>
  ::testing::AssertionResult until(const Condition& condition) {
    const auto start = std::chrono::steady_clock::now();
    while (!condition()) {
      viewer.frame(0.05);
      if (std::chrono::steady_clock::now() - start > std::chrono::seconds(120))
        return ::testing::AssertionFailure()
               << "waited in vain; " << viewer.messages().last_error();
    }
    return ::testing::AssertionSuccess();
  }
  ::testing::AssertionResult until_exact() {
    return until([&] { return !viewer.loading() && viewer.exact_picture(); });
  }
  /// The first error.
  ::testing::AssertionResult until_error() {
    errors = 1;
    return until([&] { return viewer.messages().error_count() == 1; });
  }
  /// The window refines to the picture that `psivox render` draws of its scene.
  void expect_rendered() {
    ASSERT_TRUE(until_exact());
    expect_same(*viewer.exact_picture(), rendered(viewer.scene()));
  }
  void post(Event event) {
    viewer.window().post(std::move(event));
    frames(1);
  }
  void key(int code, int modifiers = 0) {
    post({Kind::key, {}, code, true, modifiers});
    post({Kind::key, {}, code, false, modifiers});
  }
  void type(const char* text) {
    for (; *text; ++text) post({Kind::text, {}, *text});
  }
  void click(const glm::dvec2& at) {
    press(at);
    release(at);
    frames(2);
  }
  void move(const glm::dvec2& to) { post({Kind::move, to}); }
  void press(const glm::dvec2& at, int button = GLFW_MOUSE_BUTTON_LEFT) {
    move(at);
    frames(2);  // the viewer knows the item under the pointer one frame later
    post({Kind::button, at, button, true});
  }
  void release(const glm::dvec2& at, int button = GLFW_MOUSE_BUTTON_LEFT) {
    post({Kind::button, at, button, false});
  }
  void drag(const glm::dvec2& from, const glm::dvec2& to, int button = GLFW_MOUSE_BUTTON_LEFT) {
    press(from, button);
    for (int i = 1; i <= 8; ++i) move(from + (to - from) * (i / 8.0));
    release(to, button);
  }
  void drop(const std::string& path) { post({Kind::drop, {}, 0, false, 0, {path}}); }
  Viewer viewer;
  std::optional<int> errors = 0;  ///< that a test causes; null if any number may happen
};

/// A viewer that shows its first exact picture.
class Opened : public Hands {
 public:
  explicit Opened(const Scene& scene, bool egl = false, bool watch = false)
      : Hands(scene, egl, watch) {
    if (!until_exact()) throw Error(ExitCode::failure, viewer.messages().last_error());
  }
  /// With the editor of transfer functions.
  const TransferEditor& edit() {
    viewer.panels().transfer = true;
    frames(4);
    return viewer.transfer_editor();
  }
};

}  // namespace psivox::view
