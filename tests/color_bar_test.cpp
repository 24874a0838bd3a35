// The colour bar: its colours, its numbers, and the text.

#include "blobs_scene.h"
#include "psivox/draw.h"
#include "psivox/picture_file.h"
#include "scene/color.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "image/canvas.h"
#include "made_fields.h"
#include "medium/label_function.h"

namespace psivox {
namespace {

View view_with(const Scene& scene) {
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) { return float(v.x) + 1; });
  field.name = "density";
  return make_view(scene, std::make_shared<const Field>(std::move(field)), nullptr);
}

/// Pixels of exactly that colour.
int count(const Image& image, const glm::dvec3& color) {
  int found = 0;
  for (std::size_t i = 0; i < image.rgba().size(); i += 4) {
    bool same = true;
    for (int c = 0; c < 3; ++c) same &= image.rgba()[i + std::size_t(c)] == float(color[c]);
    found += same;
  }
  return found;
}

TEST(ColorScale, IsTheMapsOverTheRange) {
  Scene scene;
  scene.colormap = Colormap::hot;
  scene.luminance = glm::dvec3(0.5);
  scene.range = glm::dvec2(2, 6);
  const auto scale = color_scale(view_with(scene));
  ASSERT_TRUE(scale);
  EXPECT_EQ(scale->title, "density");
  EXPECT_EQ(scale->min, 2);
  EXPECT_EQ(scale->max, 6);
  // not the look's: the map's own
  EXPECT_EQ(scale->colors.front(), colormap_color(Colormap::hot, 0));
  EXPECT_EQ(scale->colors.back(), colormap_color(Colormap::hot, 1));
  scene.color_bar = "temperature [°C]";
  EXPECT_EQ(color_scale(view_with(scene))->title, "temperature [°C]");
  Scene plain;
  EXPECT_FALSE(color_scale(view_with(plain)));
  plain.mode = Mode::mip;
  EXPECT_EQ(color_scale(view_with(plain))->max, 8);
}

TEST(ColorBar, HasEachColourFromBottomToTopAtTheRightEdge) {
  Image image = rgba_image(640, 360);
  ColorScale scale{"density", 0, 1, {}};
  for (int i = 0; i < 8; ++i) scale.colors.emplace_back(0.01, (i + 1) / 16.0, 0.02);
  ASSERT_TRUE(draw_color_bar(image, scale, {}));
  int last_y = 360;
  for (const glm::dvec3& color : scale.colors) {
    EXPECT_GE(count(image, color), 100) << color.y;
    int y = 0;
    while (
        y < 360 &&
        count({640,
               1,
               {{"", {}, {image.rgba().begin() + y * 2560, image.rgba().begin() + (y + 1) * 2560}}},
               {}},
              color) == 0)
      ++y;
    EXPECT_LT(y, last_y);
    last_y = y;
  }
  const int strip = color_bar_strip({640, 360});
  EXPECT_LT(strip, 640 / 6);
  for (int y = 0; y < 360; ++y)
    for (int x = 0; x < 640 - strip; ++x)
      EXPECT_EQ(image.rgba()[std::size_t(4 * (640 * y + x) + 3)], 0);  // what is beside the strip
  EXPECT_FALSE(draw_color_bar(image = rgba_image(40, 30), scale, {}));
  EXPECT_EQ(color_bar_strip({40, 30}), 0);
}

TEST(ColorBar, LongTextStaysInTheStrip) {
  Image image = rgba_image(640, 360);
  const ColorScale scale{"a grid of quite a long name", -1.2345e-7, 9.87654e-7, {glm::dvec3(0.5)}};
  ASSERT_TRUE(draw_color_bar(image, scale, {}));
  const int strip = color_bar_strip({640, 360});
  const int edge = int(std::lround(0.6 * strip / 7.0));  // the margin
  for (int y = 0; y < 360; ++y)
    for (int x : {640 - strip - 1, 640 - edge + 1, 639})
      EXPECT_EQ(image.rgba()[std::size_t(4 * (640 * y + x) + 3)], 0) << x << "," << y;
}

/// Rows of the picture in which a label's tick is, from the bar's lower end in parts of it.
std::vector<double> ticks(const ColorScale& scale) {
  Image image = rgba_image(1600, 2000);
  EXPECT_TRUE(draw_color_bar(image, scale, {}));
  const int strip = color_bar_strip({1600, 2000}), size = int(std::lround(strip / 7.0));
  const int x = 1600 - strip + int(std::lround(0.6 * strip / 7.0)) + size + 2;  // beside the bar
  std::vector<double> rows;
  for (int y = 1999, last = 0; y >= 0; --y) {
    const bool white = image.rgba()[std::size_t(4 * (1600 * y + x))] > 0.5f;
    if (white && last != y + 1) rows.push_back(y);
    if (white) last = y;
  }
  const double first = rows.front(), height = first - rows.back();
  for (double& row : rows) row = (first - row) / height;
  return rows;
}

TEST(ColorBar, OfLogarithmsHasTicksAtDecades) {
  ColorScale scale{"x", 1e-2, 1e4, {glm::dvec3(0.01)}, {ValueScale::Kind::log, 1e-3}};
  const auto expect = [&](const std::vector<double>& wanted) {
    const std::vector<double> found = ticks(scale);
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 2e-3);
  };
  expect({0, 1 / 6.0, 2 / 6.0, 3 / 6.0, 4 / 6.0, 5 / 6.0, 1});
  scale.max = 0.1;  // one decade has its 2 and 5 too
  expect({0, std::log10(2), std::log10(5), 1});
  scale = {"x", -100, 100, {glm::dvec3(0.01)}, {ValueScale::Kind::symlog, 10}};
  expect({0, 0.5 - std::log10(6) / std::log10(11) / 2, 0.5 - std::log10(3) / std::log10(11) / 2,
          0.5 - std::log10(2) / std::log10(11) / 2, 0.5, 0.5 + std::log10(2) / std::log10(11) / 2,
          0.5 + std::log10(3) / std::log10(11) / 2, 0.5 + std::log10(6) / std::log10(11) / 2, 1});
}

TEST(TextPicture, HasTheLettersOfUnits) {
  const auto width = [](const char* text) { return image_io::text_picture(text, 40).width; };
  EXPECT_LT(width("°"), width("W"));  // one letter, not the two of its bytes
  EXPECT_NEAR(width("µm"), width("um"), 2);
}

TEST(ScaleBar, HasARoundLengthOfAtMostAQuarterOfThePicture) {
  Scene scene = blobs_scene();
  scene.resolution = {320, 180};
  for (const double width : {0.03, 0.79, 0.81, 3.9, 4.1, 7000.0}) {
    scene.projection = Projection::orthographic;
    scene.ortho_width = width;
    const ScaleBar bar = scale_bar(Session(scene).view());
    EXPECT_NEAR(bar.length, bar.width * width, 1e-12 * width);
    EXPECT_LE(bar.width, 0.25 * (1 + 1e-9));
    EXPECT_GT(bar.width, 0.25 / 2.5 * (1 - 1e-9));  // from 2 to 5 is the longest way
    const double digits = bar.length / std::pow(10, std::floor(std::log10(bar.length) + 1e-9));
    EXPECT_LT(std::min({std::abs(digits - 1), std::abs(digits - 2), std::abs(digits - 5)}), 1e-9);
  }
}

// Two points as far apart as the bar is long, in the plane through the middle, are as far apart in
// the picture.
TEST(ScaleBar, IsAsLongAsALengthInTheMiddle) {
  Scene scene = blobs_scene();
  scene.resolution = {640, 360};
  scene.azimuth = 30;
  const View view = Session(scene).view();
  const ScaleBar bar = scale_bar(view);
  const glm::dvec3 middle = glm::mix(view.subject->box_min, view.subject->box_max, 0.5);
  const auto column = [&](const glm::dvec3& at) {
    const glm::dvec3 way = at - view.camera.position;
    return glm::dot(way, view.camera.right) / glm::dot(way, view.camera.forward) /
           (2 * view.camera.half_width);
  };
  EXPECT_NEAR(column(middle + bar.length * view.camera.right) - column(middle), bar.width, 1e-9);
  Image image = rgba_image(640, 360);
  ASSERT_TRUE(draw_scale_bar(image, bar, {}));
  int longest = 0;  // run of white pixels in a row
  for (int y = 180; y < 360; ++y)
    for (int x = 0, run = 0; x < 640; ++x) {
      run = image.rgba()[std::size_t(4 * (y * 640 + x))] > 0.5f ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  EXPECT_NEAR(longest, bar.width * 640, 0.5);
  EXPECT_FALSE(draw_scale_bar(image = rgba_image(40, 30), bar, {}));
}

TEST(ColorBar, ListsLabels) {
  View view;
  view.scene.colormap = Colormap::labels;
  DenseField labels("labels", {8, 8, 8}, 1, glm::dmat4(1));
  std::vector<float> values(512, 1);
  std::fill(values.begin(), values.begin() + 64, 7.0f);
  std::fill(values.begin() + 64, values.begin() + 128, 200.0f);
  labels.add(values);
  view.medium.density = std::make_shared<const Field>(labels.finish());
  const ColorScale scale = *color_scale(view);
  EXPECT_EQ(bar_values(scale), (std::vector<double>{1, 7, 200}));
  for (const double label : {1.0, 7.0, 200.0}) {
    const auto row = std::size_t(bar_place(scale, label) * double(scale.colors.size()));
    EXPECT_EQ(scale.colors[row], label_color(label)) << label;
  }
}

}  // namespace
}  // namespace psivox
