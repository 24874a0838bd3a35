// Levels of detail: --lod.

#include <gtest/gtest.h>

#include "blobs_scene.h"
#include "field_voxels.h"
#include "made_fields.h"
#include "medium/map_field.h"
#include "psivox/draw.h"

namespace psivox {
namespace {

TEST(CoarseField, KeepsALinearField) {
  const auto linear = [](const glm::dvec3& at) { return at.x - 2 * at.y + 0.5 * at.z + 100; };
  for (const Centering centering : {Centering::node, Centering::cell}) {
    const glm::dvec3 shift(centering == Centering::cell ? 0.5 : 0);
    const Field fine = make_field({{-32, -16, 0}, {31, 31, 31}}, [&](glm::ivec3 v) {
      return float(linear(glm::dvec3(v) + shift));
    });
    const Field coarse = coarse_field(fine, 2, centering);
    EXPECT_EQ(coarse.active_box, (Box{{-8, -4, 0}, {7, 7, 7}}));
    const FieldVoxels values(coarse);
    for (const glm::ivec3 v :
         {glm::ivec3(-8, -4, 0), glm::ivec3(0), glm::ivec3(7), glm::ivec3(-1, 3, 5)}) {
      const glm::dvec3 at(coarse.world_from_index * glm::dvec4(glm::dvec3(v) + shift, 1));
      EXPECT_NEAR(values(v).x, linear(at), 1e-4);  // float32 of values about 100
    }
  }
}

TEST(CoarseField, TakesTilesAndLeavesAlike) {
  const Field leaves = noise_beside_constant();
  const Field from_leaves = coarse_field(leaves, 1, Centering::node);
  const Field from_tiles = coarse_field(with_tiles(leaves), 1, Centering::node);
  const FieldVoxels a(from_leaves), b(from_tiles);
  for_points({{0, 0, 0}, {19, 15, 11}}, [&](const glm::ivec3& v) { EXPECT_EQ(a(v), b(v)); });
}

TEST(CoarseField, HalvesWideTiles) {
  Field field;
  field.active_box = {{-4096, 0, 0}, {-1, 4095, 4095}};
  field.tiles = {{{-4096, 0, 0}, 4096, glm::vec3(3)}};
  const Field coarse = coarse_field(field, 1, Centering::node);
  EXPECT_TRUE(coarse.leaves.empty());
  EXPECT_EQ(coarse.tiles.size(), 16u * 16 * 16);  // of 128 voxels
  const FieldVoxels values(coarse);
  for (const glm::ivec3 v : {glm::ivec3(-2048, 0, 0), glm::ivec3(-1, 2047, 2047)})
    EXPECT_EQ(values(v).x, 3);
  EXPECT_EQ(values({-1, 2048, 0}).x, 0);
}

TEST(CoarseField, OfAnArrayThatEndsHasTheMeansOfItsVoxels) {
  const glm::ivec3 shape(19, 18, 17);
  DenseField made("air", shape, 1, glm::dmat4(1));
  for (int x = 0; x < shape.x; x += 8)
    made.add(std::vector<float>(std::size_t(std::min(8, shape.x - x) * shape.y * shape.z), -1000));
  const VdbFile file(std::make_shared<const Field>(made.finish()));
  const Field air = file.read("air", {.role = GridRole::data});
  for (const CoarseValue what : {CoarseValue::mean, CoarseValue::sample})
    for (const int times : {1, 2}) {
      const Field coarse = coarse_field(air, times, Centering::node, what);
      EXPECT_EQ(coarse.domain(), (Box{{0, 0, 0}, (shape - 1) >> times}));
      const FieldVoxels values(coarse);
      for_points(coarse.domain(), [&](const glm::ivec3& v) { EXPECT_EQ(values(v).x, -1000); });
    }
}

TEST(CoarseField, DrawsLessAndSaysSo) {
  Scene scene = blobs_scene();
  scene.camera_position = glm::dvec3(2, 1.5, 3);
  scene.camera_target = glm::dvec3(0.3, 0.4, 0);
  const auto picture = [&](int lod, std::uint64_t limit) {
    scene.lod = lod;
    scene.memory_limit = limit;
    Session session(scene);
    const auto& notices = session.view().medium.density->notices;
    const bool said = std::ranges::any_of(
        notices, [](const std::string& line) { return line.find("--lod") != std::string::npos; });
    EXPECT_EQ(said, lod > 0);
    return session.draw(*open_double()).image;
  };
  const Image whole = picture(0, 0), coarse = picture(1, 0);
  const double rms = compare_images(whole, coarse).rms;
  EXPECT_GT(rms, 1e-4);
  EXPECT_LT(rms, 0.05);  // blobs are many voxels wide
  // values that stay in the file are read for it; it is drawn in parts, which rounds to float32
  EXPECT_LT(compare_images(coarse, picture(1, 300000)).max, 1e-6);
}

}  // namespace
}  // namespace psivox
