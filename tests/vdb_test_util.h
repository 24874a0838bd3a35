#pragma once

// Shared by the tests of src/vdb: the data folder, files made here.

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "field_voxels.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "scratch.h"

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

/// An empty grid of background 0. OpenVDB's library makes it, because GridT::create() would compile
/// the type's reading, writing and copying once more, which takes 10 s.
template <typename GridT = openvdb::FloatGrid>
typename GridT::Ptr new_grid() {
  openvdb::initialize();
  return openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
}

template <typename GridT = openvdb::FloatGrid>
typename GridT::Ptr named(const std::string& name) {
  auto grid = new_grid<GridT>();
  grid->setName(name);
  return grid;
}

/// A grid of one active voxel.
template <typename GridT = openvdb::FloatGrid>
typename GridT::Ptr voxel(const std::string& name, const typename GridT::ValueType& value,
                          const Coord& at = Coord(0)) {
  auto grid = named<GridT>(name);
  grid->tree().setValue(at, value);
  return grid;
}

/// The same grid of another class.
template <typename GridPtr>
GridPtr of_class(GridPtr grid, openvdb::GridClass its) {
  grid->setGridClass(its);
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

/// The bytes that a pipe gets of the grids: a file without positions.
inline std::string piped_bytes(const openvdb::GridCPtrVec& grids) {
  openvdb::initialize();
  std::ostringstream pipe;
  openvdb::io::Stream(pipe).write(grids);
  return pipe.str();
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

/// A grid read by OpenVDB itself.
inline openvdb::GridBase::Ptr openvdb_grid(const std::filesystem::path& path,
                                           const std::string& name) {
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(/*delayLoad=*/false);
  return file.readGrid(name);
}

}  // namespace psivox::test
