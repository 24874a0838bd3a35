// The editor of transfer functions in a real window: points, handles, and what is drawn by them.

#include <gtest/gtest.h>

#include <filesystem>

#include "view/viewer.h"
#include "viewer_hands.h"

namespace psivox::view {
namespace {

TEST(ViewerEditor, PointsOfTheTransferFunctionAreDragged) {
  Opened hands(small(asset("blobs.vdb"), {900, 600}));
  const TransferEditor& editor = hands.edit();
  ASSERT_EQ(editor.points().size(), 3u);
  // a point on the line changes nothing
  const Image plain = hands.viewer.exact_picture().value();
  hands.click(0.5 * (editor.place_of(1).value() + editor.place_of(2).value()));
  ASSERT_TRUE(hands.until_exact());
  ASSERT_FALSE(hands.viewer.scene().transfer_function.empty());
  // each is within the tolerance, and the place of a pointer is rounded to a pixel
  EXPECT_LE(compare_images(plain, hands.viewer.exact_picture().value()).rms, 4 * default_tolerance);
  const glm::dvec2 added = editor.place_of(2).value();
  hands.press(added, GLFW_MOUSE_BUTTON_RIGHT);
  hands.release(added, GLFW_MOUSE_BUTTON_RIGHT);
  hands.key(GLFW_KEY_T, GLFW_MOD_CONTROL);  // is no T
  hands.frames(2);
  ASSERT_TRUE(hands.viewer.panels().transfer);
  ASSERT_EQ(editor.points().size(), 3u);
  const glm::dvec2 from = editor.place_of(1).value();
  hands.drag(from, from + glm::dvec2(40, -30));
  ASSERT_FALSE(hands.viewer.scene().transfer_function.empty());
  hands.expect_rendered();
  // a click adds a point, the right button removes it
  const glm::dvec2 between = 0.5 * (editor.place_of(1).value() + editor.place_of(2).value());
  hands.press(between + glm::dvec2(0, 40));
  hands.release(between + glm::dvec2(0, 40));
  EXPECT_EQ(editor.points().size(), 4u);
  hands.press(between + glm::dvec2(0, 40), GLFW_MOUSE_BUTTON_RIGHT);
  hands.release(between + glm::dvec2(0, 40), GLFW_MOUSE_BUTTON_RIGHT);
  EXPECT_EQ(editor.points().size(), 3u);
}

TEST(ViewerEditor, EachChangeOfTheFunctionIsUndone) {
  Opened hands(small(asset("blobs.vdb"), {900, 600}));
  const Image plain = hands.viewer.exact_picture().value();
  const TransferEditor& editor = hands.edit();
  const auto drag = [&] {
    const glm::dvec2 from = editor.place_of(1).value();
    hands.drag(from, from + glm::dvec2(20, -20));
    EXPECT_TRUE(hands.until_exact());
    return hands.viewer.exact_picture().value();
  };
  const Image once = drag();
  drag();
  hands.key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
  ASSERT_TRUE(hands.until_exact());
  expect_same(hands.viewer.exact_picture().value(), once);
  hands.key(GLFW_KEY_Z, GLFW_MOD_CONTROL);
  ASSERT_TRUE(hands.until_exact());
  EXPECT_TRUE(hands.viewer.scene().transfer_function.empty());
  expect_same(hands.viewer.exact_picture().value(), plain);
}

TEST(ViewerEditor, HandlesBesideTheHistogramChangeRangeAndOpacity) {
  using Handle = TransferEditor::Handle;
  Opened hands(small(asset("blobs.vdb"), {900, 600}));
  const TransferEditor& editor = hands.edit();
  const TransferPoints before = editor.points();
  ASSERT_EQ(before.size(), 3u);
  const double width = before[2].value - before[0].value;
  const double pixels = editor.place_of(2).value().x - editor.place_of(0).value().x;
  const auto drag = [&](Handle handle, const glm::dvec2& by) {
    const glm::dvec2 from = editor.place_of(handle);
    hands.drag(from, from + by);
    hands.frames(2);
  };
  // a pixel of the canvas, for the pointer's place within a handle
  const double pixel = width / pixels;
  drag(Handle::high, {-0.5 * pixels, 0});
  EXPECT_NEAR(editor.points()[0].value, before[0].value, 1e-9);
  EXPECT_NEAR(editor.points()[1].value, before[0].value + width / 4, pixel);
  EXPECT_NEAR(editor.points()[2].value, before[0].value + width / 2, pixel);
  drag(Handle::range, {0.25 * pixels, 0});
  EXPECT_NEAR(editor.points()[0].value, before[0].value + width / 4, 2 * pixel);
  EXPECT_NEAR(editor.points()[2].value, before[0].value + 3 * width / 4, 2 * pixel);
  drag(Handle::low, {-0.25 * pixels, 0});
  EXPECT_NEAR(editor.points()[0].value, before[0].value, 2 * pixel);
  EXPECT_NEAR(editor.points()[2].value, before[0].value + 3 * width / 4, 2 * pixel);
  const double tall = editor.place_of(0).value().y - editor.place_of(2).value().y;
  drag(Handle::opacity, {0, 0.5 * tall});
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(editor.points()[i].attenuation, before[i].attenuation / 2,
                2 / tall * before[2].attenuation);
  hands.expect_rendered();
}

TEST(ViewerEditor, AnEditedPreintegrationIsThatOfRender) {
  // updated while a point is dragged; then compared with another process's table
  Scene scene = small(asset("blobs.vdb"), {700, 420});
  scene.transfer_function = asset("shells.json");
  scene.integrator = Integrator::preintegrated;
  scene.extinction = 6;
  Opened hands(scene);
  const glm::dvec2 from = hands.edit().place_of(5).value();
  hands.press(from);
  for (int i = 1; i <= 2; ++i) {
    const std::uint64_t before = hands.viewer.pictures().wished;
    hands.move(from + glm::dvec2(7, 20) * double(i));
    ASSERT_TRUE(hands.until([&] {
      return hands.viewer.pictures().wished > before &&
             hands.viewer.pictures().shown == hands.viewer.pictures().wished;
    }));
  }
  hands.release(from + glm::dvec2(14, 40));
  ASSERT_TRUE(hands.until_exact());
  const fs::path file = fs::path(testing::TempDir()) / "psivox_preintegrated.exr";
  const fs::path before = fs::current_path();
  fs::current_path(testing::TempDir());  // the function is saved there
  hands.viewer.save_picture(file.string());
  ASSERT_TRUE(hands.until([&] { return !hands.viewer.saving(); }));
  ASSERT_TRUE(hands.until_exact());
  fs::current_path(before);
  expect_same(*hands.viewer.exact_picture(), read_image(file));
  fs::remove(fs::path(testing::TempDir()) / hands.viewer.scene().transfer_function);
  fs::remove(file);
}

}  // namespace
}  // namespace psivox::view
