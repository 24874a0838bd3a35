// What a process that a file has taken over could send: answers that are cut off, fields that break
// the rules, shared memory that changes.

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <functional>

#include "vdb/reader.h"
#include "vdb/reading_messages.h"
#include "vdb_test_util.h"

namespace psivox::vdb {
namespace {

using test::same;

TEST(ReaderAnswers, APrefixOfAnAnswerIsAnError) {
  const auto reader =
      open_reader(std::make_shared<FileBlocks>(test::assets_dir() / "blobs.vdb"), nullptr);
  const std::string text =
      guard::packed(reader->facts(), reader->info("color", true), reader->read("density", {}));
  const auto take = [](std::string_view bytes) {
    FileFacts facts;
    GridInfo row;
    Field field;
    guard::unpack(bytes, facts, row, field);
  };
  take(text);
  EXPECT_THROW(take(text + "x"), std::runtime_error);
  for (std::size_t n = 0; n < text.size(); ++n)
    ASSERT_THROW(take(text.substr(0, n)), std::runtime_error) << n;
}

/// A good field of 2 leaves and 2 tiles.
struct MadeField {
  MadeField() : values(2 * 512, 1.0f) {
    field.active_box = {glm::ivec3(-8), glm::ivec3(700)};
    field.leaves = {{glm::ivec3(-8), values.data()}, {glm::ivec3(0, 0, 8), values.data() + 512}};
    field.tiles = {{glm::ivec3(128), 128, glm::vec3(1)}, {glm::ivec3(0, 0, 16), 8, glm::vec3(1)}};
  }
  std::vector<float> values;
  Field field;
};

TEST(ReaderAnswers, AFieldThatBreaksTheRulesIsAnError) {
  EXPECT_NO_THROW(check_field(MadeField().field, {}));
  const std::vector<std::function<void(MadeField&)>> lies = {
      [](MadeField& m) { m.field.channels = 2; },
      [](MadeField& m) { m.field.active_box = {}; },
      [](MadeField& m) { m.field.active_box.max.x = 2147483647; },
      [](MadeField& m) { m.field.world_from_index[1][1] = std::nan(""); },
      [](MadeField& m) { m.field.world_from_index[1] = glm::dvec4(0); },
      [](MadeField& m) { m.field.half_width = -1; },
      [](MadeField& m) { m.field.active_range = glm::vec2(std::nanf(""), 1); },
      [](MadeField& m) { m.field.leaves[1].origin.z = 9; },
      [](MadeField& m) { m.field.leaves[1].origin = m.field.leaves[0].origin; },
      [](MadeField& m) { std::swap(m.field.leaves[0], m.field.leaves[1]); },
      [](MadeField& m) { m.field.leaves[1].origin = glm::ivec3(128, 128, 248); },  // in a tile
      [](MadeField& m) { m.field.tiles[1].origin = glm::ivec3(0, 0, 8); },         // on a leaf
      [](MadeField& m) { m.field.tiles[1].origin = glm::ivec3(128, 128, 136); },   // in the other
      [](MadeField& m) { m.field.tiles[0].width = 64; },
      [](MadeField& m) { m.field.tiles[0].origin.x = 136; },
      [](MadeField& m) { m.field.tiles.push_back(m.field.tiles[1]); },
      [](MadeField& m) { m.field.tiles[0].value.x = -1; },
      [](MadeField& m) { m.values[700] = std::nanf(""); },
      [](MadeField& m) { m.values[1023] = -1; },
      [](MadeField& m) { m.values[0] = HUGE_VALF; },
      [](MadeField& m) { m.field.leaves[0].values = nullptr; },  // which was not asked for
  };
  for (std::size_t n = 0; n < lies.size(); ++n) {
    MadeField made;
    lies[n](made);
    EXPECT_THROW(check_field(made.field, {}), std::runtime_error) << n;
  }
  MadeField negative;
  negative.values[1023] = -1;
  EXPECT_NO_THROW(check_field(negative.field, {.role = GridRole::data}));
}

std::vector<guard::SealedMemory> sealed(std::vector<guard::Descriptor> blocks) {
  std::vector<guard::SealedMemory> memory;
  for (guard::Descriptor& block : blocks) memory.emplace_back(std::move(block));
  return memory;
}

TEST(ReaderAnswers, ValuesComeInBlocksThatNobodyCanChange) {
  std::vector<float> values(5000 * 512);  // more than two blocks
  Field made;
  for (int n = 0; n < 5000; ++n) {
    made.leaves.push_back({glm::ivec3(0, 0, 8 * n), values.data() + n * 512});
    values[std::size_t(n) * 512 + 7] = float(n);
  }
  std::vector<guard::Descriptor> blocks = shared_values(Field(made));
  ASSERT_EQ(blocks.size(), 3u);
  const guard::Descriptor last(dup(blocks.back().get()));
  Field taken = made;
  take_values(taken, sealed(std::move(blocks)));
  EXPECT_NE(taken.leaves[0].values, made.leaves[0].values);
  EXPECT_TRUE(same(taken.leaves, made.leaves, 1));
  EXPECT_NE(ftruncate(last.get(), 0), 0);
  EXPECT_LT(write(last.get(), "x", 1), 0);
}

TEST(ReaderAnswers, BlocksMustHaveTheirSizeAndStayAsTheyAre) {
  const MadeField made;
  const auto take = [&](const std::function<void(std::vector<guard::Descriptor>&)>& spoil) {
    std::vector<guard::Descriptor> blocks = shared_values(Field(made.field));
    spoil(blocks);
    Field field = made.field;
    take_values(field, sealed(std::move(blocks)));
  };
  EXPECT_NO_THROW(take([](auto&) {}));
  EXPECT_THROW(take([](auto& blocks) { blocks.clear(); }), std::runtime_error);
  EXPECT_THROW(take([](auto& blocks) { blocks.push_back(guard::shared_copy("x")); }),
               std::runtime_error);
  for (const int size : {0, 2048, 8192})
    EXPECT_THROW(take([&](auto& blocks) { EXPECT_EQ(ftruncate(blocks[0].get(), size), 0); }),
                 std::runtime_error);
  void* map = nullptr;
  EXPECT_THROW(take([&](auto& blocks) {
                 map = mmap(nullptr, 4096, PROT_WRITE, MAP_SHARED, blocks[0].get(), 0);
               }),
               std::runtime_error);
  munmap(map, 4096);
}

}  // namespace
}  // namespace psivox::vdb
