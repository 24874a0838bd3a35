#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "march/light.h"
#include "march/medium_atlas.h"
#include "psivox/error.h"

namespace psivox {

/// Columns of a brick along each axis across the light, and its slices.
inline constexpr int lattice_columns = 8, lattice_slices = 8;
/// Largest distance between columns [voxels].
inline constexpr int widest_spacing = 4;
/// Depths of a slice of a brick, and of a brick.
inline constexpr int lattice_depths_of_slice = lattice_columns * lattice_columns,
                     lattice_depths_of_brick = lattice_depths_of_slice * lattice_slices;

/// The cell of a coordinate. std::floor is a call on machines that all programs run on.
inline int cell_of(double at) {
  const int toward_zero = int(at);
  return toward_zero - (at < toward_zero);
}

/// Where the lattice of a light lies in the density's voxels. Its slices are those of the voxels
/// across the axis along which the light advances fastest, counted from the light's side; column
/// (i, j) crosses slice w at
///   u = origin + i spacing - w shear   along `axis_u`, and the like with j along `axis_v`.
/// All of it is affine in index space: any transform of the density will do.
struct LatticeFrame {
  Box domain;  ///< of the density's atlas
  int axis = 2, axis_u = 0, axis_v = 1;
  int side = 1;   ///< 1: the light comes from large coordinates along `axis`, -1: from small ones
  int first = 0;  ///< coordinate of slice 0, such that blocks of 8 voxels are 8 k to 8 k + 7
  /// Of columns along axis_u and axis_v [voxels]. Where it is 1/n or n, columns of a light along an
  /// axis pass through voxels.
  double spacing = 1;
  glm::dvec2 origin{0};
  glm::dvec2 shear{0};  ///< what a ray towards the light advances in a slice [voxels]
  double length = 1;    ///< of a column from slice to slice [world units]
  double end = 0;       ///< depth at which columns end: deeper ones are interpolated as this

  /// For a beam over the view's density, with the spacing of its method.
  LatticeFrame(const View& view, const Box& domain, const Beam& beam);

  int slice(int coordinate) const { return side > 0 ? first - coordinate : coordinate - first; }
  /// The slab of 8 slices in which the block of a voxel lies.
  int slab(const glm::ivec3& voxel) const { return slice(voxel[axis]) >> 3; }
  /// Slabs of the domain.
  int slabs() const { return 1 + (slice(side > 0 ? domain.min[axis] : domain.max[axis]) >> 3); }
  /// Number of the column, not whole, at a voxel of a slice.
  glm::dvec2 column(const glm::dvec2& voxel, int slice) const {
    return (voxel - origin + double(slice) * shear) / spacing;
  }
  glm::ivec2 across(const glm::ivec3& voxel) const { return {voxel[axis_u], voxel[axis_v]}; }
};

/// A cube of cells, by its first corner.
struct CellCube {
  glm::ivec3 corner{0};
  int width = 0;  ///< cells along each axis
};

/// The cells in which an atlas may attenuate, by the slabs of a lattice in which light meets them.
/// All lights along the same axis from the same side have the same.
class DarkCells {
 public:
  DarkCells(const LatticeFrame& frame, const MediumAtlas& atlas);
  std::span<const CellCube> in(int slab) const {
    const auto found = slabs_.find(slab);
    return found == slabs_.end() ? std::span<const CellCube>() : found->second;
  }
  /// The next slab with any, from one on; else the greatest int.
  int next_slab(int slab) const {
    const auto found = slabs_.lower_bound(slab);
    return found == slabs_.end() ? std::numeric_limits<int>::max() : found->first;
  }

 private:
  std::map<int, std::vector<CellCube>> slabs_;
};

/// The lattice of one light on its way through the slabs. From slab to slab it keeps the depths at
/// which its columns have come there, whatever the volume's size. A voxel's depth is a cubic across
/// columns that are cut off at the lattice's end: where it is dark, however deep, the cubic does
/// not swing. Beside a kink it may fall below 0. Such depths are kept: up to the end the
/// interpolation is linear in the columns, so that the depths of a volume's parts add up.
class LatticeRun {
 public:
  /// Blocks must outlive it. `to_index`: they are another volume's, from whose index space it leads
  /// to the density's. Such a block may be taken once for each slab that it reaches into, with
  /// depths of 0 at voxels of other slabs, or not at all: its depths are the sums.
  LatticeRun(const LatticeFrame& frame, LightBlocks blocks, TakeDepths take,
             const glm::dmat4* to_index = nullptr);
  ~LatticeRun();
  LatticeRun(LatticeRun&&) noexcept;

  /// The next slab in which there are blocks or dark cells, from one on; -1: no more blocks come.
  int next_slab(int slab, const DarkCells& dark) const;
  /// Adds what an atlas hides in the next slab to what other parts of the volume hide there.
  void add(int slab, const DarkCells& dark, const LatticeColumns& columns);
  /// Gives the depths of the slab's blocks, and carries the columns on to the next.
  void finish(int slab);

  /// About what it keeps between slabs [bytes].
  static double bytes(const LatticeFrame& frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Optical depths from the voxels of blocks to where the light comes in, through an atlas of the
/// whole volume. `to_index`: see LatticeRun.
void lattice_depths(const LatticeFrame& frame, const MediumAtlas& atlas, LightBlocks blocks,
                    const LatticeColumns& columns, const TakeDepths& take,
                    const Progress& progress = {}, const glm::dmat4* to_index = nullptr);

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
