#pragma once

// Small grids of every kind that files of other programs have, for tests/zoo_test.cpp.

#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "vdb_test_util.h"

namespace psivox::test {

using openvdb::Vec3d;
using openvdb::Vec3s;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// --- shapes: values of a voxel, around the origin -----------------------------------------------

/// 1 at the most, and fading to 0 at about 12 voxels: lumps that the light shows, narrow at the
/// top, which leans to +x.
inline double cloud(const Coord& p) {
  const double x = p.x() - 0.25 * (p.y() + 8), y = p.y(), z = p.z();
  const double lumps = std::sin(0.6 * x + 1) * std::sin(0.5 * y) * std::sin(0.7 * z);
  const double wide = 1.1 - 0.03 * y;
  const double distance2 = (x * x + z * z) / (wide * wide) + y * y;
  return std::clamp(1.2 * (1 - distance2 / 144) + 0.5 * lumps, 0.0, 1.0);
}
/// The part of the cloud that burns: its lower half.
inline double flame(const Coord& p) { return cloud(p) * std::clamp(-0.12 * p.y() + 0.1, 0.0, 1.0); }
/// Distance to a torus that lies around the y axis.
inline double torus(const Coord& p) {
  return std::hypot(std::hypot(p.x(), p.z()) - 8, p.y()) - 3.5;
}
/// Waves of both signs in a ball.
inline double waves(const Coord& p) {
  return p.asVec3d().length() > 12 ? 0
                                   : std::sin(0.4 * p.x()) * std::cos(0.3 * p.y() + 0.2 * p.z());
}
/// Turns around the y axis.
inline Vec3d whirl(const Coord& p) { return cloud(p) * Vec3d(p.z(), 4, -p.x()) / 4; }
/// Colours of the cloud: red to the right, green upwards, blue to the front.
inline Vec3d hues(const Coord& p) {
  return cloud(p) <= 0 ? Vec3d(0) : Vec3d(0.5) + p.asVec3d() / 26;
}

// --- grids ---------------------------------------------------------------------------------------

/// Sets voxels within `radius` to shape(p), where that is not 0. The class is fog if it is a
/// scalar.
template <typename GridT = FloatGrid, typename Shape>
typename GridT::Ptr filled(const std::string& name, Shape&& shape, int radius = 13) {
  using Value = typename GridT::ValueType;
  auto grid = named<GridT>(name);
  auto to = grid->getAccessor();
  for (const Coord& p : CoordBBox(Coord(-radius), Coord(radius)))
    if (const auto value = shape(p); value != decltype(value)(0)) to.setValue(p, Value(value));
  if constexpr (!openvdb::VecTraits<Value>::IsVec) grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

template <typename Grid>
Grid of_no_class(Grid grid) {
  return of_class(grid, openvdb::GRID_UNKNOWN);
}

/// The same grid with world_from_index of another kind.
template <typename Grid>
Grid placed(Grid grid, const Transform::Ptr& world_from_index) {
  grid->setTransform(world_from_index);
  return grid;
}
/// From the world's axes of a voxel, and where voxel 0 is.
inline Transform::Ptr axes(const Vec3d& x, const Vec3d& y, const Vec3d& z,
                           const Vec3d& at = Vec3d(0)) {
  openvdb::math::Mat4d m;  // OpenVDB multiplies rows
  m.setRows({x[0], x[1], x[2], 0}, {y[0], y[1], y[2], 0}, {z[0], z[1], z[2], 0},
            {at[0], at[1], at[2], 1});
  return Transform::createLinearTransform(m);
}

/// The same grid with another value outside its voxels.
template <typename Grid, typename Value>
Grid on_background(Grid grid, const Value& value) {
  grid->tree().root().setBackground(value, true);
  return grid;
}

/// Active voxels of one value.
inline FloatGrid::Ptr constant(const std::string& name, float value, int radius = 13) {
  auto grid = named(name);
  grid->tree().fill(CoordBBox(Coord(-radius), Coord(radius)), value, true);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

/// A level set as OpenVDB makes it: a band of 3 voxels, and the inside of it inactive and negative.
template <typename GridT = FloatGrid>
typename GridT::Ptr level_set(const std::string& name) {
  using Value = typename GridT::ValueType;
  auto grid = on_background(named<GridT>(name), Value(3));
  auto to = grid->getAccessor();
  for (const Coord& p : CoordBBox(Coord(-15), Coord(15)))
    if (const double d = torus(p); std::abs(d) < 3)
      to.setValue(p, Value(d));
    else if (d < 0)
      to.setValueOff(p, Value(-3));
  return of_class(grid, openvdb::GRID_LEVEL_SET);
}

/// Points on a torus, more of them to the right, as Houdini and Blender write them: fixed-point
/// positions, and an attribute `id`.
inline openvdb::GridBase::Ptr points(const std::string& name) {
  namespace points = openvdb::points;
  openvdb::initialize();
  std::vector<openvdb::Vec3R> positions;
  for (int i = 0; i < 6000; ++i) {
    const double a = 2.4 * i, b = 0.0061803 * i * (1 + 0.4 * std::sin(a));
    const double around = 8 + 3.5 * std::cos(b);
    positions.emplace_back(around * std::cos(a), 3.5 * std::sin(b), around * std::sin(a));
  }
  const points::PointAttributeVector<openvdb::Vec3R> wrapped(positions);
  const auto transform = Transform::createLinearTransform(1);
  const auto index =
      openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(wrapped, *transform);
  const auto grid =
      points::createPointDataGrid<points::FixedPointCodec<false>, points::PointDataGrid>(
          *index, wrapped, *transform);
  points::appendAttribute<std::int32_t>(grid->tree(), "id");
  grid->setName(name);
  return grid;
}

}  // namespace psivox::test
