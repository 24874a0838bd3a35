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

using guard::Descriptor;
using test::same;

TEST(ReaderAnswers, APrefixOfAnAnswerIsAnError) {
  const auto reader =
      open_reader(std::make_shared<FileBlocks>(test::assets_dir() / "blobs.vdb"), nullptr);
  const std::string text = guard::packed(reader->facts(), reader->info("", true),
                                         FieldFacts{reader->read("density", {}), 1, 2});
  const auto take = [](std::string_view bytes) {
    FileFacts facts;
    std::vector<GridInfo> rows;
    FieldFacts field;
    guard::unpack(bytes, facts, rows, field);
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
  FieldFacts facts{{}, 2, 2};
  Field& field = facts.field;
};

TEST(ReaderAnswers, AFieldThatBreaksTheRulesIsAnError) {
  EXPECT_NO_THROW(check_field(MadeField().facts, GridRole::attenuation));
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
      [](MadeField& m) { m.field.survey.emplace().all.min = std::nanf(""); },
      [](MadeField& m) { m.field.survey.emplace().largest = HUGE_VALF; },
  };
  for (std::size_t n = 0; n < lies.size(); ++n) {
    MadeField made;
    lies[n](made);
    EXPECT_THROW(check_field(made.facts, GridRole::attenuation), std::runtime_error) << n;
  }
  MadeField negative;
  negative.values[1023] = -1;
  EXPECT_NO_THROW(check_field(negative.facts, GridRole::data));
}

TEST(ReaderAnswers, SharedMemoryMustHaveItsSizeAndStayAsItIs) {
  const MadeField made;
  const Descriptor memory = shared_memory();
  FieldFacts written_facts;
  write_places(made.field, memory.get(), written_facts);
  FieldFacts facts;
  const Field& taken = facts.field;
  constexpr auto all = ~std::uint64_t{0};
  for (const auto& [leaves, tiles] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
           {3, 2}, {1, 2}, {2, 1}, {all, 2}, {2, all}, {all / 2060, all / 28}, {0, 0}}) {
    facts.leaves = leaves;
    facts.tiles = tiles;
    EXPECT_THROW(take_places(facts, memory.get()), std::runtime_error) << leaves << ' ' << tiles;
  }
  facts.leaves = facts.tiles = 2;
  facts.field.channels = 2;
  EXPECT_THROW(take_places(facts, memory.get()), std::runtime_error);
  facts.field.channels = 1;
  take_places(facts, memory.get());
  EXPECT_EQ(taken.leaves.at(1).origin, made.field.leaves[1].origin);
  EXPECT_TRUE(same(taken.tiles, made.field.tiles));
  EXPECT_NE(ftruncate(memory.get(), 0), 0);
  EXPECT_LT(write(memory.get(), "x", 1), 0);

  const Descriptor written = shared_memory();
  write_places(made.field, written.get(), written_facts);
  void* const map = mmap(nullptr, 4096, PROT_WRITE, MAP_SHARED, written.get(), 0);
  ASSERT_NE(map, MAP_FAILED);
  EXPECT_THROW(take_places(facts, written.get()), std::runtime_error);
  munmap(map, 4096);
}

TEST(ReaderAnswers, ValuesComeInPiecesThatNobodyCanChange) {
  std::vector<float> values(5000 * 512);  // more than two pieces
  Field made;
  for (int n = 0; n < 5000; ++n) {
    made.leaves.push_back({glm::ivec3(0, 0, 8 * n), values.data() + n * 512});
    values[std::size_t(n) * 512 + 7] = float(n);
  }
  Field taken = made;
  int pieces = 0, last = -1;
  take_values(taken, [&](const ValuesRequest& request, int memory) {
    ++pieces;
    const std::string text = write_values(made, request, memory);
    if (pieces != 2) return text;
    EXPECT_EQ(ftruncate(memory, 0), 0);  // as under a limit of file sizes
    last = dup(memory);
    return std::string(reinterpret_cast<const char*>(made.leaves[request.first].values),
                       request.count * 512 * sizeof(float));
  });
  EXPECT_EQ(pieces, 3);
  EXPECT_NE(taken.leaves[0].values, made.leaves[0].values);
  EXPECT_TRUE(same(taken.leaves, made.leaves, 1));
  EXPECT_NE(ftruncate(last, 1), 0);
  close(last);

  const auto take = [&](const std::function<void(int memory)>& spoil) {
    Field field = made;
    take_values(field, [&](const ValuesRequest& request, int memory) {
      const std::string text = write_values(made, request, memory);
      if (request.first > 0) spoil(memory);
      return text;
    });
  };
  EXPECT_NO_THROW(take([](int) {}));
  EXPECT_THROW(take([](int memory) { EXPECT_EQ(ftruncate(memory, 2048), 0); }), std::runtime_error);
  EXPECT_THROW(take([](int memory) { EXPECT_EQ(ftruncate(memory, 0), 0); }), std::runtime_error);
  void* map = nullptr;
  EXPECT_THROW(
      take([&](int memory) { map = mmap(nullptr, 4096, PROT_WRITE, MAP_SHARED, memory, 0); }),
      std::runtime_error);
  munmap(map, 4096);
  EXPECT_THROW(write_values(made, {.grid = "", .first = 4999, .count = 2}, -1), std::runtime_error);
  EXPECT_THROW(write_values(made, {.grid = "", .first = ~std::uint64_t{0}, .count = 1}, -1),
               std::runtime_error);
}

}  // namespace
}  // namespace psivox::vdb
