// Bricks in codes that have the rows of their visible cells alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "code_cases.h"
#include "field_voxels.h"
#include "light_cases.h"
#include "made_fields.h"
#include "march/atlas_march.h"
#include "march_cases.h"
#include "scratch.h"

namespace psivox {
namespace {

/// A slope along x from 0 to 1, a little rough, with zeros beside it.
Field slope() {
  return make_field({{-12, -9, -5}, {55, 22, 20}}, [](glm::ivec3 v) {
    const bool none = v.y > 10 && v.x % 16 > 3;
    return none ? 0.0f : std::clamp(float(v.x) / 48 + 0.02f * noise(v), 0.0f, 1.0f);
  });
}

/// Bars of noise, and values between 0.4 and 0.5 beside them.
Field bars() {
  return make_field({{0, 0, 0}, {63, 31, 31}}, [](glm::ivec3 v) {
    const bool bar = v.x % 16 >= 2 && v.x % 16 <= 5;
    return bar ? noise(v) : 0.4f + 0.1f * noise(v);
  });
}

/// Boxes if they save anything to speak of.
MediumAtlas in_turn(MediumAtlas atlas) {
  atlas.density.most_boxes = 0.9;
  return coded_in_turn(atlas);
}

MediumAtlas without_boxes(MediumAtlas atlas) {
  atlas.density.visible = {};
  return atlas;
}

/// What the march makes of bricks in codes, in double.
class Decoder {
 public:
  explicit Decoder(const BrickAtlas& atlas) {
    march_.grids[density_grid] = &atlas;
    march_.density.table_min = atlas.pages.min;
    march_.density.table_size = atlas.pages.top_size;
    march_.density_levels = atlas.pages.levels;
    march_.octants = atlas.pages.octants;
    march_.coded = true;
    march_.one_width = -1;
    march_.code_unit = atlas.code_unit;
  }

  /// The cell's corners, z fastest; and the step of its brick.
  std::array<double, 8> corners(const glm::ivec3& cell, double& step) {
    const auto node = march_.find_stored(density_grid, cell);
    const auto c = march_.fetch_corners(density_grid, node, march_.in_brick(cell));
    step = c.scale;
    std::array<double, 8> values{};
    for (int i = 0; i < 4; ++i) {
      values[std::size_t(i)] = c.from + c.scale * c.lo[i];
      values[std::size_t(i) + 4] = c.from + c.scale * c.hi[i];
    }
    return values;
  }

 private:
  glsl::AtlasMarch march_;
};

ValueRange range_of(const std::array<double, 8>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return {float(*least), float(*greatest)};
}

struct Look {
  std::string name;
  Visibility visible;
  /// Whether values may be those of a cell that is not visible, each `error` off.
  bool (*hidden)(const ValueRange& range, float error);
};

const Look looks[] = {
    {"anything",
     {},
     [](const ValueRange& r, float e) { return r.min >= -e / 50 && r.max <= e / 50; }},
    {"above 0.4", [](const ValueRange& r, const ValueRange&) { return r.max > 0.4f; },
     [](const ValueRange& r, float e) { return r.max <= 0.4f + e; }},
    {"around 0.4",
     [](const ValueRange& r, const ValueRange&) { return r.min < 0.5f && r.max > 0.3f; },
     [](const ValueRange& r, float e) { return r.max <= 0.3f + e || r.min >= 0.5f - e; }}};

TEST(CodeBoxes, VisibleCellsHaveTheirValuesAndOthersStayHidden) {
  const Field field = slope();
  const FieldVoxels voxels(field);
  for (const Look& look : looks) {
    MediumAtlas atlas;
    atlas.density = build_atlas(field, {.visible = look.visible, .mark_octants = true});
    const BrickAtlas codes = in_turn(atlas).density;
    ASSERT_NE(codes.code_unit, code_words) << look.name;
    Decoder decoder(codes);
    int shown = 0, replaced = 0;
    for (const glm::ivec3& place : codes.places)
      for (int i = 0; i < 512; ++i) {
        const glm::ivec3 cell = 8 * place + glm::ivec3(i >> 6, i >> 3 & 7, i & 7);
        std::array<double, 8> truth{};
        for (int k = 0; k < 8; ++k)
          truth[std::size_t(k)] = voxels(cell + glm::ivec3(k >> 2, k >> 1 & 1, k & 1)).x;
        double step = 0, off = 0;
        const std::array<double, 8> values = decoder.corners(cell, step);
        for (std::size_t k = 0; k < 8; ++k) off = std::max(off, std::abs(values[k] - truth[k]));
        const double error = 0.51 * step + 1e-7;
        if (atlas.density.visible(range_of(truth), {})) {
          ASSERT_LE(off, error) << look.name;
          ++shown;
        } else {
          ASSERT_TRUE(look.hidden(range_of(values), float(error))) << look.name;
          replaced += off > error;
        }
      }
    EXPECT_GT(shown, 2000) << look.name;
    if (look.visible) {
      EXPECT_GT(replaced, 500) << look.name;
    }
  }
}

TEST(CodeBoxes, BricksWithoutHiddenLayersAreWhole) {
  MediumAtlas atlas;
  atlas.density = build_atlas(
      slope(),
      {.visible = [](const ValueRange&, const ValueRange&) { return true; }, .mark_octants = true});
  EXPECT_EQ(in_turn(atlas).density.code_unit, code_words);
}

/// A picture of boxes and one of whole bricks, of the same codes.
Comparison boxes_and_whole(const std::string& what, const View& view, const MediumAtlas& atlas) {
  const MediumAtlas boxes = in_turn(atlas), whole = in_turn(without_boxes(atlas));
  EXPECT_NE(boxes.density.code_unit, code_words) << what;
  EXPECT_EQ(whole.density.code_unit, code_words) << what;
  EXPECT_LE(double(boxes.density.size.texel_bytes), 0.9 * double(whole.density.size.texel_bytes));
  const Image picture = render_double(view, boxes).image;
  expect_content(picture, 0.01);
  return difference(what, picture, render_double(view, whole).image);
}

Scene above() { return looking(small_scene(48), {-80, 70, 60}, {20, 6, 8}); }

constexpr double rounding = 1e-9;  // of float32's offsets, by which a code of 0 may miss 0

TEST(CodeBoxes, ShowWhatWholeBricksShow) {
  for (const bool cells : {true, false})
    for (const Glow glow : {Glow::constant, Glow::density}) {
      const View view = view_of(by(above(), cells), slope(), glow);
      EXPECT_LE(boxes_and_whole("no function", view, build_medium_atlas(view)).max, rounding);
    }
  Scene maxima = above();
  maxima.mode = Mode::mip;
  const View view = view_of(maxima, slope());
  EXPECT_LE(boxes_and_whole("maxima", view, build_medium_atlas(view)).max, rounding);
}

TEST(CodeBoxes, ShowTheSameLight) {
  for (const bool colours : {false, true}) {
    Scene scene = by(above(), true);
    scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}};
    if (colours) scene.lights.push_back({{-1, -0.2, 0.5}, {0.2, 0.5, 1}});
    const View view = lit_in_double(view_of(scene, slope()));
    const MediumAtlas atlas = build_medium_atlas(view);
    ASSERT_TRUE(atlas.paired);
    EXPECT_LE(boxes_and_whole(colours ? "coloured" : "light", view, atlas).max, rounding);
  }
}

std::string boxes_function(const std::string& name, const std::string& points) {
  return test::write_bytes(name + ".json", "{\"points\": [" + points + "]}").string();
}

/// Attenuates above a value alone; and everywhere but in a band, at 0 too.
std::string above_a_value() {
  return boxes_function("above", R"({"value": 0, "attenuation": 0, "color": [0, 1, 0]},
                                    {"value": 0.4, "attenuation": 0, "color": [1, 0, 0]},
                                    {"value": 1, "attenuation": 2, "color": [0, 0, 1]})");
}
std::string outside_a_band() {
  return boxes_function("outside", R"({"value": 0, "attenuation": 0.01, "color": [1, 0.5, 0]},
                                      {"value": 0.2, "attenuation": 0, "color": [0, 1, 0]},
                                      {"value": 0.7, "attenuation": 0, "color": [0, 1, 1]},
                                      {"value": 1, "attenuation": 2, "color": [0, 0, 1]})");
}

// A value may be off by half a step, and so be visible in a cell that is not: in boxes over other
// lengths than in whole bricks. With codes of 7 bits that is 0.004 of the range.
TEST(CodeBoxes, ShowWhatAFunctionShows) {
  Scene scene = by(above(), true);
  scene.transfer_function = above_a_value();
  const View steep = view_of(scene, slope());
  EXPECT_LE(boxes_and_whole("above", steep, build_medium_atlas(steep)).max, 2e-3);
  scene.transfer_function = outside_a_band();
  const View banded = view_of(scene, bars());
  EXPECT_LE(boxes_and_whole("outside", banded, build_medium_atlas(banded)).max, 2e-3);
}

// A segment that begins in a hidden cell takes the colour there, which is no more than its face's
// in a box. That is less than what the march misses by steps of this length.
TEST(CodeBoxes, StepsFromHiddenCellsMissLessThanTheMarch) {
  for (const bool light : {false, true}) {
    Scene scene = above();
    scene.transfer_function = above_a_value();
    if (light) scene.lights = {{{-1, 1, -0.5}, {1, 1, 1}}};
    const auto view_by = [&](bool cells) {
      const View view = view_of(by(scene, cells), slope());
      return light ? lit_in_double(view) : view;
    };
    const View exact = view_by(true), steps = view_by(false);
    const MediumAtlas atlas = build_medium_atlas(steps);
    const Image picture = render_double(steps, atlas).image;
    const double missed =
        difference("steps", picture, render_double(exact, build_medium_atlas(exact)).image).rms;
    const double differs = boxes_and_whole("boxes", steps, atlas).rms;
    EXPECT_LE(differs, missed / 100);
    EXPECT_GT(differs, 0);
  }
}

class CodeBoxesOnTheGpu : public GpuTest {};

TEST_F(CodeBoxesOnTheGpu, AreTheMarchInDouble) {
  for (const bool cells : {true, false})
    for (const bool light : {false, true}) {
      Scene scene = by(above(), cells);
      if (light) scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}, {{-1, -0.2, 0.5}, {0.2, 0.5, 1}}};
      View view = view_of(scene, slope());
      if (light) view = lit_in_double(view);
      const MediumAtlas boxes = in_turn(build_medium_atlas(view));
      ASSERT_NE(boxes.density.code_unit, code_words);
      expect_arithmetic("boxes", view, boxes, 0.01);
    }
}

TEST_F(CodeBoxesOnTheGpu, HaveStepsOfTheirOwn) {
  const View view = view_of(by(above(), false), slope());
  const MediumAtlas boxes = in_turn(build_medium_atlas(view));
  std::vector<float> parts(boxes.density.bricks.size());
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = i % 2 ? 0.25f : 1.0f;
  const RenderOptions options{.brick_steps = std::make_shared<const std::vector<float>>(parts)};
  const Image gpu = render_gl(view, boxes, {.render = options}).image;
  const Image whole =
      render_double(view, in_turn(without_boxes(build_medium_atlas(view))), options).image;
  EXPECT_LE(difference("steps", gpu, whole).max, 2e-5);
  EXPECT_GE(compare_images(gpu, render_double(view, boxes).image).max, 1e-4) << "one step";
}

}  // namespace
}  // namespace psivox
