// Rays and atlases beyond the limits of one pass, one buffer, one table or one tile give the same
// picture.

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "march_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

class MarchLimits : public GpuTest {};

/// Expects every bit of the picture and of every layer to be equal.
void expect_identical(const std::string& what, const Image& a, const Image& b) {
  difference(what, a, b);
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    ASSERT_EQ(a.layers[i].values.size(), b.layers[i].values.size());
    std::size_t bits = 0;
    for (std::size_t k = 0; k < a.layers[i].values.size(); ++k)
      bits += 0 != std::memcmp(&a.layers[i].values[k], &b.layers[i].values[k], sizeof(float));
    EXPECT_EQ(bits, 0u) << what << ", layer '" << a.layers[i].name << "'";
  }
}

/// Like expect_identical, but allows an ulp of 1 if L is not constant: a ray that continues in
/// another pass refreshes its transmittance from the optical depth at other turns.
void expect_continued(const std::string& what, const View& view, const Image& one,
                      const Image& many) {
  if (view.medium.source == LuminanceSource::constant) return expect_identical(what, one, many);
  EXPECT_LE(difference(what, one, many).max, 1.2e-7);
  ASSERT_EQ(one.layers.size(), many.layers.size());
  // Where a pass begins at a face, the value there is that of the node behind it. That rounds
  // optical depths between 2 and 4, by a unit in the last place here and there.
  const double rounding = what == "corrected ends" ? 2 * 0x1p-22 : 0;
  for (std::size_t i = 1; i < one.layers.size(); ++i) {
    const std::vector<float>&a = one.layers[i].values, &b = many.layers[i].values;
    ASSERT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
      most = std::max(
          most, a[k] == b[k] ? 0 : std::abs(double(a[k]) - double(b[k])) / std::abs(double(a[k])));
    EXPECT_LE(most, rounding) << what << one.layers[i].name;
  }
}

Scene near_limits(int side = 40) { return oblique(side, 0.12); }

Field three_glows() {
  return make_vector_field({{-14, -9, -6}, {30, 32, 33}}, [](glm::ivec3 v) {
    return glm::vec3(noise(v), 0.5f * blobs_at(glm::dvec3(v)), 0.5f);
  });
}

/// The views that test the limits: a march of each kind, with luminance of each kind.
std::vector<std::pair<std::string, View>> views() {
  const auto density = share(mixed()), colour = share(three_glows());
  return {
      {"cells, constant", view_of(near_limits(), density)},
      {"cells, vector", make_view(near_limits(), density, colour)},
      {"corrected ends", view_of(looking(with(near_limits(), Integrator::psi_balanced, 0.8),
                                         {12.3, 9.1, 10.7}, {-20, 14, 2}),
                                 density, Glow::density)},
      {"ends", view_of(with(near_limits(), Integrator::psi_balanced, 0.8), density, Glow::density)},
      {"middles", make_view(with(near_limits(), Integrator::midpoint, 3.0), density, colour)}};
}

// --- passes --------------------------------------------------------------------------------------

TEST_F(MarchLimits, PassesOfSevenTurnsAreOnePass) {
  for (const auto& [name, view] : views()) {
    const MediumAtlas atlases = build_medium_atlas(view);
    // A pass may look up its first values again, so counts are not compared.
    const RenderOptions options{.depth = true, .transmittance = true, .progress = {}};
    const RenderResult one = render_gl(view, atlases, {.render = options});
    const RenderResult many =
        render_gl(view, atlases, {.render = options, .limits = {.turns_per_pass = 7}});
    EXPECT_EQ(one.stats.passes, 1);
    EXPECT_GT(many.stats.passes, 2) << name;
    expect_content(one.image);
    expect_continued(name, view, one.image, many.image);
  }
}

TEST_F(MarchLimits, CountsSurvivePasses) {
  for (const double step : {0.0, 0.8}) {
    Scene scene = near_limits();
    if (step > 0) scene.step = step;
    const View view = view_of(scene, mixed(), Glow::density);
    const MediumAtlas atlases = build_medium_atlas(view);
    const RenderResult one = render_gl(view, atlases, {.render = all_layers});
    const RenderResult many =
        render_gl(view, atlases, {.render = all_layers, .limits = {.turns_per_pass = 7}});
    EXPECT_EQ(one.stats.steps, many.stats.steps);
    EXPECT_GT(one.stats.steps, 0u);
    expect_continued(step > 0 ? "uniform" : "cells", view, one.image, many.image);
  }
}

/// A rod of 70,000 voxels alternating between 0 and 1, seen end-on.
Field rod() {
  return make_field({{0, 0, 0}, {69'999, 2, 2}}, [](glm::ivec3 v) { return float(v.x & 1); });
}

TEST_F(MarchLimits, CellsBeyondTheDriversLoopLimit) {
  // Mesa 22.3's llvmpipe silently stops after 65,535 turns.
  Scene scene = looking(small_scene(4), {-1000, 1.1, 0.9}, {0, 1.1, 0.9}, 2.2);
  scene.extinction = 5e-5;
  const auto field = share(rod());
  for (const Glow glow : {Glow::constant, Glow::density}) {
    const View view = view_of(scene, field, glow);
    const RenderResult gpu = render_gl(view, build_medium_atlas(view), {.render = all_layers});
    EXPECT_GT(gpu.stats.passes, 1);
    EXPECT_GE(gpu.stats.steps, (glow == Glow::constant ? 1u : 2u) * 16u * 70'000u);
    expect_content(gpu.image, 0.5, 0.95);
    const Comparison to_double =
        difference("rod, cells, march in double", gpu.image, double_picture(view));
    // Sums are compensated, and T is taken anew every 16 turns: 16 roundings of at most 6e-8.
    EXPECT_LE(to_double.max, 1e-6);
    if (glow == Glow::constant) {
      EXPECT_LE(difference("rod, cells, reference", gpu.image, render_reference(view).image).max,
                1e-6);
    }
  }
}

TEST_F(MarchLimits, StepsBeyondTheDriversLoopLimit) {
  Scene scene = looking(small_scene(6), {-30, 1.1, 0.9}, {0, 1.1, 0.9}, 2.2);
  scene.extinction = 0.03;
  const auto field = share(
      make_field({{0, 0, 0}, {69, 2, 2}}, [](glm::ivec3 v) { return 0.5f + 0.5f * noise(v); }));
  for (const Integrator rule : {Integrator::psi_balanced, Integrator::porter_duff}) {
    const View view = view_of(with(scene, rule, 0.001), field, Glow::density);
    const RenderResult gpu = render_gl(view, build_medium_atlas(view), {.render = all_layers});
    EXPECT_GT(gpu.stats.passes, 1);
    EXPECT_GE(gpu.stats.steps, 36u * 69'000u);
    expect_content(gpu.image, 0.3, 0.95);
    const Comparison c = difference(std::string("70,000 steps, ") + info(rule).name, gpu.image,
                                    double_picture(view));
    EXPECT_LE(c.max, 1e-6);  // as in cells
    EXPECT_LE(difference("  against the reference", gpu.image, render_reference(view).image).max,
              1e-4);
  }
}

TEST_F(MarchLimits, TheShortestStepMovesEveryRay) {
  Scene scene = looking(small_scene(2), {-30, 1.1, 0.9}, {0, 1.1, 0.9}, 2.2);
  scene.extinction = 0.03;
  const auto field = share(
      make_field({{0, 0, 0}, {59, 2, 2}}, [](glm::ivec3 v) { return 0.5f + 0.5f * noise(v); }));
  const glm::dvec3 size(field->domain().max - field->domain().min);
  const double least = glm::length(size) / (1 << 24);
  const auto refusal = [&](double step) {
    return usage_error(
        [&] { check_sampling(view_of(with(scene, Integrator::midpoint, step), field)); });
  };
  EXPECT_TRUE(has(refusal(0.99 * least), "too short for the float32 numbers"));
  EXPECT_EQ(refusal(least), "no error");
  const View view = view_of(with(scene, Integrator::midpoint, least), field);
  const RenderResult gpu = render_gl(view, build_medium_atlas(view));
  EXPECT_EQ(gpu.stats.stuck, 0u);
  expect_content(gpu.image, 0.3, 0.95);
  EXPECT_LE(difference("2^24 steps", gpu.image, render_reference(view).image).max, 1e-3);
}

// --- tables and buffers --------------------------------------------------------------------------

TEST_F(MarchLimits, ManyTexelBuffersAreOneAndTheHostsArray) {
  for (const auto& [name, view] : views()) {
    const MediumAtlas atlases = build_medium_atlas(view);
    // The larger grid takes eight buffers of whole bricks; a shader has at least 16 texture units.
    const std::size_t bricks =
        std::max(atlases.density.bricks.size(),
                 atlases.luminance ? atlases.luminance->bricks.size() : std::size_t{0});
    const std::uint64_t limit = (bricks / 8 + 1) * 729 + 300;
    ASSERT_GT(bricks, 80u);
    ASSERT_LE(atlases.density.pages.entries.size(), limit);
    const Image image = render_gl(view, atlases).image;
    for (const gl::TestLimits& limits :
         {gl::TestLimits{.buffer_texels = limit}, gl::TestLimits{.copies_texels = true}})
      expect_identical(name, image,
                       render_gl(view, atlases, {.render = {}, .limits = limits}).image);
  }
}

/// The view's atlases with at most `top` entries in the top page tables.
MediumAtlas deep_atlas(const View& view, std::uint64_t top) {
  MediumAtlas atlas;
  AtlasOptions options = density_options(view);
  options.top_entries = top;
  atlas.density = build_atlas(*view.medium.density, options);
  if (view.medium.luminance)
    atlas.luminance = build_atlas(*view.medium.luminance, {.top_entries = top});
  return atlas;
}

TEST_F(MarchLimits, DeepPageTablesAreFlatOnes) {
  for (const auto& [name, view] : views()) {
    const MediumAtlas flat = build_medium_atlas(view);
    const Image expected = render_gl(view, flat).image;
    for (const std::uint64_t top : {20u, 1u}) {
      const MediumAtlas deep = deep_atlas(view, top);
      EXPECT_EQ(deep.density.pages.levels, top == 1 ? 3 : 2);
      const Image image = render_gl(view, deep).image;
      const Comparison c = difference(name + " levels " + std::to_string(deep.density.pages.levels),
                                      expected, image);
      // Empty runs end at other faces, where a ray may take its next cell from another axis:
      // rounding of t, a few 1e-7.
      EXPECT_LE(c.max, 2e-6) << name;
      EXPECT_LE(difference("  march in double", image, double_picture(view)).max, 2e-5);
    }
  }
}

TEST_F(MarchLimits, HugeSparseBoxes) {
  // Three voxels, 100,000 apart, each seen close: the walk skips what lies between.
  auto values = std::make_shared<std::vector<float>>(512, 0.0f);
  (*values)[static_cast<std::size_t>((4 * 8 + 4) * 8 + 4)] = 1;
  Field field;
  field.name = "density";
  for (const glm::ivec3 origin : {glm::ivec3(0), glm::ivec3(99'992), glm::ivec3(48'000, 8, 96'000)})
    field.leaves.push_back({origin, values->data()});
  field.active_box = {glm::ivec3(4), glm::ivec3(99'996)};
  field.storage = values;
  const auto shared = share(field);
  for (const glm::dvec3 voxel : {glm::dvec3(4), {48'004, 12, 96'004}, {99'996, 99'996, 99'996}}) {
    Scene scene = looking(small_scene(16), voxel + glm::dvec3(0, 5, 30), voxel, 2.2);
    scene.extinction = 2;
    const View view = view_of(scene, shared);
    const Image image = gl_picture(view);
    expect_content(image, 0.1);
    // Voxel coordinates reach 50,000 from the middle of the domain. An ulp of float32 there is
    // 1/256 voxel, which limits how accurately the GPU can place a ray. The march in double is
    // exact.
    EXPECT_LE(difference("double", double_picture(view), render_reference(view).image).max, 1e-7);
    EXPECT_LE(difference("GPU", image, render_reference(view).image).max, 2.0 * 3 / 256);
  }
}

// --- tiles ---------------------------------------------------------------------------------------

TEST_F(MarchLimits, TilesHaveNoSeams) {
  // 300 x 200 pixels: a tile of 256 and a rest; resumable pictures start with tiles of 64.
  Scene scene = near_limits();
  scene.resolution = {300, 200};
  for (const double step : {0.0, 1.3}) {
    if (step > 0) scene.step = step;
    const View view = view_of(scene, mixed(), Glow::density);
    const MediumAtlas atlases = build_medium_atlas(view);
    const RenderOptions options{.depth = true, .transmittance = true, .progress = {}};
    const RenderResult large = render_gl(view, atlases, {.render = options});
    const RenderResult small =
        render_gl(view, atlases, {.render = options, .limits = {.turns_per_pass = 60}});
    expect_content(large.image);
    expect_continued("tiles of 256 and 64", view, large.image, small.image);
    expect_arithmetic("march in double, no tiles", large.image, double_picture(view));
  }
}

TEST_F(MarchLimits, TheFirstTileHasTheCentre) {
  const View view = view_of(near_limits(300), mixed());
  std::optional<DoneTile> first;
  const auto tile = [&](const DoneTile& done) {
    if (!first) first = done;
  };
  render_gl(view, build_medium_atlas(view), {.render = {.tile = tile, .tile_ms = 25}});
  ASSERT_TRUE(first);
  EXPECT_LT(first->width, 300);
  EXPECT_LE(first->x, 150);
  EXPECT_LE(first->y, 150);
  EXPECT_GE(first->x + first->width, 150);
  EXPECT_GE(first->y + first->height, 150);
}

TEST_F(MarchLimits, AnEmptyFieldIsAnEmptyPicture) {
  Scene scene = looking(small_scene(8), {20, 20, 60}, {4, 4, 4});
  for (const double step : {0.0, 1.0}) {
    if (step > 0) scene.step = step;
    const Image image = gl_picture(
        view_of(scene, make_field({{0, 0, 0}, {9, 9, 9}}, [](glm::ivec3) { return 0; })));
    for (const float v : image.rgba()) EXPECT_EQ(v, 0);
  }
}

TEST_F(MarchLimits, MoreTexturesThanTheDeviceHasIsALimitByName) {
  // A column of 400 bricks, one a buffer; its table of 404 entries fits one.
  const View view = view_of(
      small_scene(8), make_field({{0, 0, 0}, {7, 7, 799}}, [](glm::ivec3 v) { return noise(v); }));
  MediumAtlas atlas{build_atlas(*view.medium.density), {}, {}, {}};
  ASSERT_GE(atlas.density.bricks.size(), 400u);
  const Limited limited({.buffer_texels = 729});
  const std::string message = error_of(ExitCode::graphics, [&] {
    Gpu::renderer()->upload(atlas);
    Gpu::renderer()->render(view);
  });
  EXPECT_TRUE(has(message, "textures, and the device has"));
}

// No picture is silent: whatever its size, no more than a tile passes between two reports. A tile
// has 1024^2 pixels at most (gl/picture_pass.cpp), and fewer where it takes long.
TEST_F(MarchLimits, EveryTileOfALargePictureIsReported) {
  Scene scene = looking(small_scene(40), {11, 12, 11}, {300, 60, 70});  // from inside: all is drawn
  scene.resolution = {4096, 768};
  scene.step = 20;  // quick
  std::vector<double> reports{0};
  RenderOptions options;
  options.progress = [&](double fraction) { reports.push_back(fraction); };
  const View view = view_of(scene, mixed());
  render_gl(view, build_medium_atlas(view), {.render = options});
  const double pixels = 4096 * 768;
  double widest = 0;
  for (std::size_t i = 1; i < reports.size(); ++i)
    widest = std::max(widest, reports[i] - reports[i - 1]);
  EXPECT_LE(widest, 1024 * 1024 / pixels + 1e-9);
  EXPECT_TRUE(std::ranges::is_sorted(reports));
  EXPECT_EQ(reports.back(), 1);
}

}  // namespace
}  // namespace psivox
