// make_assets DIR: writes the small .vdb files of assets/, with the same bytes on every run.
// make_assets --plume DIR FRAMES VOXELS: writes a sequence, plume.0001.vdb and so on.
// make_assets --empty FILE: writes a density without voxels.
// make_assets --fog FILE VOXELS: writes a dense fog, VOXELS wide, for tests of large volumes.

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;
using openvdb::math::Transform;

// All voxels have indices >= 0, so that each tree has one root node: a root's masks take up most of
// a small file.

/// The grid has no class, because OpenVDB does not zip fog volumes. OpenVDB's library makes it:
/// `GridT::create()` would compile reading, writing and copying again, which takes 10 s.
template <typename GridT>
typename GridT::Ptr new_grid(const std::string& name, const Transform::Ptr& transform) {
  auto grid = openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
  grid->setName(name);
  grid->setTransform(transform);
  return grid;
}

Transform::Ptr scale_and_move(double voxel_size, const Vec3d& origin) {
  auto transform = Transform::createLinearTransform(voxel_size);
  transform->postTranslate(origin);
  return transform;
}

/// Rounds to 7 bits, which zip far better than a float's 24.
float quantised(double value) { return float(std::round(value * 128.0) / 128.0); }

/// Uniform in [0, 1), from an integer point; the finaliser of MurmurHash3.
double hash(int x, int y, int z, std::uint32_t seed) {
  std::uint32_t h = seed + std::uint32_t(x) * 0x9e3779b1u + std::uint32_t(y) * 0x85ebca77u +
                    std::uint32_t(z) * 0xc2b2ae3du;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  h ^= h >> 16;
  return h / 4294967296.0;
}

/// Value noise in [0, 1): hashed lattice values, interpolated smoothly.
double noise(const Vec3d& p, std::uint32_t seed) {
  int cell[3];
  double t[3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = int(std::floor(p[axis]));
    const double f = p[axis] - cell[axis];
    t[axis] = f * f * (3.0 - 2.0 * f);
  }
  double value = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight =
        (dx ? t[0] : 1.0 - t[0]) * (dy ? t[1] : 1.0 - t[1]) * (dz ? t[2] : 1.0 - t[2]);
    value += weight * hash(cell[0] + dx, cell[1] + dy, cell[2] + dz, seed);
  }
  return value;
}

struct Blob {
  Vec3d centre;  ///< fraction of the cluster's cube
  double radius;
  double peak;
};

const Blob kBlobs[] = {{{0.35, 0.36, 0.40}, 0.34, 1.0},
                       {{0.66, 0.38, 0.60}, 0.31, 0.8},
                       {{0.45, 0.68, 0.42}, 0.30, 0.9},
                       {{0.66, 0.73, 0.70}, 0.23, 0.6}};

/// Soft blobs whose rims are eaten by noise; p in the cluster's cube [0,1]^3.
double cluster(const Vec3d& p) {
  double sum = 0.0;
  for (const Blob& blob : kBlobs) {
    const double r = (p - blob.centre).length() / blob.radius;
    if (r < 1.0) sum += blob.peak * (1.0 - r * r) * (1.0 - r * r);
  }
  const double detail = 0.65 * noise(p * 9.0, 1) + 0.35 * noise(p * 19.0, 2);
  return std::clamp(sum * (0.45 + 1.1 * detail) - 0.06, 0.0, 1.0);
}

/// Sets every voxel of a box to value(voxel), unless that is 0.
template <typename GridT, typename F>
void fill(GridT& grid, const CoordBBox& box, F&& value) {
  auto accessor = grid.getAccessor();
  for (const Coord& c : box) {
    const auto v = value(c);
    if (v != openvdb::zeroVal<decltype(v)>()) accessor.setValue(c, v);
  }
}

/// The same in an n^3 cube, by value(centre in [0,1]^3).
template <typename GridT, typename F>
void fill_cube(GridT& grid, int n, F&& value) {
  fill(grid, CoordBBox(Coord(0), Coord(n - 1)), [&](const Coord& c) {
    return value(Vec3d((c.x() + 0.5) / n, (c.y() + 0.5) / n, (c.z() + 0.5) / n));
  });
}

/// A slab of constant 1, 40x24x16 voxels, not aligned to leaves. `density` has leaves only;
/// `density_tiles` has the same values, with tiles where they fit.
openvdb::GridCPtrVec slab() {
  const CoordBBox voxels(Coord(3, 5, 2), Coord(42, 28, 17));
  auto leaves = new_grid<FloatGrid>("density", Transform::createLinearTransform(0.05));
  leaves->tree().denseFill(voxels, 1.0f);
  auto tiles = new_grid<FloatGrid>("density_tiles", Transform::createLinearTransform(0.05));
  tiles->tree().sparseFill(voxels, 1.0f);
  return {leaves, tiles};
}

/// Linear in x from 1/32 to 1, with hard ends: 32x16x16 voxels from the origin.
openvdb::GridCPtrVec ramp() {
  auto grid = new_grid<FloatGrid>("density", Transform::createLinearTransform(0.1));
  fill(*grid, CoordBBox(Coord(0), Coord(31, 15, 15)),
       [](const Coord& c) { return float(c.x() + 1) / 32.0f; });
  return {grid};
}

/// One voxel of 1 in the corner of a leaf. Its tent reaches into seven leaves that do not exist.
openvdb::GridCPtrVec single_voxel() {
  auto grid = new_grid<FloatGrid>("density", Transform::createLinearTransform(1.0));
  grid->tree().setValue(Coord(0), 1.0f);
  return {grid};
}

/// A cloud-like cluster; its temperature [K] is on a coarser lattice, its colour on a still coarser
/// one.
openvdb::GridCPtrVec blobs() {
  constexpr int n = 64, n_temperature = 20, n_color = 16;
  constexpr double width = 3.0;  // width of the cluster's cube [world units]
  const Vec3d corner(-1.5, -1.0, -1.5);
  // Voxel centres of a cube of n voxels are at (i + 1/2) / n of its width.
  const auto transform = [&](int voxels) {
    return scale_and_move(width / voxels, corner + Vec3d(0.5 * width / voxels));
  };
  auto density = new_grid<FloatGrid>("density", transform(n));
  fill_cube(*density, n, [](const Vec3d& p) { return quantised(cluster(p)); });

  auto temperature = new_grid<FloatGrid>("temperature", transform(n_temperature));
  fill_cube(*temperature, n_temperature, [](const Vec3d& p) {
    const double heat = std::exp(-6.0 * (p - Vec3d(0.45, 0.35, 0.45)).lengthSqr());
    return float(std::round((800.0 + 4000.0 * heat) / 32.0) * 32.0);
  });

  auto color = new_grid<Vec3SGrid>("color", transform(n_color));
  fill_cube(*color, n_color, [](const Vec3d& p) {
    return openvdb::Vec3s(quantised(0.2 + 0.8 * p[0]), quantised(0.3 + 0.5 * p[1]),
                          quantised(1.0 - 0.8 * p[0]));
  });
  // Exact: each of these values fits in the 11 bits of a half.
  for (const auto& grid : {openvdb::GridBase::Ptr(density), openvdb::GridBase::Ptr(temperature),
                           openvdb::GridBase::Ptr(color)}) {
    grid->setSaveFloatAsHalf(true);
  }
  return {density, temperature, color};
}

/// Active tiles of 8^3 and 128^3 voxels, leaf voxels next to their faces, and an inactive tile that
/// stores a nonzero value.
openvdb::GridCPtrVec tiles() {
  auto grid = new_grid<FloatGrid>("density", Transform::createLinearTransform(0.02));
  auto& tree = grid->tree();
  tree.addTile(2, Coord(128, 0, 0), 0.25f, true);
  tree.addTile(1, Coord(112, 64, 64), 0.5f, true);
  tree.addTile(1, Coord(120, 40, 64), 1.0f, true);
  tree.addTile(1, Coord(104, 72, 64), 0.75f, false);
  tree.denseFill(CoordBBox(Coord(118, 60, 60), Coord(127, 75, 75)), 0.4f);
  tree.denseFill(CoordBBox(Coord(256, 50, 50), Coord(261, 80, 90)), 0.6f);
  tree.denseFill(CoordBBox(Coord(100, 62, 62), Coord(111, 66, 66)), 0.8f);
  return {grid};
}

/// An off-centre Gaussian in voxels that are stretched, sheared and rotated. Saved as half.
openvdb::GridCPtrVec rotated() {
  auto transform = Transform::createLinearTransform(openvdb::Mat4d::identity());
  transform->postScale(Vec3d(0.04, 0.06, 0.10));
  transform->postShear(0.15, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
  transform->postRotate(0.6, openvdb::math::Z_AXIS);
  transform->postRotate(-0.35, openvdb::math::X_AXIS);
  transform->postRotate(0.9, openvdb::math::Y_AXIS);
  transform->postTranslate(Vec3d(0.7, -0.4, 0.2));
  auto grid = new_grid<FloatGrid>("density", transform);
  grid->setSaveFloatAsHalf(true);
  fill(*grid, CoordBBox(Coord(0), Coord(47, 31, 23)), [](const Coord& c) {
    const double x = (c.x() - 17.0) / 11.0, y = (c.y() - 18.0) / 7.0, z = (c.z() - 9.0) / 4.5;
    const double value = std::exp(-0.5 * (x * x + y * y + z * z + 0.6 * x * y - 0.3 * y * z));
    return value > 1.0 / 256.0 ? float(value) : 0.0f;
  });
  return {grid};
}

/// A plume of smoke that rises, and grows ten times as dense, as `time` goes from 0 to 1, in a box
/// that is n voxels high. It is saved as half.
openvdb::GridCPtrVec plume(int n, double time) {
  auto grid = new_grid<FloatGrid>("density", Transform::createLinearTransform(2.0 / n));
  grid->setSaveFloatAsHalf(true);
  const double top = 0.3 + 0.65 * time;
  fill(*grid, CoordBBox(Coord(0), Coord(n / 2 - 1, n - 1, n / 2 - 1)), [&](const Coord& c) {
    const Vec3d p((c.x() + 0.5) / n - 0.25, (c.y() + 0.5) / n, (c.z() + 0.5) / n - 0.25);
    const double radius = 0.06 + 0.16 * p[1];
    const double inside = 1.0 - (p[0] * p[0] + p[2] * p[2]) / (radius * radius);
    const double under = std::min((top - p[1]) / 0.15, 1.0);
    if (inside <= 0.0 || under <= 0.0) return 0.0f;
    const Vec3d risen = p - Vec3d(0.0, 1.5 * time, 0.0);
    const double detail = 0.6 * noise(risen * 14.0, 3) + 0.4 * noise(risen * 33.0, 4);
    const double value = inside * under * (1.6 * detail - 0.5) * (0.1 + 0.9 * time);
    return float(std::max(value, 0.0));
  });
  return {grid};
}

/// A dense fog in a cube of n voxels, n a multiple of 8, that no codec makes much smaller: each
/// voxel is rough. It has n^3 / 512 leaves.
openvdb::GridCPtrVec fog(int n) {
  auto grid = new_grid<FloatGrid>("density", Transform::createLinearTransform(2.0 / n));
  for (int x = 0; x < n; x += 8)
    for (int y = 0; y < n; y += 8)
      for (int z = 0; z < n; z += 8) {
        auto* leaf = grid->tree().touchLeaf(Coord(x, y, z));
        leaf->setValuesOn();
        float* values = leaf->buffer().data();
        for (int i = 0; i < 512; ++i) {
          const Coord c(x + (i >> 6), y + (i >> 3 & 7), z + (i & 7));
          const Vec3d p = (c.asVec3d() * 2.0 - Vec3d(n - 1)) / n;
          const double smooth = 1.0 - 0.3 * p.lengthSqr();
          values[i] = float(smooth * (0.8 + 0.2 * hash(c.x(), c.y(), c.z(), 9)));
        }
      }
  return {grid};
}

/// OpenVDB gives each file a random identity, after 8 bytes of magic number, three 4-byte versions
/// and one flag. Zeros instead make the bytes reproducible.
void clear_identity(const std::filesystem::path& path) {
  const std::string identity = "00000000-0000-0000-0000-000000000000";
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.exceptions(std::ios::failbit | std::ios::badbit);
  file.seekp(8 + 3 * 4 + 1);
  file.write(identity.data(), std::streamsize(identity.size()));
}

void write(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids) {
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path());
  openvdb::io::File file(path.string());
  file.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  file.write(grids);
  clear_identity(path);
  std::printf("%s %ju bytes\n", path.c_str(), std::filesystem::file_size(path));
}

}  // namespace

int main(int argc, char** argv) try {
  openvdb::initialize();
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "--fog" && argc == 4) {
    write(argv[2], fog(std::stoi(argv[3])));
  } else if (what == "--empty" && argc == 3) {
    write(argv[2], {new_grid<FloatGrid>("density", Transform::createLinearTransform(1.0))});
  } else if (what == "--plume" && argc == 5) {
    const int frames = std::stoi(argv[3]);
    for (int frame = 1; frame <= frames; ++frame) {
      char name[32];
      std::snprintf(name, sizeof name, "plume.%04d.vdb", frame);
      write(std::filesystem::path(argv[2]) / name,
            plume(std::stoi(argv[4]), double(frame - 1) / std::max(frames - 1, 1)));
    }
  } else if (argc == 2) {
    const std::filesystem::path dir = what;
    write(dir / "slab.vdb", slab());
    write(dir / "ramp.vdb", ramp());
    write(dir / "single_voxel.vdb", single_voxel());
    write(dir / "blobs.vdb", blobs());
    write(dir / "tiles.vdb", tiles());
    write(dir / "rotated.vdb", rotated());
  } else {
    std::fprintf(stderr, "usage: make_assets DIR, or make_assets --plume DIR FRAMES VOXELS\n");
    return 2;
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_assets: %s\n", e.what());
  return 1;
}
