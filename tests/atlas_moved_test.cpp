// Fields that are moved into an atlas: their values go while it is built.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "atlas/atlas.h"
#include "made_fields.h"

namespace psivox {
namespace {

/// 4,000 leaves, of which some are missing or tiles, in blocks of 100.
Field many_leaves() {
  Field field = make_field({{-20, -9, -40}, {140, 120, 60}}, noise);
  std::vector<Leaf> kept;
  for (const Leaf& leaf : field.leaves) {
    const int kind = (leaf.origin.x / 8 * 7 + leaf.origin.y / 8 * 3 + leaf.origin.z / 8) & 63;
    if (kind == 1) field.tiles.push_back({leaf.origin, 8, glm::vec3(0.5f)});
    if (kind > 1) kept.push_back(leaf);
  }
  field.leaves = std::move(kept);
  Storage storage({}, 100);
  for (std::size_t n = 0; n < field.leaves.size(); ++n) {
    if (n % storage.leaves == 0)
      storage.blocks.push_back(std::make_shared<std::vector<float>>(512 * storage.leaves));
    auto* const block = static_cast<const std::vector<float>*>(storage.blocks.back().get());
    auto* const to = const_cast<float*>(block->data()) + n % storage.leaves * 512;
    std::memcpy(to, field.leaves[n].values, 512 * sizeof(float));
    field.leaves[n].values = to;
  }
  field.storage = std::move(storage);
  return field;
}

void expect_same_bricks(const BrickAtlas& a, const BrickAtlas& b) {
  EXPECT_EQ(a.pages.entries, b.pages.entries);
  ASSERT_EQ(a.texel_count(), b.texel_count());
  EXPECT_EQ(0, std::memcmp(a.texels.get(), b.texels.get(), sizeof(float) * a.texel_count()));
}

bool has_all(const Field& field) { return std::ranges::count(field.storage.blocks, nullptr) == 0; }
bool has_none(const Field& field) {
  const auto& blocks = field.storage.blocks;
  return std::size_t(std::ranges::count(blocks, nullptr)) + 1 >= blocks.size();
}

TEST(Atlas, ValuesThatAreMovedInGoAndAreInItsBricks) {
  for (const bool own : {false, true}) {
    Field field = many_leaves();
    const AtlasOptions options{.own_texels = own};
    const BrickAtlas kept = build_atlas(field, options);
    EXPECT_TRUE(has_all(field));
    expect_same_bricks(build_atlas(field, options, &field.storage), kept);
    EXPECT_TRUE(has_none(field));
  }
}

TEST(Atlas, WhatIsMovedBesideAnotherMayHaveAnyOrderOfLeaves) {
  const BrickAtlas layout = build_atlas(many_leaves(), {.own_texels = true});
  ASSERT_TRUE(layout.own_texels);
  Field field = many_leaves();
  std::ranges::reverse(field.leaves);
  field.storage.leaves = 0;
  const BrickAtlas kept = build_beside(field, layout);
  expect_same_bricks(build_beside(field, layout, &field.storage), kept);
  EXPECT_TRUE(has_all(field));
  field = many_leaves();
  expect_same_bricks(build_beside(field, layout, &field.storage), kept);
}

TEST(Atlas, AMarginKeepsTheValuesThatItReadsLast) {
  AtlasOptions options;
  options.with_margin = true;
  options.visible = [](const ValueRange& own, const ValueRange&) { return own.max > 0.999f; };
  const Field field = many_leaves();
  Field moved = many_leaves();
  expect_same_bricks(build_atlas(moved, options, &moved.storage), build_atlas(field, options));
}

}  // namespace
}  // namespace psivox
