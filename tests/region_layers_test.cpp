// Layers of pictures in parts, compared with those of the whole.

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "blobs_scene.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "region_cases.h"

namespace psivox {
namespace {

struct Both {
  Image whole, parts;
  const std::vector<float>& of_whole(const char* name) const { return layer(whole, name).values; }
  const std::vector<float>& in_parts(const char* name) const { return layer(parts, name).values; }
};

Both drawn(Scene scene, Marcher& marcher) {
  Wish wish;
  wish.layers = {.depth = true, .transmittance = true, .steps = true, .samples = true};
  Both both;
  both.whole = Session(scene).draw(marcher, wish).image;
  scene.memory_limit = 600000;
  const Drawn parts = Session(scene).draw(marcher, wish);
  EXPECT_EQ(parts.notices.size(), 1u) << "drawn whole";
  both.parts = parts.image;
  EXPECT_EQ(both.parts.layers.size(), 5u);
  for (std::size_t i = 0; i < both.parts.layers.size(); ++i)
    EXPECT_EQ(both.parts.layers[i].name, both.whole.layers[i].name);
  return both;
}

/// A depth of 4 to 8 is rounded by 2.4e-7. What is carried is a product of 9 transmittances of
/// float32, so that its optical depth is off by 9 x 6e-8; the attenuation is above 0.1 where rays
/// are half opaque, so that the depth is off by 5e-6.
void expect_depths(const Both& both) {
  const std::vector<float>&whole = both.of_whole("depth"), &parts = both.in_parts("depth");
  int found = 0, other = 0;
  double most = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    other += std::isfinite(whole[i]) != std::isfinite(parts[i]);
    if (!std::isfinite(whole[i]) || !std::isfinite(parts[i])) continue;
    ++found;
    most = std::max(most, std::abs(double(whole[i]) - double(parts[i])));
  }
  std::printf("  %d depths, largest difference %.1e, %d others\n", found, most, other);
  EXPECT_GT(found, 300);
  EXPECT_EQ(other, 0);
  EXPECT_LT(most, 1e-5);
}

/// `ends`: rays end, or skip bricks, by what they have met, which in parts they do not know.
void expect_counts(const Both& both, bool ends) {
  for (const char* layer : {"steps", "samples"}) {
    const std::vector<float>&whole = both.of_whole(layer), &parts = both.in_parts(layer);
    double sum = 0, sum_of_parts = 0, least = 0, most = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      sum += double(whole[i]);
      sum_of_parts += double(parts[i]);
      least = std::min(least, double(parts[i]) - double(whole[i]));
      most = std::max(most, double(parts[i]) - double(whole[i]));
    }
    std::printf("  %s: %.0f in the whole, %.0f in parts; of a pixel %+.0f to %+.0f\n", layer, sum,
                sum_of_parts, least, most);
    EXPECT_GE(least, 0) << layer;
    if (ends) continue;
    EXPECT_GT(sum, 10000);
    EXPECT_EQ(most, 0) << layer;
  }
}

TEST(RegionLayers, EqualThoseOfTheWhole) {
  for (const auto& marcher : {open_double(), open_gpu()})
    for (const auto& [name, mode] : joined_modes)
      for (const int samples : {1, 3}) {
        if (samples == 3 && mode != Mode::alpha) continue;
        SCOPED_TRACE(name);
        Scene scene = blobs_scene();
        scene.mode = mode;
        scene.pixel_samples = samples;
        if (mode == Mode::lmip) scene.lmip_threshold = 0.2;
        std::printf("%s, %d samples, by %s\n", name, samples, description(*marcher).c_str());
        const Both both = drawn(scene, *marcher);
        if (mode != Mode::mean) expect_depths(both);  // a mean is nowhere
        expect_counts(both, mode != Mode::alpha && mode != Mode::xray);
      }
}

TEST(RegionLayers, EndWhereTheWholesRaysEnd) {
  Scene scene = blobs_scene();
  scene.extinction = 30;
  scene.early_termination = 1e-2;
  for (const auto& marcher : {open_double(), open_gpu()}) {
    const Both both = drawn(scene, *marcher);
    for (const char* layer : {"steps", "samples"})
      EXPECT_EQ(both.of_whole(layer), both.in_parts(layer)) << layer;
  }
}

TEST(RegionLayers, ASliceReadsTheLeavesOfItsPlane) {
  Scene scene = blobs_scene();
  scene.mode = Mode::slice;
  scene.extinction.reset();
  scene.slice = Plane{glm::normalize(glm::dvec3(1, 2, 3)), {}};
  const auto marcher = open_double();
  const Image whole = Session(scene).draw(*marcher).image;
  scene.memory_limit = 400000;
  Session session(scene);
  EXPECT_TRUE(session.view().medium.density->reader);
  const Image part = session.draw(*marcher).image;
  EXPECT_EQ(compare_images(whole, part).max, 0);
  EXPECT_GT(compare_images(whole, rgba_image(part.width, part.height)).rms, 0.1);
}

}  // namespace
}  // namespace psivox
