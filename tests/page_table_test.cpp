// The page table: its entry for every cell, at any number of levels, and its cost.

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>

#include "field_voxels.h"
#include "made_fields.h"
#include "march/atlas_march.h"
#include "reference_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

/// Sparse blobs, a block of constants, a wide tile and single voxels far from each other.
Field scattered() {
  Field field = make_field({{-70, -20, 5}, {150, 100, 90}}, [](glm::ivec3 v) {
    const glm::ivec3 d = v - glm::ivec3(-60, -10, 20);
    if (d.x * d.x + d.y * d.y + d.z * d.z < 60) return noise(v);
    if (v.x >= 30 && v.x < 58 && v.y >= 40 && v.y < 60 && v.z >= 30) return 0.5f;
    return v == glm::ivec3(150, 100, 90) || v == glm::ivec3(-70, 100, 5) ? 2.0f : 0.0f;
  });
  field.tiles.push_back({{256, 0, 0}, 128, {0.25f, 0, 0}});
  field.active_box.max = {383, 127, 127};
  return field;
}

/// Its bricks, and what they hold.
const std::vector<std::pair<glm::ivec3, EntryKind>>& bricks_of_scattered() {
  static const auto bricks = [] {
    const Field field = scattered();
    const FieldVoxels voxels(field);
    const Box domain = field.domain();
    std::vector<std::pair<glm::ivec3, EntryKind>> found;
    for_points({domain.min >> 3, (domain.max - 1) >> 3},
               [&](const glm::ivec3& brick) { found.emplace_back(brick, voxels.kind(brick)); });
    return found;
  }();
  return bricks;
}

/// The shader's own search, in double.
glsl::AtlasMarch march_over(const BrickAtlas& atlas) {
  glsl::AtlasMarch march;
  march.grids[density_grid] = &atlas;
  march.density.table_min = atlas.pages.min;
  march.density.table_size = atlas.pages.top_size;
  march.density_levels = atlas.pages.levels;
  return march;
}

class PageTableLevels : public testing::TestWithParam<std::uint64_t> {
 protected:
  PageTableLevels() { options.top_entries = GetParam(); }
  AtlasOptions options;
};

// 57 x 19 x 16 bricks: 17,328 entries, then 8 x 3 x 2, then one.
INSTANTIATE_TEST_SUITE_P(TopEntries, PageTableLevels, testing::Values(1u << 22, 64u, 1u));

TEST_P(PageTableLevels, EveryCellFindsItsNode) {
  const Field field = scattered();
  const BrickAtlas atlas = build_atlas(field, options);
  EXPECT_EQ(atlas.pages.levels, GetParam() == 1 ? 3 : GetParam() == 64 ? 2 : 1);
  const FieldVoxels voxels(field);
  glsl::AtlasMarch march = march_over(atlas);
  const Box domain = field.domain();
  for (const auto& [brick, expected] : bricks_of_scattered()) {
    // Its first and last cells in the domain, and one between: a node does not end inside a
    // brick.
    for (const glm::ivec3 in : {glm::ivec3(0), glm::ivec3(7), glm::ivec3(1, 5, 2)}) {
      const glm::ivec3 cell = glm::clamp(8 * brick + in, domain.min, domain.max - 1);
      const auto node = march.find_node(0, cell);
      ASSERT_EQ(node.kind, int(expected)) << brick.x << ' ' << brick.y << ' ' << brick.z;
      ASSERT_TRUE(march.inside(node, cell));
      ASSERT_EQ(node.payload, int(page_entry(atlas.pages, cell).payload));
      if (expected == EntryKind::brick) {
        ASSERT_EQ(node.lo, 8 * brick);
        ASSERT_EQ(node.side, 8);
      }
      if (expected == EntryKind::constant) {
        ASSERT_EQ(march.fetch_constant(0, node.payload), voxels(cell).x);
      }
    }
  }
}

TEST_P(PageTableLevels, SkipsNeverPassAFullBrick) {
  const BrickAtlas atlas = build_atlas(scattered(), options);
  glsl::AtlasMarch march = march_over(atlas);
  std::vector<glm::ivec3> full;
  for (const auto& [brick, kind] : bricks_of_scattered())
    if (kind != EntryKind::empty) full.push_back(8 * brick);
  std::size_t empty = 0;
  for (const auto& [brick, kind] : bricks_of_scattered()) {
    const auto node = march.find_node(0, 8 * brick);
    if (node.kind != int(EntryKind::empty)) continue;
    ++empty;
    ASSERT_GE(node.payload, 1);
    const glm::ivec3 end = node.lo + node.side;
    const bool passed = std::ranges::any_of(full, [&](const glm::ivec3& b) {
      return b.x < end.x && b.y < end.y && b.z < end.z && b.x + 8 > node.lo.x &&
             b.y + 8 > node.lo.y && b.z + 8 > node.lo.z;
    });
    ASSERT_FALSE(passed) << brick.x << ' ' << brick.y << ' ' << brick.z;
  }
  EXPECT_GT(empty, 1000u);
}

/// Least and greatest corner of the 4^3 cells from `first` on.
ValueRange range_of_octant(const FieldVoxels& voxels, const glm::ivec3& first) {
  ValueRange range{voxels(first).x, voxels(first).x};
  for_points({first, first + 4}, [&](const glm::ivec3& v) {
    range = {std::min(range.min, voxels(v).x), std::max(range.max, voxels(v).x)};
  });
  return range;
}

TEST_P(PageTableLevels, OctantsHideWhatHasNoVisibleCell) {
  const Field field = scattered();
  options.visible = [](const ValueRange& own, const ValueRange&) { return own.max > 0.9f; };
  options.mark_octants = true;
  const BrickAtlas atlas = build_atlas(field, options);
  ASSERT_TRUE(atlas.pages.octants);
  const FieldVoxels voxels(field);
  glsl::AtlasMarch march = march_over(atlas);
  march.octants = true;
  int hidden = 0, shown = 0;
  for (const glm::ivec3& brick : atlas.places)
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 first = 8 * brick + 4 * glm::ivec3(i >> 2, i >> 1 & 1, i & 1);
      const bool visible = range_of_octant(voxels, first).max > 0.9f;
      ++(visible ? shown : hidden);
      for (const glm::ivec3 in : {glm::ivec3(0), glm::ivec3(3, 1, 2)}) {
        const auto node = march.find_node(0, first + in);
        ASSERT_TRUE(march.inside(node, first + in));
        ASSERT_EQ(node.kind, int(visible ? EntryKind::brick : EntryKind::empty));
        const auto stored = march.find_stored(0, first + in);
        ASSERT_EQ(stored.kind, int(EntryKind::brick));
        const glm::ivec3 local = march.in_brick(first + in);
        ASSERT_EQ(march.fetch_corners(0, stored, local).lo.x, voxels(first + in).x);
        if (visible) {
          ASSERT_EQ(march.fetch_corners(0, node, local).hi.w, voxels(first + in + 1).x);
        }
      }
    }
  EXPECT_GT(hidden, 20);
  EXPECT_GT(shown, 20);
}

TEST(PageTable, OneLevelSkipsAreExactChebyshevDistances) {
  const Field field = make_field({{0, 0, 0}, {119, 95, 71}}, [](glm::ivec3 v) {
    return v == glm::ivec3(12, 20, 28) || v == glm::ivec3(100, 76, 52) ? 1.0f : 0.0f;
  });
  const BrickAtlas atlas = build_atlas(field);
  const glm::ivec3 a(1, 2, 3), b(12, 9, 6);
  const auto chebyshev = [](glm::ivec3 d) {
    d = glm::abs(d);
    return std::max({d.x, d.y, d.z});
  };
  for_points({glm::ivec3(-1), {14, 11, 8}}, [&](const glm::ivec3& brick) {
    const PageEntry entry = page_entry(atlas.pages, 8 * brick);
    const int expected = std::min(chebyshev(brick - a), chebyshev(brick - b));
    EXPECT_EQ(entry.kind, expected ? EntryKind::empty : EntryKind::brick);
    if (expected) {
      EXPECT_EQ(int(entry.payload), expected);
    }
  });
}

TEST(PageTable, HugeSparseBoxStaysSmall) {
  Field field;
  field.name = "density";
  auto values = std::make_shared<std::vector<float>>(512, 0.0f);
  (*values)[0] = 1;
  // 12,501^3 bricks: a dense table would take 7.8 TB.
  for (const glm::ivec3 origin :
       {glm::ivec3(0), glm::ivec3(100'000), glm::ivec3(50'000, 8, 99'992)})
    field.leaves.push_back({origin, values->data()});
  field.active_box = {glm::ivec3(0), glm::ivec3(100'000)};
  field.storage = values;
  const BrickAtlas atlas = build_atlas(field);
  EXPECT_GT(atlas.pages.levels, 1);
  EXPECT_LT(atlas.size.bytes(), 1'000'000u);
  EXPECT_EQ(atlas.size.textured_bricks, 24u);
  RecordProperty("bytes", int(atlas.size.bytes()));
  for (const Leaf& leaf : field.leaves)
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 cell = leaf.origin - glm::ivec3(i >> 2, (i >> 1) & 1, i & 1);
      const PageEntry entry = page_entry(atlas.pages, cell);
      ASSERT_EQ(entry.kind, EntryKind::brick);
      EXPECT_EQ(atlas_value(atlas, entry, leaf.origin).x, 1);
    }
  EXPECT_EQ(page_entry(atlas.pages, {50'000, 50'000, 50'000}).kind, EntryKind::empty);
}

TEST(PageTable, BoxesBeyondTheLimitAreRefused) {
  Field field;
  field.name = "density";
  auto values = std::make_shared<std::vector<float>>(512, 1.0f);
  field.leaves = {{{0, 0, 0}, values->data()}, {{1 << 25, 0, 0}, values->data()}};
  field.active_box = {glm::ivec3(0), glm::ivec3((1 << 25) + 7, 7, 7)};
  field.storage = values;
  EXPECT_TRUE(has(input_error([&] { build_atlas(field); }), "density"));
}

}  // namespace
}  // namespace psivox
