#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/value_survey.h"

namespace psivox {

/// A box of voxels, both ends inclusive, in index space. Empty when max < min.
struct Box {
  glm::ivec3 min{0};
  glm::ivec3 max{-1};
  bool empty() const { return max.x < min.x || max.y < min.y || max.z < min.z; }
  bool contains(const glm::ivec3& voxel) const { return voxel == glm::clamp(voxel, min, max); }
  bool operator==(const Box&) const = default;
};

/// 8x8x8 voxels in OpenVDB's order: value (x,y,z) of channel c at ((x*8+y)*8+z)*channels + c.
struct Leaf {
  glm::ivec3 origin;  ///< smallest voxel, a multiple of 8
  /// 512 * channels floats, owned by Field::storage. Null if they lie in Field::array or in a file;
  /// see leaf_values.h.
  const float* values;
};

/// Distances in memory between neighbouring values [floats].
struct Strides {
  std::ptrdiff_t x, y, z, channel;
};

/// A dense array of floats in any order, to be read in place.
struct ArrayValues {
  const float* first;  ///< of voxel (0, 0, 0), owned by Field::storage
  Strides strides;
};

/// A cube of voxels of one value (an OpenVDB tile whose value is not 0).
struct Tile {
  glm::ivec3 origin;  ///< smallest voxel, a multiple of width
  int width;          ///< 8, 128 or 4096 voxels
  glm::vec3 value;    ///< first `channels` components
};

/// Active voxels of one value, outside leaves.
struct TileValue {
  float value = 0;
  std::uint64_t voxels = 0;
};

/// Leaves whose values stay in a file.
class LeafReader {
 public:
  virtual ~LeafReader() = default;
  /// Reads leaves, by their numbers in Field::leaves: 512 * channels floats each, one leaf after
  /// another. Several threads may call it. Throws Error(input).
  virtual void read(std::span<const std::uint32_t> leaves, float* values) const = 0;
  /// Reads them and returns what it has found, for a field that has Field::survey.
  virtual ValueSurvey survey(std::span<const std::uint32_t> leaves, float* values) const = 0;
  /// As `read`, with NaN in the first channel of voxels that are not active.
  virtual void read_active(std::span<const std::uint32_t> leaves, float* values) const = 0;
  /// Active tiles, those of 0 too.
  virtual const std::vector<TileValue>& active_tiles() const = 0;
};

struct Field;

/// Where a field's values were read.
struct FieldOrigin {
  std::weak_ptr<const void> storage;  ///< that holds these values
  std::function<Field()> read_again;  ///< throws Error(input), Error(memory)
};

/// One grid of a .vdb file, independent of OpenVDB. Every later stage reads it.
///
/// Its value at a world point is the trilinear interpolation, in index space, of the values at
/// integer coordinates. Where there is neither a leaf nor a tile, the value is 0. The domain is the
/// active box grown by one voxel on every side; outside it is vacuum.
struct Field {
  std::string name;         ///< selectable name, `density` or `density[1]`
  std::string value_type;   ///< GridInfo's: float, ..., points, vec3i
  int channels = 1;         ///< 1 or 3
  bool of_vectors = false;  ///< a component of a vector grid, or its length
  Box active_box;           ///< of active voxels and tiles
  glm::dmat4 world_from_index{1.0};
  std::uint64_t active_voxels = 0;
  std::optional<glm::vec2> active_range;  ///< of active values, first channel; unset: not known
  std::optional<glm::vec2> stored_range;  ///< of all values and 0, first channel; unset: not known
  /// Percentiles of the active values that reading was asked for, by their percentage.
  std::map<double, double> active_percentiles;
  /// If above 0, the field is a level set kept as distances. The value is half_width - signed
  /// distance [world units]: 0 outside the narrow band, twice the half width deep inside.
  double half_width = 0;
  std::vector<Leaf> leaves;             ///< in OpenVDB's tree order; origins distinct
  std::vector<Tile> tiles;              ///< disjoint from each other and from the leaves
  std::optional<ArrayValues> array;     ///< of the leaves without values of their own
  std::shared_ptr<const void> storage;  ///< keeps Leaf::values and the array alive
  /// Null: not in a file. A copy that got other values keeps it: see may_discard.
  std::shared_ptr<const FieldOrigin> origin;
  /// Set if the values of leaves stay in the file, see leaf_values.h. Both ranges are known then,
  /// unless `survey` is set.
  std::shared_ptr<const LeafReader> reader;
  std::optional<ValueSurvey> survey;  ///< of tiles, if the caller is to survey the leaves
  BadValues replaced;                 ///< what reading has replaced; a notice tells of it
  std::vector<std::string> notices;   ///< one line each, for stderr: what reading changed

  /// Smallest and largest voxel of the domain: active_box grown by one.
  Box domain() const { return {active_box.min - glm::ivec3(1), active_box.max + glm::ivec3(1)}; }
};

}  // namespace psivox
