// Damaged files in the guarded process: whatever a change of their bytes does to OpenVDB or NanoVDB
// ends in an error in one line, or in a field.

#include <openvdb/points/PointConversion.h>

#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
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
    const VdbFile file(path);
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
  using namespace openvdb::points;
  openvdb::initialize();
  std::vector<openvdb::Vec3R> at;
  for (int i = 0; i < 40; ++i) at.emplace_back(i, i / 7, i % 5);
  const auto grid = createPointDataGrid<NullCodec, PointDataGrid>(
      at, *openvdb::math::Transform::createLinearTransform(0.5));
  grid->setName("points");
  expect_no_crash(test::write_vdb({grid}, "points.vdb"));
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

class NanoDamage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::has_nano_tool()) GTEST_SKIP() << test::no_nano_tool;
  }
};

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

}  // namespace
}  // namespace psivox
