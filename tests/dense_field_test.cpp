// DenseField: arrays that are copied or read in place, and the files that are made of them.

#include "psivox/field.h"

#include <algorithm>
#include <array>
#include <glm/vector_relational.hpp>

#include "field/leaf_values.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox {
namespace {

/// Value of channel c at voxel (x, y, z): 0 in parts, of one value in others, else all different.
float dense_value(const glm::ivec3& v, int c) {
  if (v.x < 8 && v.y < 8) return 0;
  if (v.x >= 8 && v.y >= 8) return 2;
  return float(v.x * 1000 + v.y * 30 + v.z - 500 * c);
}

std::shared_ptr<const Field> dense_field(const glm::ivec3& shape, int channels) {
  DenseField field("density", shape, channels, glm::dmat4(1));
  for (int x = 0; x < shape.x; x += 8) {
    std::vector<float> slab;
    for (glm::ivec3 v(x, 0, 0); v.x < std::min(x + 8, shape.x); ++v.x)
      for (v.y = 0; v.y < shape.y; ++v.y)
        for (v.z = 0; v.z < shape.z; ++v.z)
          for (int c = 0; c < channels; ++c) slab.push_back(dense_value(v, c));
    field.add(slab);
  }
  return std::make_shared<const Field>(field.finish());
}

TEST(Dense, FieldsHaveTheirArraysValues) {
  for (const int channels : {1, 3})
    for (const glm::ivec3& shape : {glm::ivec3(19, 17, 23), glm::ivec3(16, 16, 16)}) {
      const VolumeFile file(dense_field(shape, channels));
      const Field field = file.read("density", {.role = GridRole::data});
      EXPECT_EQ(field.tiles.empty(), false);
      EXPECT_EQ(field.active_box, (Box{{0, 0, 0}, shape - 1}));
      const FieldVoxels sampler(field);
      std::uint64_t active = 0;
      for (glm::ivec3 v(0); v.x < shape.x; ++v.x)
        for (v.y = 0; v.y < shape.y; ++v.y)
          for (v.z = 0; v.z < shape.z; ++v.z) {
            for (int c = 0; c < channels; ++c)
              EXPECT_EQ(sampler.voxel(v, c), double(dense_value(v, c)));
            active += dense_value(v, 0) != 0;
          }
      if (channels == 1) {
        EXPECT_EQ(field.active_voxels, active);
      }
    }
}

TEST(Dense, FieldsBelow0EndAtTheirArraysVoxels) {
  const auto domain_of = [](const glm::ivec3& shape, float value, int channels = 1,
                            GridRole role = GridRole::data) {
    DenseField field("density", shape, channels, glm::dmat4(1));
    std::vector<float> slab(std::size_t(shape.x * shape.y * shape.z * channels), 0.f);
    slab[slab.size() / 2] = value;
    field.add(slab);
    const VolumeFile file(std::make_shared<const Field>(field.finish()));
    return file.read("density", {.role = role}).domain();
  };
  const glm::ivec3 shape(8, 9, 5);
  EXPECT_EQ(domain_of(shape, -1), (Box{{0, 0, 0}, shape - 1}));
  const Box grown = domain_of(shape, 1);  // by one around the only voxel
  EXPECT_EQ(grown.max - grown.min, glm::ivec3(2));
  EXPECT_EQ(domain_of({8, 9, 1}, -1), domain_of({8, 9, 1}, 1));
  EXPECT_EQ(domain_of(shape, -1, 3), domain_of(shape, 1, 3));
  // an attenuation has none
  EXPECT_EQ(domain_of(shape, -1, 1, GridRole::attenuation), domain_of(shape, 1));
}

/// The same values in place, in an array whose axes lie in `order` in memory, the first fastest;
/// axis 3 are the channels. Between two values are `gap` others.
std::shared_ptr<const Field> held_field(const glm::ivec3& shape, int channels,
                                        const std::array<int, 4>& order, std::ptrdiff_t gap,
                                        std::weak_ptr<const void>& owner) {
  const std::array<int, 4> size{shape.x, shape.y, shape.z, channels};
  std::array<std::ptrdiff_t, 4> strides{};
  std::ptrdiff_t next = 1 + gap;
  for (const int axis : order) {
    strides[std::size_t(axis)] = next;
    next *= size[std::size_t(axis)];
  }
  const auto values = std::make_shared<std::vector<float>>(std::size_t(next), -7.0f);
  for (glm::ivec3 v(0); v.x < shape.x; ++v.x)
    for (v.y = 0; v.y < shape.y; ++v.y)
      for (v.z = 0; v.z < shape.z; ++v.z)
        for (int c = 0; c < channels; ++c)
          (*values)[std::size_t(v.x * strides[0] + v.y * strides[1] + v.z * strides[2] +
                                c * strides[3])] = dense_value(v, c);
  owner = values;
  DenseField field("density", shape, channels, glm::dmat4(1));
  field.hold({values->data(), {strides[0], strides[1], strides[2], strides[3]}}, values);
  return std::make_shared<const Field>(field.finish());
}

TEST(Dense, ArraysAreReadInPlace) {
  for (const int channels : {1, 3})
    for (const glm::ivec3& shape : {glm::ivec3(19, 17, 23), glm::ivec3(16, 24, 16)})
      for (const auto& order : {std::array{3, 2, 1, 0}, {0, 1, 2, 3}, {1, 3, 0, 2}})
        for (const std::ptrdiff_t gap : {0, 2}) {
          std::weak_ptr<const void> owner;
          auto held = held_field(shape, channels, order, gap, owner);
          const auto copied = dense_field(shape, channels);
          EXPECT_EQ(held->active_box, copied->active_box);
          EXPECT_EQ(held->active_voxels, copied->active_voxels);
          EXPECT_TRUE(test::same(held->tiles, copied->tiles));
          ASSERT_EQ(held->leaves.size(), copied->leaves.size());
          int in_place = 0;
          for (std::size_t n = 0; n < held->leaves.size(); ++n) {
            const Leaf& leaf = held->leaves[n];
            EXPECT_EQ(leaf.origin, copied->leaves[n].origin);
            EXPECT_TRUE(std::ranges::equal(OrderedValues(*held, leaf),
                                           OrderedValues(*copied, copied->leaves[n])));
            const bool whole = glm::all(glm::lessThanEqual(leaf.origin + 8, shape));
            EXPECT_EQ(leaf.values == nullptr, whole);
            in_place += whole;
          }
          EXPECT_GT(in_place, 1);
          const Field part = part_of_field(*held, held->active_box);
          held.reset();
          EXPECT_FALSE(owner.expired());  // the part reads it
          EXPECT_TRUE(std::ranges::equal(OrderedValues(part, part.leaves.back()),
                                         OrderedValues(*copied, copied->leaves.back())));
        }
}

TEST(Dense, BadValuesOfAnArrayAreReplacedInCopies) {
  std::weak_ptr<const void> owner;
  const VolumeFile file(held_field({8, 16, 40}, 3, {3, 2, 1, 0}, 0, owner));
  const Field as_data = file.read("density", {.role = GridRole::data});
  EXPECT_TRUE(as_data.notices.empty());
  const Field light = file.read("density", {.role = GridRole::luminance});
  const Field same =
      VolumeFile(dense_field({8, 16, 40}, 3)).read("density", {.role = GridRole::luminance});
  EXPECT_EQ(light.notices, same.notices);
  for (std::size_t n = 0; n < light.leaves.size(); ++n) {
    const OrderedValues values(light, light.leaves[n]);
    EXPECT_TRUE(std::ranges::equal(values, OrderedValues(same, same.leaves[n])));
    EXPECT_EQ(light.leaves[n].values != nullptr,
              std::ranges::any_of(OrderedValues(as_data, as_data.leaves[n]),
                                  [](float value) { return value < 0; }));
  }
}

TEST(Dense, ValuesAreCheckedForTheirRole) {
  const VolumeFile file(dense_field({8, 16, 40}, 3));
  EXPECT_TRUE(file.read("density", {.role = GridRole::data}).notices.empty());
  const Field light = file.read("density", {.role = GridRole::luminance});
  ASSERT_EQ(light.notices.size(), 1u);
  EXPECT_TRUE(has(light.notices[0], "negative values taken as 0"));
  EXPECT_LT(light.replaced.least, 0);
  EXPECT_TRUE(
      has(input_error([&] { file.read("density", {.role = GridRole::luminance, .strict = true}); }),
          "strict"));
  EXPECT_TRUE(has(input_error([&] { file.read("smoke"); }), "'density'"));
}

TEST(Dense, SlabsAreThoseOfTheShape) {
  const glm::dmat4 place(1);
  for (const glm::ivec3 shape : {glm::ivec3(0, 8, 8), {8, -1, 8}})
    EXPECT_TRUE(has(input_error([&] { DenseField("d", shape, 1, place); }), "at least one voxel"));
  EXPECT_TRUE(has(input_error([&] { DenseField("d", {8, 8, 8}, 2, place); }), "1 or 3 channels"));
  const std::vector<float> values(12 * 8 * 8, 1.0f);
  const std::span<const float> all(values), first = all.first(8 * 64), rest = all.first(4 * 64);
  DenseField field("d", {12, 8, 8}, 1, place);
  for (const auto wrong : {all, rest})
    EXPECT_TRUE(has(input_error([&] { field.add(wrong); }), "12 planes"));
  field.add(first);
  EXPECT_TRUE(has(input_error([&] { field.finish(); }), "12 planes"));
  field.add(rest);
  EXPECT_TRUE(has(input_error([&] { field.add(rest); }), "12 planes"));
  EXPECT_EQ(field.finish().active_voxels, values.size());
}

TEST(Dense, GridsOfFilesAreGathered) {
  const auto one = std::make_shared<VolumeFile>(dense_field({16, 16, 16}, 1));
  const auto three = std::make_shared<VolumeFile>(dense_field({16, 16, 16}, 3));
  const VolumeFile both(std::vector<NamedGrid>{{"smoke", one, "density"}, {"v", three, "density"}});
  EXPECT_EQ(both.names(), (std::vector<std::string>{"smoke", "v"}));
  EXPECT_EQ(both.channels("v"), 3);
  EXPECT_EQ(both.default_grid(), "smoke");
  EXPECT_EQ(both.read("v", {.role = GridRole::data}).name, "v");
  EXPECT_EQ(both.info().size(), 2u);
  EXPECT_EQ(input_error([&] { both.read("smokes"); }),
            "there is no grid 'smokes'; there is 'smoke' 'v'");
  EXPECT_THROW(VolumeFile(std::vector<NamedGrid>{{"a", one, "density"}, {"a", three, "density"}}),
               Error);
}

}  // namespace
}  // namespace psivox
