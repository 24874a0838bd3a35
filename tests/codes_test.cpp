// Bricks in codes: their values, their pictures, and how a tolerance chooses them.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "atlas/brick_code.h"
#include "blobs_scene.h"
#include "field/leaf_values.h"
#include "light_cases.h"
#include "made_fields.h"
#include "march/march_double.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

Scene oblique() { return psivox::oblique(64, 0.12); }

Scene by(Scene scene, bool cells) {
  if (cells)
    scene.integrator = Integrator::cell_exact;
  else
    scene.step = 0.7;
  return scene;
}

/// Neighbouring bricks differ.
std::vector<CodeWidth> widths_in_turn(const MediumAtlas& atlas) {
  std::vector<CodeWidth> widths(atlas.density.bricks.size());
  for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = CodeWidth(i % 3);
  return widths;
}

MediumAtlas coded_in_turn(const MediumAtlas& atlas) { return coded(atlas, widths_in_turn(atlas)); }

constexpr TexelType types[] = {TexelType::code7, TexelType::code12, TexelType::code16};
constexpr int bits[] = {7, 12, 16};

double step_of(const BrickAtlas& atlas, std::size_t slot) {
  const std::uint64_t head = atlas.codes[std::size_t(atlas.code_places[slot]) * code_words];
  return double(std::bit_cast<float>(std::uint32_t(head >> 32) & ~code_width_bits));
}

/// The brick's value at a voxel, from the word that begins with it or ends with it.
double decoded(const BrickAtlas& atlas, std::size_t slot, int row, int z, bool as_end) {
  const std::uint64_t* words =
      atlas.codes.get() + std::size_t(atlas.code_places[slot]) * code_words;
  const auto offset = std::bit_cast<float>(std::uint32_t(words[0]));
  const auto step_bits = std::uint32_t(words[0] >> 32);
  const int width = int(step_bits & 3), cells = 8 >> width;
  const int cell = as_end ? z - 1 : z;
  const std::uint64_t word = words[1 + row * (1 << width) + cell / cells];
  const std::uint64_t code =
      word >> (bits[width] * (cell % cells + as_end)) & ((std::uint64_t{1} << bits[width]) - 1);
  return double(offset) + step_of(atlas, slot) * double(code);
}

void expect_half_steps(const BrickAtlas& full, const BrickAtlas& codes,
                       const std::vector<CodeWidth>& widths) {
  const BrickCodes by = brick_codes(full, widths);
  for (std::size_t slot = 0; slot < full.bricks.size(); ++slot) {
    const BrickStats& brick = full.bricks[slot];
    const double step = step_of(codes, slot);
    // half a step, float32's rounding of a code of 16 bits, and of the offset
    const double bound =
        (0.5 + 65536 * 1.2e-7) * step + 6e-8 * std::max(std::abs(brick.min), std::abs(brick.max));
    for (int i = 0; i < brick_texels; ++i) {
      const float value = full.texels[slot * brick_texels + std::size_t(i)];
      for (const bool as_end : {false, true}) {
        const int z = i % 9;
        if (as_end ? z == 0 : z == 8) continue;
        const double coded = decoded(codes, slot, i / 9, z, as_end);
        ASSERT_LE(std::abs(coded - double(value)), bound) << slot << ' ' << i;
        ASSERT_EQ(coded, by.own[slot].rounded(value)) << slot << ' ' << i;
        if (value == 0) {
          ASSERT_NEAR(coded, 0, 0.01 * step);
        }
      }
    }
  }
}

Field signed_noise() {
  return make_field({{-9, 4, 0}, {20, 19, 17}}, [](glm::ivec3 v) {
    return v.x < 0 ? 1e30f * (noise(v) - 0.5f) : v.y < 12 ? 1e-30f * noise(v) : 5 - 9 * noise(v);
  });
}

TEST(Codes, EveryValueIsWithinHalfAStep) {
  for (const Field& field : {mixed(), signed_noise()}) {
    MediumAtlas atlas;
    atlas.density = build_atlas(field);
    std::uint64_t before = 0;
    for (const TexelType type : types) {
      const CodeWidths widths = fixed_widths(atlas, type);
      const BrickAtlas codes = coded(atlas.density, *widths);
      expect_half_steps(atlas.density, codes, *widths);
      EXPECT_EQ(codes.texels, nullptr);
      EXPECT_EQ(codes.size.texel_bytes, coded_bytes(*widths));
      EXPECT_GT(codes.size.texel_bytes, before);
      before = codes.size.texel_bytes;
    }
  }
}

// A cloud's greatest value often fills its inside. By steps that know nothing of it, it would be
// off by a quarter of a step on average; by the best of eight random ones, by 1/18.
TEST(Codes, ABricksGreatestValueIsNearlyExact) {
  const BrickAtlas atlas =
      build_atlas(make_field({{0, 0, 0}, {63, 63, 63}}, [](glm::ivec3 v) { return noise(v); }));
  for (std::size_t width = 0; width < std::size(types); ++width) {
    const BrickCodes codes =
        brick_codes(atlas, std::vector<CodeWidth>(atlas.bricks.size(), CodeWidth(width)));
    double sum = 0;
    for (std::size_t slot = 0; slot < atlas.bricks.size(); ++slot) {
      const float most = atlas.bricks[slot].max;
      sum += std::abs(codes.own[slot].rounded(most) - double(most)) / double(codes.own[slot].step);
    }
    EXPECT_LE(sum / double(atlas.bricks.size()), 0.1) << width;
  }
}

class CodedMarch : public GpuTest {};

TEST_F(CodedMarch, GpuIsTheMarchInDouble) {
  for (const bool cells : {true, false})
    for (const Glow glow : {Glow::constant, Glow::density}) {
      const View view = view_of(by(oblique(), cells), mixed(), glow);
      const MediumAtlas codes = coded_in_turn(build_medium_atlas(view));
      ASSERT_TRUE(codes.density.codes);
      expect_arithmetic(cells ? "cells" : "uniform", view, codes);
    }
}

TEST_F(CodedMarch, GpuIsTheMarchInDoubleWithLightBesideTheDensity) {
  for (const bool cells : {true, false})
    for (const bool colours : {true, false}) {
      Scene scene = by(oblique(), cells);
      scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}};
      if (colours) scene.lights.push_back({{-1, -0.2, 0.5}, {0.2, 0.5, 1}});
      const View view = lit_in_double(view_of(scene, mixed()));
      const MediumAtlas atlas = build_medium_atlas(view);
      ASSERT_TRUE(atlas.paired);
      ASSERT_EQ(atlas.luminance->channels, colours ? 3 : 1);
      const std::string what = std::string(cells ? "cells" : "uniform") + (colours ? ", 3" : ", 1");
      expect_arithmetic(what, view, coded_in_turn(atlas));
      // codes of 16 bits are as good as float32, to 1/65535 of a brick's range
      const MediumAtlas fine = coded(atlas, *fixed_widths(atlas, TexelType::code16));
      expect_arithmetic(what + ", one width", view, fine);
      const Image exact = render_double(view, atlas).image;
      EXPECT_LE(difference("  16 bits", render_double(view, fine).image, exact).max, 1e-5);
    }
}

TEST_F(CodedMarch, SeveralBuffersAreOne) {
  const View view = view_of(by(oblique(), true), mixed());
  const MediumAtlas codes = coded_in_turn(build_medium_atlas(view));
  const std::uint64_t limit = codes.density.code_count() / 6 + 729;
  ASSERT_LE(codes.density.pages.entries.size(), limit);
  const Image several =
      render_gl(view, codes, {.render = {}, .limits = {.buffer_texels = limit}}).image;
  EXPECT_EQ(compare_images(render_gl(view, codes).image, several).max, 0);
}

TEST_F(CodedMarch, PartsAreTheWhole) {
  Scene scene = blobs_scene();
  scene.texel = TexelType::code12;
  const Image whole = Session(scene).draw(*Gpu::renderer()).image;
  scene.memory_limit = 600000;
  const Drawn parts = Session(scene).draw(*Gpu::renderer());
  EXPECT_EQ(parts.notices.size(), 1u) << "drawn whole";
  EXPECT_LE(compare_images(whole, parts.image).max, 1e-6);  // as in part_marcher_test
}

Scene asked(double tolerance) {
  Scene scene = oblique();
  scene.early_termination.reset();
  scene.tolerance = tolerance;
  return scene;
}

/// Draws it with codes, if they save bytes, and in float32. Returns the part of float32's bytes
/// that the codes take.
double expect_within(const View& view) {
  const double tolerance = *view.scene.tolerance;
  Session session(view);
  Wish small;
  small.fewest_bytes = true;
  const Drawn drawn = session.draw(*Gpu::renderer(), small);
  // the estimate is of the pilot's rays, the error of all
  EXPECT_LE(drawn.plan->chosen.rms, tolerance);
  const CheckedError error = session.check_error(drawn, 64 * 64);
  EXPECT_LE(error.rms, tolerance);
  EXPECT_LE(error.max, 12.5 * tolerance);  // as docs/notes/decisions.md has it for float32
  Wish full;
  full.scene = view.scene;
  full.scene->texel = TexelType::float32;
  const Drawn exact = session.draw(*Gpu::renderer(), full);
  return double(drawn.atlas.texel_bytes) / double(exact.atlas.texel_bytes);
}

TEST_F(CodedMarch, AToleranceChoosesCodes) {
  for (const bool own : {false, true}) {
    const Glow glow = own ? Glow::density : Glow::constant;
    EXPECT_LE(expect_within(view_of(asked(1e-2), mixed(), glow)), 0.25);
    EXPECT_LE(expect_within(view_of(asked(1e-3), mixed(), glow)), 0.45);
    EXPECT_LE(expect_within(view_of(asked(1e-4), mixed(), glow)), 0.55);
  }
  Scene scene = asked(1e-3);
  scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}};
  EXPECT_LE(expect_within(view_of(scene, mixed())), 0.5);
  scene.lights.clear();
  scene.colormap = Colormap::viridis;
  EXPECT_LE(expect_within(view_of(scene, mixed())), 0.5);
}

TEST_F(CodedMarch, OnlyAPictureOfManyLookUpsPaysForThem) {
  const auto texel_bytes = [](int pixels, TexelType texel) {
    Scene scene = asked(1e-3);
    scene.resolution = {pixels, pixels};
    scene.texel = texel;
    return Session(view_of(scene, mixed())).draw(*Gpu::renderer()).atlas.texel_bytes;
  };
  EXPECT_EQ(texel_bytes(2, TexelType::automatic), texel_bytes(2, TexelType::float32));
  EXPECT_LT(texel_bytes(64, TexelType::automatic), texel_bytes(64, TexelType::float32) / 2);
}

/// The view of a file.
View of_file(bool light, TexelType texel = TexelType::automatic) {
  Scene scene;
  scene.input = PSIVOX_ASSETS "/blobs.vdb";
  scene.resolution = {64, 48};
  scene.tolerance = 1e-3;
  scene.texel = texel;
  if (light) scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}};
  return make_view(scene, read_fields(scene, VolumeFile(scene.input)));
}

TEST_F(CodedMarch, ASessionForOnePictureLeavesNoValuesAndReadsThemAgain) {
  for (const TexelType texel : {TexelType::automatic, TexelType::float32})
    for (const bool light : {false, true}) {
      Wish wish;
      wish.fewest_bytes = true;
      const Drawn kept = Session(of_file(light, texel)).draw(*Gpu::renderer(), wish);
      Session session(of_file(light, texel), /*for_one_picture=*/true);
      const auto draws_the_same = [&] {
        const auto& values = session.view().medium.density->storage.blocks;
        const std::weak_ptr<const void> first = values.empty() ? nullptr : values.front();
        EXPECT_EQ(compare_images(kept.image, session.draw(*Gpu::renderer(), wish).image).max, 0);
        return first.expired();
      };
      for (int i = 0; i < 2; ++i) EXPECT_TRUE(draws_the_same());  // the second reads again
      EXPECT_TRUE(session.view().medium.density->leaves.empty());
      session.convert();
      EXPECT_TRUE(draws_the_same());
      EXPECT_LE(session.check_error(kept, 16).rms, 2e-3);
      wish.layers.bound = true;  // needs the field
      EXPECT_FALSE(draws_the_same());
    }
}

TEST_F(CodedMarch, ASessionForOnePictureReadsValuesAgainAfterACancellation) {
  Session session(of_file(true), /*for_one_picture=*/true);
  Wish wish;
  wish.progress = [](Stage stage, double) {
    if (stage == Stage::marching) throw Error(ExitCode::failure, "cancelled");
  };
  EXPECT_THROW(session.draw(*Gpu::renderer(), wish), Error);
  EXPECT_TRUE(session.view().medium.density->leaves.empty());
  const Image picture = session.draw(*Gpu::renderer()).image;
  EXPECT_EQ(compare_images(picture, Session(of_file(true)).draw(*Gpu::renderer()).image).max, 0);
}

TEST_F(CodedMarch, ValuesThatNeedFloat32KeepIt) {
  const Field field = make_field({{0, 0, 0}, {30, 30, 30}}, [](glm::ivec3 v) {
    return v == glm::ivec3(13, 14, 15) ? 1e30f : blobs_at(glm::dvec3(v));
  });
  EXPECT_EQ(expect_within(view_of(asked(1e-3), field)), 1);
  Scene steep = asked(1e-4);
  steep.transfer_function = function_file();  // a jump within 1e-5 of the value
  EXPECT_EQ(expect_within(view_of(steep, mixed())), 1);
}

TEST_F(CodedMarch, WithoutAToleranceThereAreNone) {
  const View view = view_of(by(oblique(), true), mixed());
  Session session(view);
  Wish full;
  full.scene = view.scene;
  full.scene->texel = TexelType::float32;
  const Drawn drawn = session.draw(*Gpu::renderer()), exact = session.draw(*Gpu::renderer(), full);
  EXPECT_EQ(drawn.atlas.texel_bytes, exact.atlas.texel_bytes);
  EXPECT_EQ(compare_images(drawn.image, exact.image).max, 0);
}

// --- codes that are not stored -------------------------------------------------------------------

/// Marches every pixel.
std::vector<MarchedRay> rays_of(const View& view, const PixelMarch& march) {
  std::vector<glm::ivec2> pixels;
  for (int y = 0; y < view.scene.resolution.y; ++y)
    for (int x = 0; x < view.scene.resolution.x; ++x) pixels.emplace_back(x, y);
  std::vector<MarchedRay> rays(pixels.size());
  march.march(pixels, rays, {});
  return rays;
}

float greatest_difference(const std::vector<MarchedRay>& a, const std::vector<MarchedRay>& b) {
  float most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a[i].picture[c] - b[i].picture[c]));
  return most;
}

/// Rays by codes that are not stored are those of the coded atlas.
void expect_coded_rays(const std::string& what, const View& view) {
  const MediumAtlas atlas = build_medium_atlas(view);
  const std::vector<CodeWidth> widths = widths_in_turn(atlas);
  const BrickAtlas* beside = atlas.paired ? &*atlas.luminance : nullptr;
  const BrickCodes codes = brick_codes(atlas.density, widths, beside);
  const auto by_codes = rays_of(view, PixelMarch(view, atlas, {}, &codes));
  EXPECT_EQ(coded(atlas, widths).density.size.texel_bytes, coded_bytes(widths, beside));
  const auto stored = rays_of(view, PixelMarch(view, coded(atlas, widths)));
  // all else is in double: two units in the last place of float32 below 1
  EXPECT_LE(greatest_difference(by_codes, stored), 1.2e-7) << what;
  EXPECT_GE(greatest_difference(by_codes, rays_of(view, PixelMarch(view, atlas))), 1e-4) << what;
}

TEST(Codes, RaysNeedNoStoredCodes) {
  for (const bool cells : {true, false}) {
    expect_coded_rays("constant", view_of(by(oblique(), cells), mixed()));
    expect_coded_rays("density", view_of(by(oblique(), cells), mixed(), Glow::density));
    Scene scene = by(oblique(), cells);
    scene.colormap = Colormap::viridis;
    expect_coded_rays("function", view_of(scene, mixed()));
    scene.colormap.reset();
    scene.lights = {{{1, -1, 0.5}, {1, 1, 1}}};
    expect_coded_rays("light", lit_in_double(view_of(scene, mixed())));
    scene.lights.push_back({{-1, -0.2, 0.5}, {0.2, 0.5, 1}});
    expect_coded_rays("coloured light", lit_in_double(view_of(scene, mixed())));
  }
}

TEST(Codes, TakeThePlaceOfTexelsIfTheyFit) {
  const Box box{{0, 0, 0}, {111, 111, 111}};  // more bricks than are stored at once
  for (const bool fits : {true, false}) {
    MediumAtlas atlas;
    atlas.density = build_atlas(make_field(box, noise), {.own_texels = true});
    atlas.luminance = build_beside(make_field(box, noise), atlas.density);
    atlas.paired = true;
    std::vector<CodeWidth> widths(atlas.density.bricks.size(), CodeWidth::bits12);
    if (!fits) widths.front() = CodeWidth::bits16;
    const BrickAtlas kept = coded(atlas, widths).density;
    const float* const texels = atlas.density.texels.get();
    const BrickAtlas codes = coded(std::move(atlas), widths, /*replaces=*/true).density;
    EXPECT_EQ(static_cast<const void*>(codes.codes.get()) == texels, fits);
    ASSERT_EQ(codes.code_count(), kept.code_count());
    EXPECT_EQ(0, std::memcmp(codes.codes.get(), kept.codes.get(), 8 * codes.code_count()));
  }
}

}  // namespace
}  // namespace psivox
