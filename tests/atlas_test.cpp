// Compares bricks with the field that they were built from, value by value.

#include "atlas/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>
#include <memory>
#include <tuple>
#include <vector>

#include "field_voxels.h"
#include "made_fields.h"
#include "reference_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

/// Compares all values of every brick of the domain, through the page table, with the field. Those
/// at its upper faces are its neighbours' too.
void expect_all_values(const Field& field, const BrickAtlas& atlas) {
  const FieldVoxels voxels(field);
  const Box domain = field.domain();
  ASSERT_EQ(atlas.domain, domain);
  std::size_t wrong = 0;
  for_points({domain.min >> 3, (domain.max - 1) >> 3}, [&](const glm::ivec3& brick) {
    const Box own{glm::max(8 * brick, domain.min), glm::min(8 * brick + 8, domain.max)};
    const PageEntry entry = page_entry(atlas.pages, own.min);
    for_points(own, [&](const glm::ivec3& v) {
      if (atlas_value(atlas, entry, v) == voxels(v)) return;
      if (++wrong == 1) ADD_FAILURE() << "first at voxel " << v.x << ' ' << v.y << ' ' << v.z;
    });
  });
  EXPECT_EQ(wrong, 0u);
}

void expect_same(const AtlasSize& a, const AtlasSize& b) {
  EXPECT_EQ(a.textured_bricks, b.textured_bricks);
  EXPECT_EQ(a.constant_bricks, b.constant_bricks);
  EXPECT_EQ(a.page_bytes, b.page_bytes);
  EXPECT_EQ(a.constant_bytes, b.constant_bytes);
  EXPECT_EQ(a.texel_bytes, b.texel_bytes);
}

Field tiles_only(std::vector<Tile> tiles) {
  Field field;
  field.name = "density";
  field.active_box = {tiles.front().origin, tiles.front().origin};
  for (const Tile& tile : tiles) {
    field.active_box.min = glm::min(field.active_box.min, tile.origin);
    field.active_box.max = glm::max(field.active_box.max, tile.origin + (tile.width - 1));
    field.active_voxels += std::uint64_t(tile.width) * std::uint64_t(tile.width * tile.width);
  }
  field.tiles = std::move(tiles);
  return field;
}

TEST(Atlas, NoiseIsStoredValueByValueAtAnyPhase) {
  for (const int phase : {-13, -8, -1, 0, 3, 7}) {
    const glm::ivec3 at(phase, -phase, 2 * phase);
    const Field field = make_field({at, at + glm::ivec3(20, 9, 14)}, noise);
    expect_all_values(field, build_atlas(field));
  }
}

TEST(Atlas, SingleVoxelReachesIntoEightBricks) {
  // Voxel (0,0,0) is a corner of cells in 8 bricks; 7 of these have no leaf.
  const Field corner = make_field({{0, 0, 0}, {0, 0, 0}}, [](glm::ivec3) { return 3.0f; });
  const BrickAtlas atlas = build_atlas(corner);
  EXPECT_EQ(atlas.size.textured_bricks, 8u);
  EXPECT_EQ(atlas.size.constant_bricks, 0u);
  expect_all_values(corner, atlas);
  // A voxel in the middle of a leaf touches its own brick alone; one at the low x face touches two.
  const Field middle = make_field({{4, 4, 4}, {4, 4, 4}}, [](glm::ivec3) { return 3.0f; });
  EXPECT_EQ(build_atlas(middle).size.textured_bricks, 1u);
  const Field face = make_field({{8, 4, 4}, {8, 4, 4}}, [](glm::ivec3) { return 3.0f; });
  EXPECT_EQ(build_atlas(face).size.textured_bricks, 2u);
}

TEST(Atlas, SaturatedLeavesAreConstantsWithoutTexels) {
  // 6^3 leaves of 0.75: a brick whose 9^3 values are all 0.75 needs 2 leaves along each axis.
  const Field field = make_field({{0, 0, 0}, {47, 47, 47}}, [](glm::ivec3) { return 0.75f; });
  const BrickAtlas atlas = build_atlas(field);
  EXPECT_EQ(atlas.size.constant_bricks, 5u * 5 * 5);
  EXPECT_EQ(atlas.size.textured_bricks, 7u * 7 * 7 - 5 * 5 * 5);
  for (const float value : atlas.constants) EXPECT_EQ(value, 0.75f);
  expect_all_values(field, atlas);
}

TEST(Atlas, BesideAnotherHasItsBricksAndAllValuesThere) {
  // leaves, tiles of 8 and of 128 voxels, and empty space
  Field field = make_field({{0, 0, 0}, {47, 47, 47}},
                           [](glm::ivec3 v) { return v.x < 30 ? 0.75f : noise(v); });
  field.tiles.push_back({{48, 0, 0}, 8, {0.5f, 0, 0}});
  field.tiles.push_back({{128, 0, 0}, 128, {0.5f, 0, 0}});
  field.active_box.max = {255, 127, 127};
  const BrickAtlas layout = build_atlas(field, {.own_texels = true});
  ASSERT_TRUE(layout.own_texels);
  EXPECT_EQ(layout.size.constant_bricks, 0u);
  expect_all_values(field, layout);
  std::vector<glm::ivec3> places = layout.places;
  const auto less = [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::sort(places.begin(), places.end(), less);
  EXPECT_EQ(std::adjacent_find(places.begin(), places.end()), places.end());

  Field other =
      make_field({{-8, -8, -8}, {263, 135, 135}}, [](glm::ivec3 v) { return 1 + noise(v); });
  const BrickAtlas beside = build_beside(other, layout);
  EXPECT_EQ(beside.pages.entries, layout.pages.entries);
  const FieldVoxels voxels(other);
  for (const glm::ivec3& place : layout.places) {
    const PageEntry entry = page_entry(beside.pages, 8 * place);
    for (int i = 0; i < 8; ++i) {
      const glm::ivec3 v = 8 * place + 8 * glm::ivec3(i >> 2, (i >> 1) & 1, i & 1);
      ASSERT_EQ(atlas_value(beside, entry, v), voxels(v));
    }
  }
  // a wide tile has too many bricks, and where 0 is visible all space has
  field.tiles.push_back({{4096, 0, 0}, 4096, {0.5f, 0, 0}});
  field.active_box.max = {8191, 4095, 4095};
  EXPECT_FALSE(build_atlas(field, {.own_texels = true}).own_texels);
}

TEST(Atlas, MarginIsWhatALookUpBesideAVisibleCellFinds) {
  // the surface 7.4 lies in the cells from 7 to 8, the last ones of the bricks at 0
  const Field field =
      make_field({{-16, -8, -8}, {31, 23, 23}}, [](glm::ivec3 v) { return float(v.x) + 100; });
  AtlasOptions options;
  options.visible = [](const ValueRange& own, const ValueRange&) {
    return own.min <= 107.4f && 107.4f <= own.max;
  };
  const auto kind = [&](const BrickAtlas& atlas, int x) {
    return page_entry(atlas.pages, {x, 2, 2}).kind;
  };
  const BrickAtlas alone = build_atlas(field, options);
  EXPECT_EQ(kind(alone, 2), EntryKind::brick);
  EXPECT_EQ(kind(alone, 10), EntryKind::empty);
  options.with_margin = true;
  const BrickAtlas more = build_atlas(field, options);
  EXPECT_EQ(kind(more, 2), EntryKind::brick);
  EXPECT_EQ(kind(more, 10), EntryKind::brick);
  EXPECT_EQ(atlas_value(more, page_entry(more.pages, {10, 2, 2}), {10, 2, 2}).x, 110);
  EXPECT_EQ(kind(more, -6), EntryKind::empty);
  EXPECT_EQ(kind(more, 18), EntryKind::empty);
}

TEST(Atlas, EqualBricksBetweenTilesAreStoredOnce) {
  // a cube has 6 faces, 12 edges and 8 corners, and its faces are of many bricks
  for (const int width : {128, 4096}) {
    const Field field = tiles_only({{{0, 0, 0}, width, {0.5f, 0, 0}}});
    EXPECT_EQ(predict_atlas(field).textured_bricks, 6u + 12 + 8) << width;
  }
  const Field field = tiles_only({{{0, 0, 0}, 128, {0.5f, 0, 0}}, {{256, 0, 0}, 8, {0.5f, 0, 0}}});
  const BrickAtlas atlas = build_atlas(field);
  expect_all_values(field, atlas);
  // the largest kink of a face, about its middle: at its inner side 0.5, 0.5, 0
  for (const float kink : brick_kinks(atlas)) EXPECT_EQ(kink, 0.5f);
}

TEST(Atlas, AWideTileIsStoredAsItsNarrowOnes) {
  // two wide tiles with a leaf and a narrow tile at their faces: pieces of many bricks, and bricks
  const Field leaf = make_field({{60, 60, 128}, {70, 75, 140}}, noise);
  Field wide = tiles_only({{{0, 0, 0}, 128, {0.5f, 0, 0}},
                           {{128, 0, 0}, 128, {0.75f, 0, 0}},
                           {{-8, 64, 64}, 8, {0.25f, 0, 0}}});
  wide.active_box.max.z = 143;
  wide.leaves = leaf.leaves;
  wide.storage = leaf.storage;
  Field narrow = wide;
  narrow.tiles.clear();
  for (const Tile& tile : wide.tiles)
    for (int x = 0; x < tile.width; x += 8)
      for (int y = 0; y < tile.width; y += 8)
        for (int z = 0; z < tile.width; z += 8)
          narrow.tiles.push_back({tile.origin + glm::ivec3(x, y, z), 8, tile.value});

  const auto between = [](float low, float high) {
    return
        [=](const ValueRange& own, const ValueRange&) { return own.min <= high && own.max >= low; };
  };
  std::vector<AtlasOptions> cases(6);
  cases[1].region = Box{{3, -1, 2}, {20, 9, 15}};
  cases[2].visible = between(0.3f, 0.3f);
  cases[2].with_margin = true;
  cases[3] = cases[2];
  cases[3].region = Box{{3, -1, 2}, {20, 9, 15}};
  cases[4].visible = between(0, 0.1f);
  cases[5].visible = between(0.6f, 1);
  cases[5].top_entries = 64;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(visible_blocks(wide, cases[k]), visible_blocks(narrow, cases[k]));
    const BrickAtlas a = build_atlas(wide, cases[k]), b = build_atlas(narrow, cases[k]);
    ASSERT_EQ(a.domain, b.domain);
    std::size_t wrong = 0;
    for_points({{-2, -1, -1}, {32, 16, 18}}, [&](const glm::ivec3& brick) {
      const glm::ivec3 voxel = glm::max(8 * brick, a.domain.min);
      if (voxel.x >= a.domain.max.x || voxel.y >= a.domain.max.y || voxel.z >= a.domain.max.z)
        return;
      const PageEntry in_a = page_entry(a.pages, voxel), in_b = page_entry(b.pages, voxel);
      wrong += in_a.kind != in_b.kind;
      for (const glm::ivec3 corner : {voxel, 8 * brick + 8})
        wrong +=
            in_a.kind == in_b.kind && atlas_value(a, in_a, corner) != atlas_value(b, in_b, corner);
    });
    EXPECT_EQ(wrong, 0u);
  }
}

TEST(Atlas, TheWidestTilesKeepTheirBorders) {
  // beside each other, and beside tiles and a leaf at their faces, edges and corners
  Field field = tiles_only({{{0, 0, 0}, 4096, {0.5f, 0, 0}},
                            {{0, 4096, 0}, 4096, {0.75f, 0, 0}},
                            {{4096, 0, 3968}, 128, {0.25f, 0, 0}},
                            {{4096, 4096, 4096}, 8, {1, 0, 0}}});
  const Field leaf = make_field({{2049, 2050, -8}, {2056, 2063, -1}}, noise);
  field.leaves = leaf.leaves;
  field.storage = leaf.storage;
  field.active_box.min.z = -8;
  const BrickAtlas atlas = build_atlas(field);
  const FieldVoxels voxels(field);
  std::vector<int> at;
  for (const int face : {0, 1920, 2048, 2056, 2064, 3968, 4096, 4104, 4224, 8192})
    for (const int cell : {-9, -8, -1, 0, 7, 8}) at.push_back(face + cell);
  std::size_t wrong = 0, compared = 0;
  for (const int x : at)
    for (const int y : at)
      for (const int z : at) {
        const glm::ivec3 cell(x, y, z);
        if (cell != glm::clamp(cell, atlas.domain.min, atlas.domain.max - 1)) continue;
        const PageEntry entry = page_entry(atlas.pages, cell);
        for (int i = 0; i < 8; ++i) {
          const glm::ivec3 v = cell + glm::ivec3(i >> 2, (i >> 1) & 1, i & 1);
          wrong += atlas_value(atlas, entry, v) != voxels(v);
          ++compared;
        }
      }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(compared, 400000u);
  // one by one, the faces' bricks would take 50 MiB of the table alone for each tile
  EXPECT_LT(atlas.size.bytes(), 4u << 20);
}

TEST(Atlas, VectorsKeepTheirThreeChannels) {
  const auto colour = [](glm::ivec3 v) {
    return glm::vec3(noise(v), noise(v + 100), noise(v - 100));
  };
  Field field = make_vector_field({{-5, 2, 3}, {13, 14, 11}}, colour);
  field.tiles.push_back({{16, 0, 0}, 8, {0.1f, 0.2f, 0.3f}});
  field.tiles.push_back({{24, 0, 0}, 8, {0.1f, 0.2f, 0.3f}});
  field.active_box = {{-5, 0, 0}, {31, 14, 11}};
  const BrickAtlas atlas = build_atlas(field);
  EXPECT_EQ(atlas.channels, 3);
  expect_all_values(field, atlas);
  // Equality in the first channel alone does not make a brick constant.
  const Field differs = make_vector_field(
      {{0, 0, 0}, {31, 31, 31}}, [](glm::ivec3 v) { return glm::vec3(1, v.x < 16 ? 1 : 2, 1); });
  expect_all_values(differs, build_atlas(differs));
}

TEST(Atlas, PredictionIsWhatIsBuilt) {
  Field mixed = make_field({{-9, 4, 0}, {40, 30, 50}},
                           [](glm::ivec3 v) { return v.x < 16 ? noise(v) : 1.0f; });
  mixed.tiles.push_back({{128, 0, 0}, 128, {0.5f, 0, 0}});
  mixed.active_box.max = {255, 127, 127};
  Field vectors =
      make_vector_field({{0, 0, 0}, {9, 9, 9}}, [](glm::ivec3 v) { return glm::vec3(v); });
  for (const Field* field : {&mixed, &vectors})
    for (const std::uint64_t top : {std::uint64_t{1} << 22, std::uint64_t{64}}) {
      const AtlasOptions options{.top_entries = top};
      const BrickAtlas atlas = build_atlas(*field, options);
      expect_same(predict_atlas(*field, options), atlas.size);
      EXPECT_EQ(atlas.size.page_bytes, atlas.pages.entries.size() * 4);
      EXPECT_EQ(atlas.size.constant_bytes, atlas.constants.size() * 4);
      EXPECT_EQ(atlas.size.textured_bricks, atlas.bricks.size());
      EXPECT_EQ(atlas.size.texel_bytes, atlas.texel_count() * sizeof(float));
    }
}

// --- the page table ------------------------------------------------------------------------------

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

// --- fields that are moved into it ---------------------------------------------------------------

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
