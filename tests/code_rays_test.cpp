// Codes that are not stored: rays march float32 as codes would have it; and float32 that goes as
// codes are stored.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "atlas/brick_code.h"
#include "code_cases.h"
#include "light_cases.h"
#include "made_fields.h"
#include "march/march_double.h"

namespace psivox {
namespace {

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
