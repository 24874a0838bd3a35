#pragma once

// Shared by the tests of src/vdb: the data folder, files made here, and a sampler of Field that
// shares no code with the program.

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "psivox/error.h"
#include "psivox/vdb.h"
#include "grids/grid_types.h"

#ifndef PSIVOX_SHARED_DATA
#define PSIVOX_SHARED_DATA ""
#endif

namespace psivox::test {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::math::Transform;

inline std::filesystem::path data_dir() {
  const char* dir = std::getenv("PSIVOX_DATA");
  return dir ? dir : PSIVOX_SHARED_DATA;
}

inline std::filesystem::path assets_dir() { return PSIVOX_ASSETS; }

/// An empty folder for the files of the running test.
inline std::filesystem::path scratch_dir() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const auto dir = std::filesystem::path(testing::TempDir()) / "psivox_vdb_test" /
                   (std::string(info->test_suite_name()) + "." + info->name());
  std::filesystem::create_directories(dir);
  return dir;
}

/// An empty grid of background 0.
template <typename GridT = openvdb::FloatGrid>
typename GridT::Ptr named(const std::string& name) {
  openvdb::initialize();
  auto grid = vdb::new_grid<GridT>();
  grid->setName(name);
  return grid;
}

/// Writes the grids to a file of the running test.
inline std::filesystem::path write_vdb(const openvdb::GridCPtrVec& grids,
                                       const std::string& name = "made.vdb") {
  openvdb::initialize();
  const auto path = scratch_dir() / name;
  openvdb::io::File(path.string()).write(grids);
  return path;
}

inline std::string file_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::filesystem::path write_bytes(const std::string& name, const std::string& bytes) {
  const auto path = scratch_dir() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// A file's bytes with a value in place of those that begin there.
template <typename T>
std::string with(std::string bytes, std::size_t place, T value) {
  std::memcpy(bytes.data() + place, &value, sizeof value);
  return bytes;
}

inline bool same(const std::vector<Leaf>& a, const std::vector<Leaf>& b, int channels) {
  const std::size_t bytes = 512 * sizeof(float) * static_cast<std::size_t>(channels);
  return std::ranges::equal(a, b, [&](const Leaf& x, const Leaf& y) {
    return x.origin == y.origin && std::memcmp(x.values, y.values, bytes) == 0;
  });
}

inline bool same(const std::vector<Tile>& a, const std::vector<Tile>& b) {
  return std::ranges::equal(a, b, [](const Tile& x, const Tile& y) {
    return x.origin == y.origin && x.width == y.width && x.value == y.value;
  });
}

/// The message of the Error(input) that f throws; fails the test if f throws another or none.
template <typename F>
std::string input_error(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::input) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

/// Values of a Field as field.h documents them: a map look-up for each corner.
class FieldSampler {
 public:
  explicit FieldSampler(const Field& field) : field_(field) {
    for (const Leaf& leaf : field.leaves) {
      EXPECT_TRUE(leaves_.emplace(key(leaf.origin, 8), leaf.values).second) << "leaf twice";
    }
    for (const Tile& tile : field.tiles) {
      EXPECT_NE(tile.value, glm::vec3(0.0f));
      EXPECT_TRUE(tiles_[tile.width].emplace(key(tile.origin, tile.width), tile.value).second);
    }
  }

  double voxel(glm::ivec3 p, int channel) const {
    if (const auto it = leaves_.find(key(p, 8)); it != leaves_.end()) {
      const int n = ((p.x & 7) * 8 + (p.y & 7)) * 8 + (p.z & 7);
      return static_cast<double>(it->second[n * field_.channels + channel]);
    }
    for (const auto& [width, tiles] : tiles_) {
      if (const auto it = tiles.find(key(p, width)); it != tiles.end()) {
        return static_cast<double>(it->second[channel]);
      }
    }
    return 0.0;
  }

  double trilinear(glm::dvec3 p, int channel) const {
    const glm::ivec3 base(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                          static_cast<int>(std::floor(p.z)));
    const glm::dvec3 t = p - glm::dvec3(base);
    double value = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 d(corner & 1, corner >> 1 & 1, corner >> 2);
      double weight = 1.0;
      for (int axis = 0; axis < 3; ++axis) weight *= d[axis] ? t[axis] : 1.0 - t[axis];
      value += weight * voxel(base + d, channel);
    }
    return value;
  }

 private:
  using Key = std::array<int, 3>;

  static Key key(glm::ivec3 p, int width) {
    return {p.x & ~(width - 1), p.y & ~(width - 1), p.z & ~(width - 1)};
  }

  const Field& field_;
  std::map<Key, const float*> leaves_;
  std::map<int, std::map<Key, glm::vec3>> tiles_;
};

/// A grid read by OpenVDB itself.
inline openvdb::GridBase::Ptr openvdb_grid(const std::filesystem::path& path,
                                           const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/false);
  return file.readGrid(name);
}

}  // namespace psivox::test
