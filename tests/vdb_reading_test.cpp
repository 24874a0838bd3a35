// How VdbFile reads: each byte about once, in few calls, and the same values as OpenVDB's own
// reader with every codec.

#include <openvdb/io/Compression.h>
#include <openvdb/io/Stream.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>

#include "psivox/leaf_values.h"
#include "psivox/medium.h"
#include "psivox/vdb.h"
#include "scene/value_range.h"
#include "thread_ranks.h"
#include "vdb/grid_types.h"
#include "vdb_test_util.h"

namespace psivox {
namespace {

using openvdb::Coord;
using test::input_error;

/// What the process has read so far. The system counts every call, of all libraries.
struct Reads {
  std::int64_t bytes = 0, calls = 0;
};

Reads reads_of_process() {
  Reads reads;
  std::ifstream file("/proc/self/io");
  std::string key;
  for (std::int64_t value; file >> key >> value;) {
    if (key == "rchar:") reads.bytes = value;
    if (key == "syscr:") reads.calls = value;
  }
  return reads;
}

/// A number that looks random, so that no codec makes it much smaller.
std::uint32_t noise(const Coord& p) {
  std::uint32_t hash =
      static_cast<std::uint32_t>(p.x() * 73856093 ^ p.y() * 19349663 ^ p.z() * 83492791);
  hash ^= hash >> 13;
  hash *= 0x5bd1e995u;
  return hash ^ hash >> 15;
}

template <typename ValueT>
ValueT value_at(const Coord& p) {
  const double value = 1 + noise(p) % 4093 / 64.0;
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return ValueT(static_cast<typename ValueT::value_type>(value));
  else
    return static_cast<ValueT>(value);
}

/// A ball with leaves that are full, leaves that are not, and inactive voxels of one, two and many
/// values, each of which the format stores in another way.
template <typename GridT>
openvdb::GridBase::Ptr ball(const std::string& name, int radius, bool half = false) {
  openvdb::initialize();
  const auto grid = vdb::new_grid<GridT>();
  using ValueT = typename GridT::ValueType;
  auto to = grid->getAccessor();
  const auto inside = [&](const Coord& p) {
    return p.x() * p.x() + p.y() * p.y() + p.z() * p.z() < radius * radius;
  };
  for (const Coord& p : openvdb::CoordBBox(Coord(-radius), Coord(radius))) {
    if (inside(p)) {
      to.setValue(p, value_at<ValueT>(p));
    } else if (const std::uint32_t kinds = noise(p & ~7) % 4; kinds > 0 && to.isVoxel(p)) {
      to.setValueOff(p, value_at<ValueT>(Coord(static_cast<int>(noise(p) % (3 * kinds - 2)))));
    }
  }
  grid->setName(name);
  grid->setSaveFloatAsHalf(half);
  return grid;
}

std::filesystem::path written(const openvdb::GridCPtrVec& grids, std::uint32_t compression,
                              const std::string& name = "made.vdb") {
  const auto path = test::scratch_dir() / name;
  openvdb::io::File file(path.string());
  file.setCompression(compression);
  file.write(grids);
  return path;
}

/// All values of all leaves are those of OpenVDB's reader. Both convert by static_cast<float>.
template <typename GridT>
void expect_values_of_openvdb(const std::filesystem::path& path, const std::string& name) {
  const Field field = VdbFile(path).read(name, {GridRole::data});
  const auto grid = openvdb::gridPtrCast<GridT>(test::openvdb_grid(path, name));
  ASSERT_EQ(field.leaves.size(), grid->tree().leafCount());
  for (const Leaf& leaf : field.leaves) {
    const Coord origin(leaf.origin.x, leaf.origin.y, leaf.origin.z);
    const auto* expected = grid->tree().probeConstLeaf(origin);
    ASSERT_NE(expected, nullptr);
    for (openvdb::Index n = 0; n < expected->SIZE; ++n) {
      const auto value = expected->getValue(n);
      if constexpr (openvdb::VecTraits<typename GridT::ValueType>::IsVec) {
        for (openvdb::Index c = 0; c < 3; ++c)
          ASSERT_EQ(leaf.values[n * 3 + c], static_cast<float>(value[static_cast<int>(c)]));
      } else {
        ASSERT_EQ(leaf.values[n], static_cast<float>(value)) << name << " at " << origin;
      }
    }
  }
}

std::vector<std::uint32_t> codecs() {
  using namespace openvdb::io;
  std::vector<std::uint32_t> all{COMPRESS_NONE, COMPRESS_ACTIVE_MASK};
  for (const std::uint32_t codec : {COMPRESS_ZIP, COMPRESS_BLOSC}) {
    if (codec == COMPRESS_ZIP && !Archive::hasZLibCompression()) continue;
    if (codec == COMPRESS_BLOSC && !Archive::hasBloscCompression()) continue;
    all.push_back(codec);
    all.push_back(codec | COMPRESS_ACTIVE_MASK);
  }
  return all;
}

TEST(VdbReading, EveryCodecAndTypeGivesTheValuesOfOpenVdb) {
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(
        {ball<openvdb::FloatGrid>("float", 40), ball<openvdb::FloatGrid>("half", 20, /*half=*/true),
         ball<openvdb::DoubleGrid>("double", 20), ball<openvdb::Int32Grid>("int32", 20),
         ball<openvdb::Int64Grid>("int64", 20), ball<openvdb::BoolGrid>("bool", 20),
         ball<openvdb::Vec3SGrid>("vec3s", 20),
         ball<openvdb::Vec3DGrid>("vec3d", 20, /*half=*/true),
         ball<openvdb::Vec3IGrid>("vec3i", 20)},
        codec);
    expect_values_of_openvdb<openvdb::FloatGrid>(path, "float");
    expect_values_of_openvdb<openvdb::FloatGrid>(path, "half");
    expect_values_of_openvdb<openvdb::DoubleGrid>(path, "double");
    expect_values_of_openvdb<openvdb::Int32Grid>(path, "int32");
    expect_values_of_openvdb<openvdb::Int64Grid>(path, "int64");
    expect_values_of_openvdb<openvdb::BoolGrid>(path, "bool");
    expect_values_of_openvdb<openvdb::Vec3SGrid>(path, "vec3s");
    expect_values_of_openvdb<openvdb::Vec3DGrid>(path, "vec3d");
    expect_values_of_openvdb<openvdb::Vec3IGrid>(path, "vec3i");
  }
}

/// What `use` reads of a file, by the system's count.
Reads reads_of(const std::filesystem::path& path, const std::function<void(const VdbFile&)>& use) {
  VdbFile(path).info();  // threads, and what else a process reads once
  const Reads before = reads_of_process();
  use(VdbFile(path));
  const Reads after = reads_of_process();
  return {after.bytes - before.bytes, after.calls - before.calls};
}

void expect_read_once(const std::filesystem::path& path, const Reads& reads) {
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  ASSERT_GT(size, 1 << 20) << "too small to tell";
  EXPECT_LE(static_cast<double>(reads.bytes), 1.2 * static_cast<double>(size)) << path;
  EXPECT_LE(reads.calls, size / (256 << 10) + 100) << path;
}

TEST(VdbReading, EachByteIsReadAboutOnceInFewCalls) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const openvdb::GridCPtrVec grids{
      ball<openvdb::FloatGrid>("density", 50), ball<openvdb::FloatGrid>("heat", 40, true),
      ball<openvdb::Vec3SGrid>("velocity", 40), ball<openvdb::FloatGrid>("fuel", 30)};
  const auto all = [](const VdbFile& file) {
    for (const std::string& name : file.names()) file.read(name);
  };
  const auto everything = [&](const VdbFile& file) {
    file.info();
    all(file);
    file.read("density", {GridRole::data});
  };
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written(grids, codec);
    expect_read_once(path, reads_of(path, all));
    expect_read_once(path, reads_of(path, everything));
  }
  const auto piped = test::scratch_dir() / "piped.vdb";
  {
    std::ofstream out(piped, std::ios::binary);
    openvdb::io::Stream(out).write(grids);
  }
  expect_read_once(piped, reads_of(piped, all));
}

TEST(VdbReading, WhatIsNotAskedForIsNotRead) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path =
      written({ball<openvdb::FloatGrid>("small", 20), ball<openvdb::FloatGrid>("large", 60)},
              openvdb::io::COMPRESS_ACTIVE_MASK);
  const std::int64_t size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.names(); }).bytes, size / 10);
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.read("small"); }).bytes, size / 4);
  EXPECT_LT(reads_of(path, [](const VdbFile& file) { file.info(/*values=*/false); }).bytes,
            size / 4);
}

TEST(VdbReading, TopologyAloneGivesAllButValues) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 20),
                             ball<openvdb::Vec3SGrid>("velocity", 20, /*half=*/true)},
                            openvdb::io::COMPRESS_ACTIVE_MASK);
  const VdbFile file(path);
  const std::vector<GridInfo> all = file.info(), some = file.info(/*values=*/false);
  ASSERT_EQ(some.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_TRUE(all[n].values);
    EXPECT_FALSE(some[n].values);
    EXPECT_FALSE(some[n].values_read);
    EXPECT_EQ(some[n].problem, "");
    EXPECT_EQ(some[n].leaves, all[n].leaves);
    EXPECT_EQ(some[n].active_voxels, all[n].active_voxels);
    EXPECT_EQ(some[n].active_box, all[n].active_box);
    EXPECT_EQ(some[n].world_max, all[n].world_max);
    EXPECT_EQ(some[n].metadata, all[n].metadata);
  }
}

TEST(VdbReading, AFieldThatIsHeldSharesItsValuesWithTheNextIfNoneChanges) {
  const auto grid = vdb::new_grid<openvdb::FloatGrid>();
  grid->setName("positive");
  grid->tree().setValue(Coord(1, 2, 3), 4.0f);
  const auto signed_grid = grid->deepCopy();
  signed_grid->setName("signed");
  signed_grid->tree().setValue(Coord(1, 2, 4), -4.0f);
  const VdbFile file(test::write_vdb({grid, signed_grid}));
  const auto read = [&](const std::string& name, GridRole role) { return file.read(name, {role}); };

  Field held = read("positive", GridRole::attenuation);
  const Field data = read("positive", GridRole::data);
  EXPECT_EQ(data.leaves.at(0).values, held.leaves.at(0).values);
  EXPECT_EQ(data.active_range, glm::vec2(4, 4));
  held = {};
  EXPECT_EQ(test::FieldSampler(data).voxel({1, 2, 3}, 0), 4.0);

  // An attenuation must not be negative, data may be: neither field changes the other.
  const Field as_data = read("signed", GridRole::data);
  const Field as_attenuation = read("signed", GridRole::attenuation);
  const Field as_data_again = read("signed", GridRole::data);
  EXPECT_EQ(test::FieldSampler(as_data).voxel({1, 2, 4}, 0), -4.0);
  EXPECT_EQ(test::FieldSampler(as_attenuation).voxel({1, 2, 4}, 0), 0.0);
  EXPECT_EQ(test::FieldSampler(as_data_again).voxel({1, 2, 4}, 0), -4.0);
}

TEST(VdbReading, AFileThatShrinksMeanwhileIsAnError) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  const VdbFile file(path);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_NE(input_error([&] { file.read("density"); }).find("the file ends too early"),
            std::string::npos);
}

/// A grid's values stay in the file: its field has all that the whole one has, and the same values.
void expect_stored_like_whole(const std::filesystem::path& path, const std::string& name,
                              ReadOptions options) {
  SCOPED_TRACE(name);
  const auto file = std::make_unique<VdbFile>(path);
  options.percentiles = {1, 50};
  const Field whole = file->read(name, options);
  options.memory = 1;
  const Field stored = VdbFile(path).read(name, options);  // the field outlives the file's object
  ASSERT_TRUE(stored.reader);
  EXPECT_FALSE(whole.reader);
  EXPECT_EQ(stored.name, whole.name);
  EXPECT_EQ(stored.value_type, whole.value_type);
  EXPECT_EQ(stored.active_box, whole.active_box);
  EXPECT_EQ(stored.active_voxels, whole.active_voxels);
  EXPECT_EQ(stored.world_from_index, whole.world_from_index);
  EXPECT_EQ(stored.notices, whole.notices);
  EXPECT_EQ(stored.active_percentiles, whole.active_percentiles);
  EXPECT_EQ(glm::dvec2(*stored.stored_range), stored_range(whole));
  EXPECT_EQ(glm::dvec2(*stored.active_range), active_range(whole));
  ASSERT_EQ(stored.tiles.size(), whole.tiles.size());
  for (std::size_t n = 0; n < whole.tiles.size(); ++n) {
    EXPECT_EQ(stored.tiles[n].origin, whole.tiles[n].origin);
    EXPECT_EQ(stored.tiles[n].value, whole.tiles[n].value);
  }
  ASSERT_EQ(stored.leaves.size(), whole.leaves.size());
  std::size_t seen = 0;
  const auto length = 512 * std::size_t(whole.channels);
  visit_leaves(stored, [&](std::span<const Leaf> leaves) {
    for (const Leaf& leaf : leaves) {
      ASSERT_EQ(leaf.origin, whole.leaves[seen].origin);
      ASSERT_EQ(std::memcmp(leaf.values, whole.leaves[seen].values, length * sizeof(float)), 0);
      ++seen;
    }
  });
  EXPECT_EQ(seen, whole.leaves.size());
}

/// The same of a grid whose leaves the caller surveys, here in two parts.
void expect_surveyed_like_whole(const std::filesystem::path& path, const std::string& name,
                                ReadOptions options) {
  SCOPED_TRACE(name + ", surveyed in parts");
  const Field whole = VdbFile(path).read(name, options);
  options.in_file = options.unsurveyed = true;
  Field stored = VdbFile(path).read(name, options);
  ASSERT_TRUE(stored.reader && stored.survey);
  ASSERT_EQ(stored.leaves.size(), whole.leaves.size());
  std::vector<std::uint32_t> odd, even;
  for (std::uint32_t n = 0; n < stored.leaves.size(); ++n) (n % 2 ? odd : even).push_back(n);
  const auto length = 512 * std::size_t(whole.channels);
  std::vector<float> values(even.size() * length);
  const ValueSurvey some = stored.reader->survey(odd, values.data());
  const ValueSurvey all = some + stored.reader->survey(even, values.data());
  const float largest = take_survey(stored, all, options, "it ");
  for (std::size_t n = 0; n < even.size(); ++n)
    for (std::size_t i = 0; i < length; ++i)
      ASSERT_EQ(std::min(values[n * length + i], largest), whole.leaves[even[n]].values[i]);
  EXPECT_EQ(stored.notices, whole.notices);
  EXPECT_EQ(glm::dvec2(*stored.stored_range), stored_range(whole));
  EXPECT_EQ(glm::dvec2(*stored.active_range), active_range(whole));
  for (std::size_t n = 0; n < whole.tiles.size(); ++n)
    EXPECT_EQ(stored.tiles.at(n).value, whole.tiles[n].value);
}

TEST(VdbReading, ValuesThatStayInTheFileAreThoseOfTheWhole) {
  for (const std::uint32_t codec : codecs()) {
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto tiles = ball<openvdb::FloatGrid>("tiles", 20);
    auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(tiles)->tree();
    tree.addTile(1, Coord(-64, 8, 16), 7.0f, true);
    tree.addTile(2, Coord(-256, 0, 0), 3.0f, false);
    tree.addTile(3, Coord(8192, 0, -4096), 5.0f, true);
    const auto path = written(
        {ball<openvdb::FloatGrid>("float", 40), ball<openvdb::FloatGrid>("half", 20, /*half=*/true),
         ball<openvdb::DoubleGrid>("double", 20), ball<openvdb::Int64Grid>("int64", 20),
         ball<openvdb::BoolGrid>("bool", 20), ball<openvdb::Vec3SGrid>("vec3s", 20),
         ball<openvdb::Vec3DGrid>("vec3d", 20, /*half=*/true), tiles},
        codec);
    for (const char* name :
         {"float", "half", "double", "int64", "bool", "vec3s", "vec3d", "tiles"}) {
      expect_stored_like_whole(path, name, {GridRole::attenuation});
      expect_stored_like_whole(path, name, {GridRole::data});
      expect_surveyed_like_whole(path, name, {GridRole::data});
    }
  }
}

TEST(VdbReading, BadValuesThatStayInTheFileAreReplacedAsInTheWhole) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const auto grid = ball<openvdb::FloatGrid>("density", 20);
  auto& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree();
  tree.setValue(Coord(1, 2, 3), infinite);
  tree.setValue(Coord(9, 2, 3), -infinite);
  tree.setValue(Coord(1, -2, 3), std::numeric_limits<float>::quiet_NaN());
  tree.setValue(Coord(-1, -2, 3), -4.0f);
  tree.addTile(1, Coord(-64, 8, 16), infinite, true);
  tree.addTile(1, Coord(-72, 8, 16), -1.0f, true);
  tree.addTile(1, Coord(-80, 8, 16), 900.0f, true);
  const auto path = written({grid}, openvdb::io::COMPRESS_ACTIVE_MASK);
  for (const GridRole role : {GridRole::attenuation, GridRole::data}) {
    expect_stored_like_whole(path, "density", {role});
    expect_surveyed_like_whole(path, "density", {role});
    ReadOptions strict{.role = role, .strict = true, .memory = 1};
    EXPECT_NE(input_error([&] { VdbFile(path).read("density", strict); }).find("refused by strict"),
              std::string::npos);
  }
}

TEST(VdbReading, APartReadsItsLeavesAlone) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  const Field whole = VdbFile(path).read("density");
  const Field stored = VdbFile(path).read("density", {.memory = 1});
  const Box box{glm::ivec3(-20, 3, 10), glm::ivec3(15, 16, 31)};
  const Reads before = reads_of_process();
  const Field part = part_of_field(stored, box);
  const Reads after = reads_of_process();
  EXPECT_FALSE(part.reader);
  // from leaves -24..8, 0..16 and 8..24, which are 2113 bytes each, and gaps of one leaf at most
  EXPECT_EQ(part.leaves.size(), 5u * 3 * 3);
  EXPECT_LT(after.bytes - before.bytes, 45 * 2 * 2113);
  const test::FieldSampler sampler(whole);
  for (const Leaf& leaf : part.leaves)
    EXPECT_EQ(double(leaf.values[74]), sampler.voxel(leaf.origin + glm::ivec3(1, 1, 2), 0));
  const Field same = part_of_field(whole, box);
  ASSERT_EQ(same.leaves.size(), part.leaves.size());
  std::filesystem::resize_file(path, 1000);
  EXPECT_NE(input_error([&] {
              part_of_field(stored, Box{glm::ivec3(-60), glm::ivec3(60)});
            }).find("cannot be read again"),
            std::string::npos);
}

/// The place of text in a file [bytes].
std::streamoff place_of(const std::filesystem::path& path, const std::string& text) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const auto place = bytes.find(text);
  EXPECT_NE(place, std::string::npos) << text;
  return static_cast<std::streamoff>(place);
}

void change_byte(const std::filesystem::path& path, std::streamoff place) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(place);
  const int byte = file.get();
  file.seekp(place);
  file.put(static_cast<char>(byte ^ 0x15));
}

const std::string delayed_load =
    "__delayedload";  // type of the metadata that have lengths of leaves

TEST(VdbReading, PlacesOfLeavesComeFromMetadataOrFromTheLeaves) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  const auto grids = {
      ball<openvdb::FloatGrid>("float", 40), ball<openvdb::FloatGrid>("half", 40, /*half=*/true),
      ball<openvdb::DoubleGrid>("double", 40), ball<openvdb::Vec3SGrid>("vec3s", 40)};
  for (const std::uint32_t codec : codecs()) {
    if (!(codec & (openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_BLOSC))) continue;
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    for (const auto& grid : grids) {
      SCOPED_TRACE(grid->getName());
      const auto path = written({grid}, codec);
      const ReadOptions options{.role = GridRole::data, .in_file = true, .unsurveyed = true};
      const auto read = [&](const VdbFile& file) { file.read(grid->getName(), options); };
      const std::int64_t few = 50;
      ASSERT_GT(VdbFile(path).read(grid->getName()).leaves.size(), 4 * few);
      EXPECT_LT(reads_of(path, read).calls, few);
      change_byte(path, place_of(path, delayed_load));
      EXPECT_GT(reads_of(path, read).calls, 4 * few);
      expect_surveyed_like_whole(path, grid->getName(), {GridRole::data});
    }
  }
}

/// The metadata may claim anything: psivox reads the values that are there, or none.
TEST(VdbReading, WrongLengthsOfLeavesGiveNoWrongValues) {
  const auto grid = ball<openvdb::FloatGrid>("density", 20);
  const auto path = written({grid}, openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  const Field whole = VdbFile(path).read("density");
  std::vector<std::uint32_t> all(whole.leaves.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<float> values(512 * all.size());
  const std::streamoff first = place_of(path, delayed_load) + std::streamoff(delayed_load.size());
  std::uint32_t length = 0;
  std::ifstream(path, std::ios::binary)
      .seekg(first)
      .read(reinterpret_cast<char*>(&length), sizeof length);
  ASSERT_GT(length, 100u);
  std::size_t refused = 0;
  for (std::uint32_t n = 4; n < 4 + length; n += 1 + length / 200) {
    change_byte(path, first + n);
    std::ranges::fill(values, -1.0f);
    try {
      const Field stored = VdbFile(path).read("density", {.in_file = true, .unsurveyed = true});
      stored.reader->survey(all, values.data());
      for (const std::uint32_t leaf : all)
        ASSERT_EQ(std::memcmp(values.data() + 512 * leaf, whole.leaves[leaf].values, 2048), 0) << n;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::input) << error.what();
      ++refused;
    }
    change_byte(path, first + n);  // as it was
  }
  EXPECT_LT(refused, 100u) << "most changes only make it walk";
}

/// What four ranks read of a file together, to know ranges, extinction and camera: each value
/// once, and each rank the topology and some bytes of each leaf.
TEST(VdbReading, RanksShareTheValuesOfAFile) {
  if (reads_of_process().calls == 0) GTEST_SKIP() << "this system does not count what is read";
  using namespace openvdb::io;
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)},
                            Archive::hasBloscCompression() ? COMPRESS_BLOSC : COMPRESS_ZIP);
  Scene scene;
  scene.input = path.string();
  const View alone = make_view(scene, VdbFile(path));
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  const Reads before = reads_of_process();
  const auto errors = test::on_ranks(4, [&](const std::shared_ptr<Ranks>& ranks) {
    const View view = make_view(
        scene, read_fields(scene, VdbFile(path), false, {.allowed = true, .ranks = ranks}));
    EXPECT_EQ(active_range(*view.medium.density), active_range(*alone.medium.density));
    EXPECT_EQ(view.camera.position, alone.camera.position);
    // a sum of 289 integrals for each axis, added up in another order
    EXPECT_NEAR(view.medium.extinction / alone.medium.extinction, 1, 1e-12);
  });
  EXPECT_EQ(errors, std::vector<std::string>(4, ""));
  const auto reads = static_cast<double>(reads_of_process().bytes - before.bytes);
  // of about 1000 bytes that a leaf has, each rank reads 64 of topology and a few of its length
  EXPECT_LT(reads, (1 + 4 * 0.1) * size);
  EXPECT_GT(reads, size);
}

TEST(VdbReading, AGridThatMustBeConvertedWholeIsRefusedBeyondItsMemory) {
  const auto grid = ball<openvdb::FloatGrid>("distance", 40);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree().root().setBackground(3.0f, true);
  const auto path = written({grid}, openvdb::io::COMPRESS_NONE);
  try {
    VdbFile(path).read("distance", {.memory = 1000});
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::memory);
    EXPECT_NE(std::string(e.what()).find("a level set is converted whole"), std::string::npos);
  }
}

/// Whether a block of values may begin here: an integer of 64 bits, as short as this file's blocks.
bool is_length(const std::string& bytes, std::size_t at) {
  std::int64_t length = 0;
  std::memcpy(&length, bytes.data() + at, sizeof length);
  return length != 0 && std::abs(length) < 1 << 18;
}

/// How often the reader refuses a block if `change` is done to each possible one, one at a time.
/// Other bytes may look like a length: what comes of them must be an error or a field.
int refusals(const std::filesystem::path& path, const std::function<void(char*)>& change) {
  const std::string good = test::file_bytes(path);
  int refused = 0;
  const std::size_t tree = good.find("UniformScaleMap");  // the transform comes before the tree
  for (std::size_t at = tree; at + 24 < good.size(); ++at) {
    if (!is_length(good, at)) continue;
    std::string bad = good;
    change(&bad[at]);
    try {
      VdbFile(test::write_bytes("bad.vdb", bad)).read("density");
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::input) << e.what();
      if (std::string(e.what()).find("impossible length") != std::string::npos) ++refused;
    }
  }
  return refused;
}

TEST(VdbReading, ABlockOfImpossibleLengthIsAnError) {
  const auto change = [](std::size_t offset, auto value) {
    return [=](char* block) { std::memcpy(block + offset, &value, sizeof value); };
  };
  const auto grid = vdb::new_grid<openvdb::FloatGrid>();
  grid->setName("density");
  for (const Coord& p : openvdb::CoordBBox(Coord(0), Coord(6)))
    grid->tree().setValue(p, value_at<float>(p));
  for (const openvdb::Index level : {1, 2})  // so that the blocks of both inner nodes have a value
    grid->tree().addTile(level, Coord(128 * static_cast<int>(level), 0, 0), 1.0f, true);
  constexpr int blocks = 3;  // of the leaf and the two nodes above it
  for (const std::uint32_t codec : codecs()) {
    if (codec < openvdb::io::COMPRESS_ZIP || codec == openvdb::io::COMPRESS_ACTIVE_MASK) continue;
    SCOPED_TRACE(openvdb::io::compressionToString(codec));
    const auto path = written({grid}, codec);
    // More bytes than a leaf has: OpenVDB would write them behind its buffer.
    EXPECT_GE(refusals(path, change(0, std::int64_t{-3000})), blocks);
    if (!(codec & openvdb::io::COMPRESS_BLOSC)) continue;
    const std::int32_t too_much = 1 << 30;
    EXPECT_GE(refusals(path, change(8 + 4, too_much)), blocks) << "before Blosc";
    EXPECT_GE(refusals(path, change(8 + 12, too_much)), blocks) << "after Blosc";
  }
}

TEST(VdbReading, ProgressGrowsToTheEndAndMayEndTheReading) {
  const auto path = written({ball<openvdb::FloatGrid>("density", 60)}, openvdb::io::COMPRESS_NONE);
  std::vector<double> told;
  VdbFile(path, [&](double fraction) { told.push_back(fraction); }).read("density");
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.size(), 3u);
  EXPECT_GT(told.back(), 0.5);
  EXPECT_LE(told.back(), 1.0);
  struct Ended {};
  const VdbFile ended(path, [](double fraction) {
    if (fraction > 0.3) throw Ended();
  });
  EXPECT_THROW(ended.read("density"), Ended);
}

}  // namespace
}  // namespace psivox
