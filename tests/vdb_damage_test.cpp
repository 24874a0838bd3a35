// Damaged files in the guarded process: whatever a change of their bytes does to OpenVDB or NanoVDB
// ends in an error in one line, or in a field.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "thrown.h"
#include "vdb_made_files.h"

namespace psivox {
namespace {

using openvdb::GridBase;
using test::ball_with_tiles;
using test::with;
using test::written_nano;

/// What reading all grids of a file says; empty: they are read.
std::string error_of(const std::string& bytes, const std::string& name) {
  const auto path = test::write_bytes(name, bytes);
  try {
    const VolumeFile file(path);
    for (const std::string& grid : file.names()) file.read(grid);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input) << error.what();
    EXPECT_TRUE(has(error.what(), name));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "";
}

/// Changes the file at random, and cuts it.
void expect_no_crash(const std::filesystem::path& path) {
  SCOPED_TRACE(path.filename());
  const std::string good = test::file_bytes(path), name = path.filename();
  std::mt19937 random(7);
  int refused = 0;
  for (int change = 0; change < 60; ++change) {
    std::string bytes = good;
    if (change % 6 == 0)
      bytes.resize(random() % good.size());
    else  // most of them where the file has structure, not values
      bytes[random() % (change % 2 ? std::min<std::size_t>(2000, good.size()) : good.size())] =
          static_cast<char>(random());
    refused += !error_of(bytes, name).empty();
  }
  EXPECT_GT(refused, 8);  // each shorter file at least
}

TEST(Damage, OfAVdbIsAnError) {
  for (const std::uint32_t codec : test::codecs())
    expect_no_crash(test::written(
        {ball_with_tiles<openvdb::FloatGrid>("density"), ball_with_tiles<openvdb::Vec3SGrid>("v")},
        codec, "damaged.vdb"));
}

TEST(Damage, OfPointsIsAnError) {
  expect_no_crash(test::assets_dir() / "../tests/fuzz/corpus/volume/points_of_unknown_codec.vdb");
}

/// Whether a block of values may begin here: an integer of 64 bits, as short as this file's blocks.
bool is_length(const std::string& bytes, std::size_t at) {
  std::int64_t length = 0;
  std::memcpy(&length, bytes.data() + at, sizeof length);
  return length != 0 && std::abs(length) < 1 << 18;
}

/// OpenVDB believes the lengths of blocks, and Blosc those in its own header.
TEST(Damage, OfTheLengthsOfBlocksIsAnError) {
  const auto grid = test::named("density");
  for (const openvdb::Coord& p : openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(6)))
    grid->tree().setValue(p, test::value_at<float>(p));
  for (const std::uint32_t codec : {openvdb::io::COMPRESS_ZIP, openvdb::io::COMPRESS_BLOSC}) {
    const std::string good = test::file_bytes(test::written({grid}, codec));
    // the transform comes before the tree
    for (std::size_t at = good.find("UniformScaleMap"); at + 24 < good.size(); ++at) {
      if (!is_length(good, at)) continue;
      error_of(with(good, at, std::int64_t{-3000}), "lengths.vdb");
      if (!(codec & openvdb::io::COMPRESS_BLOSC)) continue;
      error_of(with(good, at + 8 + 4, std::int32_t{1 << 30}), "lengths.vdb");
      error_of(with(good, at + 8 + 12, std::int32_t{1 << 30}), "lengths.vdb");
    }
  }
}

using NanoDamage = test::NanoTest;

TEST_F(NanoDamage, FilesThatLieAreErrors) {
  const std::string good =
      test::file_bytes(written_nano({ball_with_tiles<openvdb::FloatGrid>("density")}));
  const auto error_in = [&](const std::string& bytes) { return error_of(bytes, "lie.nvdb"); };
  ASSERT_EQ(error_in(good), "");
  constexpr std::size_t version = 8, codec = 14, memory = 16, bytes = 24, type = 48, name = 152,
                        grid = 16 + 176 + 8, grid_type = grid + 636, root = grid + 672 + 24,
                        table_size = grid + 672 + 64 + 24, first_child = table_size + 40;
  constexpr std::uint64_t most = ~std::uint64_t{0};
  EXPECT_TRUE(has(error_in(with(good, version, 0x1001Cu)), "NanoVDB 28.1, psivox reads 32"));
  EXPECT_TRUE(has(error_in(with(good, version, 33u << 21)), "NanoVDB 33.0"));
  EXPECT_TRUE(has(error_in(with(good, type, 12u)), "RGBA8"));
  EXPECT_TRUE(has(error_in(with(good, type, 20u)), "OnIndex"));
  EXPECT_TRUE(has(error_in(with(good, type, 99u)), "unknown"));
  for (const std::string& lie :
       {with(good, codec, std::uint16_t{7}), with(good, codec, std::uint16_t{1}),
        with(good, memory, most), with(good, bytes, most), with(good, bytes, most - 100),
        with(good, name, 0xFFFFFFFFu), with(good, grid_type, 2u), with(good, root, most),
        with(good, root, std::uint64_t{1} << 40), with(good, table_size, 0xFFFFFFFFu),
        with(good, first_child + 8, std::int64_t{1} << 62),
        with(good, first_child + 8, -(std::int64_t{1} << 62)), good.substr(0, 10),
        good.substr(0, 100), good.substr(0, good.size() / 2), good.substr(0, good.size() - 1),
        good + "more"})
    EXPECT_NE(error_in(lie), "");
}

TEST_F(NanoDamage, OfBareGridsIsAnError) {
  std::string bare = test::file_bytes(written_nano({ball_with_tiles<openvdb::FloatGrid>("d")}));
  bare = "NanoVDB1" + bare.substr(bare.find("NanoVDB", 8) + 8);
  const auto error_in = [&](const std::string& bytes) { return error_of(bytes, "bare.nvdb"); };
  ASSERT_EQ(error_in(bare), "");
  constexpr std::size_t version = 16, bytes = 32;
  EXPECT_TRUE(has(error_in(with(bare, version, 33u << 21)), "NanoVDB 33.0"));
  for (const std::string& lie :
       {with(bare, bytes, std::uint64_t{0}), with(bare, bytes, ~std::uint64_t{0}),
        bare.substr(0, 100), bare.substr(0, bare.size() - 100), bare + "more"})
    EXPECT_NE(error_in(lie), "");
}

TEST_F(NanoDamage, IsAnError) {
  const auto ball = ball_with_tiles<openvdb::FloatGrid>("density");
  for (const auto& path :
       {written_nano({ball}, "", "none.nvdb"), written_nano({ball}, "--zip", "z.nvdb"),
        written_nano({ball_with_tiles<openvdb::Vec3SGrid>("v")}, "--blosc", "b.nvdb"),
        written_nano({ball_with_tiles<openvdb::BoolGrid>("b")}, "", "bool.nvdb"),
        written_nano({ball}, "--blosc --fpN", "n.nvdb")})
    expect_no_crash(path);
}

// --- files that lie about themselves -------------------------------------------------------------

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
    const std::string message = input_error([&] { VolumeFile(path).read("density"); });
    EXPECT_EQ(message.find(path.string() + ":"), 0u) << message;
  }
}

TEST(LyingFile, AFileOfALaterVersionIsReadAsFarAsItCanBe) {
  const std::string good = test::file_bytes(true_file());
  const auto path = test::write_bytes("later.vdb", with(good, at::version, 1000u));
  EXPECT_TRUE(test::same(VolumeFile(path).read("density").leaves,
                         VolumeFile(true_file()).read("density").leaves, 1));
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
  EXPECT_TRUE(test::same(VolumeFile(lie).read("density").leaves,
                         VolumeFile(path).read("density").leaves, 1));
}

}  // namespace
}  // namespace psivox
