// Files that lie about themselves: each is one Error(input) that names the file.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "scratch.h"
#include "thrown.h"
#include "vdb_test_util.h"

namespace psivox::vdb {
namespace {

using test::with;

/// The file that the lies are made from.
std::filesystem::path true_file() { return test::assets_dir() / "single_voxel.vdb"; }

/// Places in single_voxel.vdb. OpenVDB's format: magic number, versions, whether there are
/// positions, an identifier, the file's metadata (none); for each grid name, type, name of the grid
/// that has the tree, three positions, compression, metadata.
namespace at {
constexpr std::size_t version = 8, file_metadata = 57, grid_count = 61, name_length = 65, name = 69,
                      type_length = 76, type = 80, parent_length = 96, positions = 100,
                      compression = 124, metadata = 128, metadata_name_length = 132;
}  // namespace at

TEST(LyingFile, AFileThatLiesIsAnErrorThatNamesIt) {
  const std::string good = test::file_bytes(true_file());
  ASSERT_EQ(good.substr(at::name, 7), "density");
  ASSERT_EQ(good.substr(at::type, 16), "Tree_float_5_4_3");
  // of the tree: one buffer, the background, no tile, one node, whose place follows
  const std::string root(
      "\1\0\0\0"
      "\0\0\0\0"
      "\0\0\0\0"
      "\1\0\0\0",
      16);
  const std::size_t node = good.find(root) + root.size();
  ASSERT_TRUE(has(good, root));
  constexpr std::uint32_t most = ~0u;
  constexpr auto size = std::int64_t{1} << 62;
  const std::vector<std::pair<const char*, std::string>> lies = {
      {"magic number", with(good, 0, 'x')},
      {"version before all", with(good, at::version, 1u)},
      {"version before node masks", with(good, at::version, 221u)},
      {"count of the file's metadata", with(good, at::file_metadata, most)},
      {"number of grids", with(good, at::grid_count, 0u)},
      {"length of the name", with(good, at::name_length, most)},
      {"length of the type", with(good, at::type_length, most)},
      {"type", with(good, at::type, 'X')},
      {"length of the parent's name", with(good, at::parent_length, 1u << 30)},
      {"parent's name", with(good, at::parent_length, 4u)},
      {"position before the directory", with(good, at::positions, std::int64_t{0})},
      {"position behind the file", with(good, at::positions, size)},
      {"end behind the file", with(good, at::positions + 16, size)},
      {"negative end", with(good, at::positions + 16, std::int64_t{-1})},
      {"codec", with(good, at::compression, most)},
      {"other codec", with(good, at::compression, 4u)},
      {"count of metadata", with(good, at::metadata, most)},
      {"length of metadata", with(good, at::metadata_name_length, most - 8)},
      {"place of the root's node", with(good, node, 2147483647)},
      {"half of the file", good.substr(0, good.size() / 2)},
      {"without its last byte", good.substr(0, good.size() - 1)},
      {"header alone", good.substr(0, at::file_metadata)},
      {"nothing", ""},
  };
  for (const auto& [what, bytes] : lies) {
    SCOPED_TRACE(what);
    const auto path = test::write_bytes("lie.vdb", bytes);
    const std::string message = input_error([&] { VdbFile(path).read("density"); });
    EXPECT_EQ(message.find(path.string() + ":"), 0u) << message;
  }
}

TEST(LyingFile, AFileOfALaterVersionIsReadAsFarAsItCanBe) {
  const std::string good = test::file_bytes(true_file());
  const auto path = test::write_bytes("later.vdb", with(good, at::version, 1000u));
  EXPECT_TRUE(test::same(VdbFile(path).read("density").leaves,
                         VdbFile(true_file()).read("density").leaves, 1));
}

TEST(LyingFile, TheDirectoryTellsWhetherValuesAreHalves) {
  const auto grid = test::named("density");
  for (int x = 0; x < 64; ++x) grid->tree().setValue({x, x % 8, 0}, 1 + static_cast<float>(x));
  grid->setSaveFloatAsHalf(true);
  const auto path = test::write_vdb({grid});
  const std::string bytes = test::file_bytes(path), entry = "is_saved_as_half_float";
  const std::size_t value = bytes.find(entry) + entry.size() + 12;  // two lengths and `bool`
  ASSERT_LT(value, bytes.size());
  ASSERT_EQ(bytes[value], 1);
  const auto lie = test::write_bytes("lie.vdb", with(bytes, value, '\0'));
  EXPECT_TRUE(
      test::same(VdbFile(lie).read("density").leaves, VdbFile(path).read("density").leaves, 1));
}

}  // namespace
}  // namespace psivox::vdb
