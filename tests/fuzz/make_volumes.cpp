// make_volumes FOLDER: small volumes of every type, with each of OpenVDB's codecs, with and without
// positions of their grids. mutated_volumes.py changes them.

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>

#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <vector>

namespace {

using openvdb::Coord;

/// A cube with active and inactive voxels, and a tile of each size.
template <typename GridT>
openvdb::GridBase::Ptr cube(const char* name, int size, bool half) {
  using ValueT = typename GridT::ValueType;
  const auto grid = GridT::create();
  grid->setName(name);
  grid->setSaveFloatAsHalf(half);
  std::mt19937 random(static_cast<unsigned>(size));
  auto to = grid->getAccessor();
  for (const Coord& p : openvdb::CoordBBox(Coord(0), Coord(size - 1))) {
    const unsigned chance = random() % 16;
    if (chance < 12)
      to.setValue(p, ValueT(static_cast<int>(1 + random() % 50)));
    else if (chance < 14)
      to.setValueOff(p, ValueT(static_cast<int>(random() % 7)));
  }
  grid->tree().addTile(1, Coord(64, 0, 0), ValueT(3), true);
  grid->tree().addTile(2, Coord(128, 0, 0), ValueT(3), true);
  grid->tree().addTile(3, Coord(8192, 0, 0), ValueT(0), false);
  grid->insertMeta("note", openvdb::StringMetadata("seed"));
  return grid;
}

/// A few points with an attribute, in two leaves.
openvdb::GridBase::Ptr few_points() {
  using namespace openvdb;
  const std::vector<Vec3f> at{{1, 1, 1}, {1, 1, 1.2f}, {2, 3, 4}, {9, 1, 1}};
  const auto transform = math::Transform::createLinearTransform(1);
  const auto grid =
      points::createPointDataGrid<points::FixedPointCodec<false>, points::PointDataGrid>(
          at, *transform);
  points::appendAttribute<float>(grid->tree(), "size", 2);
  grid->setName("points");
  return grid;
}

void write(const std::string& folder, std::uint32_t codec) {
  using namespace openvdb;
  const bool half = codec & 1;
  GridPtrVec grids{cube<FloatGrid>("density", 12, half), cube<Vec3SGrid>("v", 9, half),
                   cube<Int32Grid>("i", 9, false),       cube<BoolGrid>("b", 9, false),
                   cube<DoubleGrid>("d", 9, half),       cube<MaskGrid>("m", 9, false)};
  const std::string name = std::to_string(codec) + ".vdb";
  io::File file(folder + "/codec" + name);
  file.setCompression(codec);
  file.write(grids);
  io::File of_points(folder + "/points" + name);
  of_points.setCompression(codec);
  of_points.write(GridPtrVec{few_points()});
  grids.push_back(few_points());
  std::ofstream pipe(folder + "/piped" + name, std::ios::binary);
  io::Stream stream(pipe);
  stream.setCompression(codec);
  stream.write(grids);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "Usage: make_volumes FOLDER\n";
    return 2;
  }
  openvdb::initialize();
  using namespace openvdb::io;
  for (const std::uint32_t codec : {COMPRESS_ZIP, COMPRESS_ACTIVE_MASK, COMPRESS_BLOSC})
    for (const std::uint32_t mask : {COMPRESS_NONE, COMPRESS_ACTIVE_MASK})
      write(argv[1], codec | mask);
}
