#pragma once

// Files whose every leaf is stored in another way, and what is read of them.

#include <openvdb/io/Compression.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "psivox/vdb.h"
#include "scratch.h"
#include "vdb_test_util.h"

#ifndef PSIVOX_NANOVDB_CONVERT
#define PSIVOX_NANOVDB_CONVERT ""
#endif

namespace psivox::test {

/// What the process has read so far. The system counts every call, of all libraries.
struct Reads {
  std::int64_t bytes = 0, calls = 0;
};

inline Reads reads_of_process() {
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
inline std::uint32_t noise(const openvdb::Coord& p) {
  const auto x = static_cast<std::uint32_t>(p.x()), y = static_cast<std::uint32_t>(p.y()),
             z = static_cast<std::uint32_t>(p.z());
  std::uint32_t hash = x * 73856093u ^ y * 19349663u ^ z * 83492791u;
  hash ^= hash >> 13;
  hash *= 0x5bd1e995u;
  return hash ^ hash >> 15;
}

template <typename ValueT>
ValueT value_at(const openvdb::Coord& p) {
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
  const auto grid = new_grid<GridT>();
  using ValueT = typename GridT::ValueType;
  auto to = grid->getAccessor();
  const auto inside = [&](const openvdb::Coord& p) {
    return p.x() * p.x() + p.y() * p.y() + p.z() * p.z() < radius * radius;
  };
  for (const openvdb::Coord& p :
       openvdb::CoordBBox(openvdb::Coord(-radius), openvdb::Coord(radius))) {
    if (inside(p)) {
      to.setValue(p, value_at<ValueT>(p));
    } else if (const std::uint32_t kinds = noise(p & ~7) % 4; kinds > 0 && to.isVoxel(p)) {
      to.setValueOff(
          p, value_at<ValueT>(openvdb::Coord(static_cast<int>(noise(p) % (3 * kinds - 2)))));
    }
  }
  grid->setName(name);
  grid->setSaveFloatAsHalf(half);
  return grid;
}

/// The ball, with tiles of each size, at a place of its own.
template <typename GridT>
openvdb::GridBase::Ptr ball_with_tiles(const std::string& name) {
  using ValueT = typename GridT::ValueType;
  const auto base = ball<GridT>(name, 14);
  auto& tree = static_cast<GridT&>(*base).tree();
  tree.addTile(1, openvdb::Coord(64, 0, 0), ValueT(3), true);
  tree.addTile(2, openvdb::Coord(-256, 0, 0), ValueT(1), true);
  tree.addTile(3, openvdb::Coord(-8192, 0, 4096), ValueT(1), false);
  auto transform = openvdb::math::Transform::createLinearTransform(0.25);
  transform->postRotate(0.3, openvdb::math::Y_AXIS);
  transform->postTranslate({1, 2, 3});
  base->setTransform(transform);
  return base;
}

/// A ball of radius 12 with a band of 3 voxels; deeper parts are a tile.
template <typename GridT>
typename GridT::Ptr level_set_ball(const std::string& name) {
  using ValueT = typename GridT::ValueType;
  auto grid = of_class(named<GridT>(name), openvdb::GRID_LEVEL_SET);
  grid->tree().root().setBackground(ValueT(3), /*updateChildNodes=*/false);
  for (const Coord& c : CoordBBox(Coord(-16), Coord(23))) {
    // In eighths, which a float holds exactly.
    const double distance = std::round((c.asVec3d() - openvdb::Vec3d(4)).length() * 8 - 96) / 8;
    const auto value = static_cast<ValueT>(std::clamp(distance, -3.0, 3.0));
    if (std::abs(distance) < 3)
      grid->tree().setValue(c, value);
    else
      grid->tree().setValueOff(c, value);
  }
  grid->tree().addTile(1, Coord(0), ValueT(-3), false);
  return grid;
}

inline std::filesystem::path written(const openvdb::GridCPtrVec& grids, std::uint32_t compression,
                                     const std::string& name = "made.vdb") {
  const auto path = scratch_dir() / name;
  openvdb::io::File file(path.string());
  file.setCompression(compression);
  file.write(grids);
  return path;
}

inline constexpr const char* no_nano_tool = "no nanovdb_convert (Debian: libnanovdb-tools)";
inline bool has_nano_tool() { return *PSIVOX_NANOVDB_CONVERT != 0; }

class NanoTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_nano_tool()) GTEST_SKIP() << no_nano_tool;
  }
};

/// Writes grids, in the order of their names, as a .nvdb by NanoVDB's tool.
inline std::filesystem::path written_nano(const openvdb::GridCPtrVec& grids,
                                          const std::string& options = "",
                                          const std::string& name = "made.nvdb") {
  const auto from = written(grids, openvdb::io::COMPRESS_NONE, "to_convert.vdb"),
             to = scratch_dir() / name;
  const std::string call = "'" PSIVOX_NANOVDB_CONVERT "' --force " + options + " '" +
                           from.string() + "' '" + to.string() + "'";
  EXPECT_EQ(std::system(call.c_str()), 0) << call;
  return to;
}

inline std::vector<std::uint32_t> codecs() {
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

/// What `use` reads of a file, by the system's count.
inline Reads reads_of(const std::filesystem::path& path,
                      const std::function<void(const VolumeFile&)>& use) {
  VolumeFile(path).info();  // threads, and what else a process reads once
  const Reads before = reads_of_process();
  use(VolumeFile(path));
  const Reads after = reads_of_process();
  return {after.bytes - before.bytes, after.calls - before.calls};
}

}  // namespace psivox::test
