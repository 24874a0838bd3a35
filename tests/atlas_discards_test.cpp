// Values that an atlas discards while it is built: they lie in its bricks, and leave memory.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "atlas/atlas.h"
#include "made_fields.h"
#include "resident_values.h"

namespace psivox {
namespace {

/// 4,000 leaves, of which some are missing or tiles.
Field many_leaves() {
  Field field = make_field({{-20, -9, -40}, {140, 120, 60}}, noise);
  std::vector<Leaf> kept;
  for (const Leaf& leaf : field.leaves) {
    const int kind = (leaf.origin.x / 8 * 7 + leaf.origin.y / 8 * 3 + leaf.origin.z / 8) & 63;
    if (kind == 1) field.tiles.push_back({leaf.origin, 8, glm::vec3(0.5f)});
    if (kind > 1) kept.push_back(leaf);
  }
  field.leaves = std::move(kept);
  return field;
}

TEST(Atlas, ValuesThatItDiscardsAreInItsBricks) {
  for (const bool own : {false, true}) {
    const Field field = many_leaves();
    AtlasOptions options;
    options.own_texels = own;
    const BrickAtlas kept = build_atlas(field, options);
    EXPECT_GE(test::resident_bytes(field), field.leaves.size() * 2048);
    options.discards_values = true;
    const BrickAtlas built = build_atlas(field, options);
    EXPECT_EQ(built.pages.entries, kept.pages.entries);
    ASSERT_EQ(built.texel_count(), kept.texel_count());
    EXPECT_EQ(0, std::memcmp(built.texels.get(), kept.texels.get(), 4 * kept.texel_count()));
    // a page or two stay beside a leaf that is missing, one in 32
    EXPECT_LE(test::resident_bytes(field), field.leaves.size() * 2048 / 4);
  }
}

TEST(Atlas, WhatLiesBesideAnotherIsDiscardedInAnyOrderOfLeaves) {
  const BrickAtlas layout = build_atlas(many_leaves(), {.own_texels = true});
  ASSERT_TRUE(layout.own_texels);
  Field field = many_leaves();
  std::ranges::reverse(field.leaves);
  const BrickAtlas kept = build_beside(field, layout, {});
  const BrickAtlas built = build_beside(field, layout, {.discards_values = true});
  EXPECT_EQ(0, std::memcmp(built.texels.get(), kept.texels.get(), 4 * kept.texel_count()));
}

TEST(Atlas, AMarginKeepsTheValuesThatItReadsLast) {
  const Field field = many_leaves();
  AtlasOptions options;
  options.with_margin = true;
  options.visible = [](const ValueRange& own, const ValueRange&) { return own.max > 0.999f; };
  const BrickAtlas kept = build_atlas(field, options);
  options.discards_values = true;
  const BrickAtlas built = build_atlas(field, options);
  ASSERT_EQ(built.texel_count(), kept.texel_count());
  EXPECT_EQ(0, std::memcmp(built.texels.get(), kept.texels.get(), 4 * kept.texel_count()));
}

}  // namespace
}  // namespace psivox
