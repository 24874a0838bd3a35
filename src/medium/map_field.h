#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <string>

#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/team.h"
#include "psivox/vdb.h"
#include "scene/transfer_function.h"

namespace psivox {

/// Colours with those of active voxels also at the voxels beside these, as means, so that they do
/// not darken towards the outside. `active` is above 0 at active voxels, on the same lattice.
Field spread_colors(const Field& colors, const Field& active);

/// Maps a stored value; called from several threads.
using VoxelMap = std::function<glm::vec3(const glm::vec3& value)>;

/// The field with every stored value mapped, to `channels` components; values that are not stored
/// stay 0. A scalar is in the first component, before and after.
Field map_field(const Field& field, int channels, const VoxelMap& map);

/// The scalar field with its values passed through a scale, if they are not yet. An unset unit is,
/// of log, the least value above 0; of symlog, a thousandth of the greatest magnitude. Values that
/// stay in the file are scaled as they are read; the first of a team finds the unit. Throws
/// Error(input) if there is none, Error(usage) for distances.
std::shared_ptr<const Field> scaled_values(std::shared_ptr<const Field> field,
                                           const ValueScale& wanted, Team& team = *alone());

/// Magnitude of the gradient of a scalar field at its voxels [value/world unit], as a field of the
/// same domain and transform: central differences over the two neighbours along each index axis,
/// turned into the world's by the inverse transpose of the transform. For smooth data the error is
/// a sixth of the third derivatives. A leaf is stored only if some voxel's gradient is not 0.
/// Throws Error(memory) beyond 2^24 of them.
Field gradient_of_voxels(const Field& field);

/// A field with the given gradients, in which every place with a gradient is stored in blocks of
/// 8^3 voxels. Tiles are split until each lies in one block or has no gradient. If `with_zeros`,
/// blocks that have a gradient but store nothing become tiles of 0. Tiles outside the domain are
/// left out.
/// Throws Error(memory) beyond 2^24 tiles.
Field told_by_blocks(const Field& field, const Field& gradient, bool with_zeros);

/// What a coarse voxel has of the eight in its place: their mean, or one of them, so that all
/// values stay as frequent as they are.
enum class CoarseValue { mean, sample };

/// The field with voxels twice as wide, so many times: each has a value of the eight in its place.
/// With means a linear field stays the same. Ranges and percentiles stay the same, too. The result
/// is in memory; if the field's values stay in its file, they are read a few at a time.
/// `centering`: by which values will be placed, after this.
Field coarse_field(const Field& field, int times, Centering centering, CoarseValue value = {});

/// Classification before interpolation: the attenuation of each voxel's value as a scalar field. If
/// 0 has an attenuation, it fills the whole domain. Throws Error(memory).
Field attenuation_of_voxels(const Field& field, const TransferFunction& function);

/// The attenuation of each voxel's value and gradient as a scalar field. `gradient`:
/// gradient_of_voxels(field).
Field attenuation_of_voxels(const Field& field, const Field& gradient,
                            const TransferFunction& function);

/// The colour of each voxel's value as a vec3 field, wherever there is attenuation.
Field color_of_voxels(const Field& field, const TransferFunction& function);

/// A scalar of a grid: x, y, z or length of vectors, or where any grid is active.
struct VectorPart {
  std::string grid;
  std::string part;  ///< `x`, `y`, `z`, `length` or `active`; empty: the grid is scalar
  bool active() const { return part == "active"; }
  bool of_vectors() const { return !part.empty() && !active(); }
};

/// The meaning of --grid: `velocity:x`, `velocity:active`, or a grid's name. The length if the grid
/// has vectors and no part is named. Throws Error(input) if x, y, z or length of a scalar grid is
/// named.
VectorPart vector_part(const VolumeFile& file, const std::string& name);

/// The scalar field, called `velocity:x`.
Field part_of_vectors(const Field& vectors, const VectorPart& part);

}  // namespace psivox
