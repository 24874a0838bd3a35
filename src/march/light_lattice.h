#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "march/light.h"
#include "march/medium_atlas.h"
#include "psivox/error.h"

namespace psivox {

/// Columns of a brick along each axis across the light, and its slices.
inline constexpr int lattice_columns = 8, lattice_slices = 8;
/// Largest distance between columns [voxels].
inline constexpr int widest_spacing = 4;
/// Depths of a brick.
inline constexpr int lattice_depths_of_brick = lattice_columns * lattice_columns * lattice_slices;

/// Where the lattice of a light lies in the density's voxels. Its slices are those of the voxels
/// across the axis along which the light advances fastest, counted from the light's side; column
/// (i, j) crosses slice w at
///   u = origin + i spacing - w shear   along `axis_u`, and the like with j along `axis_v`.
/// All of it is affine in index space: any transform of the density will do.
struct LatticeFrame {
  const BrickAtlas* density;  ///< that the light shines on; must outlive the frame
  Box domain;                 ///< of the density
  int axis = 2, axis_u = 0, axis_v = 1;
  int side = 1;   ///< 1: the light comes from large coordinates along `axis`, -1: from small ones
  int first = 0;  ///< coordinate of slice 0, such that blocks of 8 voxels are 8 k to 8 k + 7
  /// Of columns along axis_u and axis_v [voxels]. Where it is 1/n or n, columns of a light along an
  /// axis pass through voxels.
  double spacing = 1;
  glm::dvec2 origin{0};
  glm::dvec2 shear{0};        ///< what a ray towards the light advances in a slice [voxels]
  double length = 1;          ///< of a column from slice to slice [world units]
  std::optional<Box> part{};  ///< the atlas's region [voxels]: nothing attenuates beside it

  /// For a beam over the view's density, with the spacing of its method.
  LatticeFrame(const View& view, const MediumAtlas& atlas, const Beam& beam);

  int slice(int coordinate) const { return side > 0 ? first - coordinate : coordinate - first; }
  /// Number of the column, not whole, at a voxel of a slice.
  glm::dvec2 column(const glm::dvec2& voxel, int slice) const {
    return (voxel - origin + double(slice) * shear) / spacing;
  }
  glm::ivec2 across(const glm::ivec3& voxel) const { return {voxel[axis_u], voxel[axis_v]}; }

  /// Makes a region, a box of bricks, the part.
  void set_part(const Box& bricks);

  /// Whether the columns of a brick, from the slice before its first on, may meet the part.
  bool meets_part(const LatticeBrick& brick) const;
};

/// Optical depths from the voxels of blocks to where the light comes in. Beside a kink the
/// cubic may fall below 0. Such depths are kept: without clamping the interpolation is linear in
/// the columns, so that depths of an atlas's parts add up. It keeps one layer of bricks at a time,
/// whatever the volume's size.
void lattice_depths(const LatticeFrame& frame, const LightBlocks& blocks,
                    const LatticeColumns& columns, const TakeDepths& take,
                    const Progress& progress = {});

class LightSlabs;

/// The lattice of one light on its way through the slabs. It keeps the depths at which its columns
/// have come to a slab, and the depths inside a slab of a few rows of tiles at a time, whatever the
/// volume's size.
class LatticeRun {
 public:
  /// It asks for columns where a slab has blocks, beside which nothing attenuates; or from the
  /// light on wherever a wanted block needs them. Slabs and blocks must outlive it.
  LatticeRun(const LatticeFrame& frame, const LightSlabs& slabs, const LightBlocks& blocks,
             TakeDepths take, bool from_light = false);
  ~LatticeRun();
  LatticeRun(LatticeRun&&) noexcept;

  /// Goes on through the slabs whose first slice is below `end`. Columns are asked for in their
  /// order.
  void go_on(int end, const LatticeColumns& columns, const Progress& progress = {});

  /// About what it keeps between slabs [bytes].
  static double bytes(const LatticeFrame& frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Columns which ask for those bricks alone that meet the frame's part, if it has one.
LatticeColumns in_part(const LatticeFrame& frame, const LatticeColumns& columns);

/// Optical depths along the columns of a light's lattice through the atlas of a view, by all
/// threads: columns run along the light and are recorded where they cross the slices of voxels, so
/// that a voxel's depth is interpolated across columns only (after the slices of Lacroute and Levoy
/// 1994). From slice to slice they follow Simpson's rule; where there is a transfer function of the
/// value alone, its integrals over both halves of the step, as if the values were linear there.
/// Reals are float or double; places are double. Frame, view and atlas must outlive what it
/// returns.
template <typename Real>
LatticeColumns light_columns(const LatticeFrame& frame, const View& view, const MediumAtlas& atlas,
                             const Beam& beam);

}  // namespace psivox
