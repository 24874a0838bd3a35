#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/value_scale.h"

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
  /// see field/leaf_values.h.
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

/// Values that stand for "no data": NaN, -Inf, and fill values, which lie at the ends of a grid's
/// values and apart from all others.
struct Fill {
  float low = -std::numeric_limits<float>::infinity();  ///< so much, or less, is fill
  float high = std::numeric_limits<float>::infinity();  ///< so much, or more, but not +Inf
  std::optional<float> given{};                         ///< what a user calls fill
  bool is_fill(float value) const {
    return !(value > low) || (value >= high && value <= std::numeric_limits<float>::max()) ||
           value == given;
  }
  bool operator==(const Fill&) const = default;
};

/// Numbers of absent and of replaced values. A tile counts as one voxel; each component of a vector
/// counts.
struct BadValues {
  std::uint64_t nan = 0;
  std::uint64_t positive_infinite = 0;
  std::uint64_t negative_infinite = 0;
  std::uint64_t negative = 0;
  std::uint64_t filled = 0;   ///< fill values
  std::uint64_t clamped = 0;  ///< of a magnitude above greatest_magnitude
  float largest = 1.0f;       ///< what +Inf became
  float least = 0.0f;         ///< of the negative values
  float least_fill = std::numeric_limits<float>::infinity();  ///< least of the fill values
  Fill fill{};
  bool absent = false;  ///< NaN, -Inf and fill values became absent; else 0

  std::uint64_t missing() const { return nan + negative_infinite + filled; }
  bool any() const { return missing() + positive_infinite + negative + clamped > 0; }

  /// `12 NaN, 3 negative values taken as 0`; it mentions +Inf only if there was one.
  std::string describe() const;
};

/// Larger values are clamped, so that no sum, difference or range of a few of them overflows.
inline constexpr float greatest_magnitude = 1e36f;

BadValues operator+(BadValues a, const BadValues& b);

/// What lies at the ends of a grid's values, by which fill values are known.
struct ValueEnds {
  float least = std::numeric_limits<float>::infinity();
  std::uint64_t count = 0;                                   ///< of the least value
  float next = std::numeric_limits<float>::infinity();       ///< the least of the others
  float third = std::numeric_limits<float>::infinity();      ///< the least of these others
  float greatest = -std::numeric_limits<float>::infinity();  ///< below `huge`
  float magnitude = 0;                                       ///< the greatest below `huge`
  /// Magnitudes from `huge` on: the least and the greatest.
  float huge_least = std::numeric_limits<float>::infinity(), huge_greatest = 0;

  static constexpr float huge = 1e15f;

  void add(float value, std::uint64_t voxels = 1);
  ValueEnds operator+(const ValueEnds& other) const;
  /// The fill values of a grid of so many voxels.
  Fill fill(std::uint64_t voxels) const;
};

/// Keeps the values of leaves alive. Those of a large grid are in blocks, which may go one by one.
struct Storage {
  std::vector<std::shared_ptr<const void>> blocks{};
  /// Leaves of each block, in the field's order; the last may have fewer. 0: in no order.
  std::size_t leaves = 0;

  Storage() = default;
  template <typename T>
  Storage(std::shared_ptr<T> all) : blocks{std::move(all)} {}
  Storage(std::vector<std::shared_ptr<const void>> in_order, std::size_t leaves_each)
      : blocks(std::move(in_order)), leaves(leaves_each) {}
  explicit operator bool() const { return !blocks.empty(); }
  bool operator==(const Storage&) const = default;
  /// Lets the blocks go that have only leaves before this one.
  void drop_before(std::size_t leaf) {
    for (std::size_t n = 0; leaves > 0 && (n + 1) * leaves <= leaf && n < blocks.size(); ++n)
      blocks[n].reset();
  }
};

/// What a field is, without its values.
struct FieldHead {
  std::string name;         ///< selectable name, `density` or `density[1]`
  std::string value_type;   ///< GridInfo's: float, ..., points, vec3i
  int channels = 1;         ///< 1 or 3
  bool of_vectors = false;  ///< a component of a vector grid, or its length
  Box active_box;           ///< of active voxels and tiles
  int margin = 1;           ///< voxels from it to the domain's end: 1, or 0 of an array_box
  /// Some voxels are absent: their value is NaN. A cell with an absent corner is vacuum.
  bool absent = false;
  std::optional<Box> array_box;  ///< of a DenseField beside which the values are unknown
  glm::dmat4 world_from_index{1.0};
  std::uint64_t active_voxels = 0;
  std::optional<glm::vec2> active_range;  ///< of active values, first channel; unset: not known
  std::optional<glm::vec2> stored_range;  ///< of all values and 0, first channel; unset: not known
  /// Percentiles of the active values that reading was asked for, by their percentage.
  std::map<double, double> active_percentiles;
  /// If above 0, the field is a level set kept as distances. The value is half_width - signed
  /// distance [world units]: 0 outside the narrow band, twice the half width deep inside.
  double half_width = 0;
  ValueScale scale;                  ///< that its values have passed, its unit set
  BadValues replaced;                ///< what reading has replaced; a notice tells of it
  std::vector<std::string> notices;  ///< one line each, for stderr: what reading changed

  /// Smallest and largest voxel of the domain.
  Box domain() const { return {active_box.min - margin, active_box.max + margin}; }
};

/// Reads leaves of a field whose values stay in a file, by their numbers in Field::leaves: 512 *
/// channels floats each, one leaf after another. Several threads may call it. Throws Error(input).
using ReadLeaves = std::function<void(const FieldHead& field, std::span<const std::uint32_t> leaves,
                                      float* values)>;

/// One grid of a .vdb file, independent of OpenVDB. Every later stage reads it.
///
/// Its value at a world point is the trilinear interpolation, in index space, of the values at
/// integer coordinates. Where there is neither a leaf nor a tile, the value is 0. The domain is the
/// active box, mostly grown by one voxel on every side; outside it is vacuum.
struct Field : FieldHead {
  std::vector<Leaf> leaves{};          ///< in OpenVDB's tree order; origins distinct
  std::vector<Tile> tiles{};           ///< disjoint from each other and from the leaves
  std::optional<ArrayValues> array{};  ///< of the leaves without values of their own
  Storage storage{};                   ///< keeps Leaf::values and the array alive
  /// Set if the values of leaves stay in the file, see field/leaf_values.h.
  ReadLeaves reader{};
};

struct LeafValues;

/// Makes a field of a dense array, which it copies a slab at a time or reads in place. Voxel
/// (0, 0, 0) is the array's first. Blocks of 8^3 voxels that are 0 take no memory, those of another
/// single value are tiles. Where scalars are below 0, as air in Hounsfield units, or most of the
/// outermost ones are not 0, what lies beside the array is not 0 but unknown: read as data by a
/// VolumeFile, its domain is the whole array, and no more.
class DenseField {
 public:
  /// `channels`: 1 or 3. Throws Error(input) if the shape or the transform is refused.
  DenseField(const std::string& name, const glm::ivec3& shape, int channels,
             const glm::dmat4& world_from_index);

  /// Takes the next 8 planes of x, or what is left of them; z is fastest and channels are
  /// interleaved. It copies the values. Throws Error(memory); Error(input) for another number.
  void add(std::span<const float> slab);

  /// The same for slabs of any strides: the next 8 planes of an axis, which is the same for all
  /// slabs. The slab's first value is that of its smallest voxel.
  void add(const ArrayValues& slab, int axis) { add(slab, axis, false); }

  /// Takes the whole array, in place of slabs, and reads it where it lies. The field and its copies
  /// keep `owner`; until then the values must stay as they are. Only blocks that reach beyond the
  /// array are copied.
  void hold(const ArrayValues& array, std::shared_ptr<const void> owner);

  /// The field, after all values. NaN, Inf and negative values are in it as they were given; a
  /// VolumeFile replaces them as those of a file. Throws Error(input) if planes are missing.
  Field finish();

 private:
  struct Block;
  Block summarise(const LeafValues& values, const glm::ivec3& origin) const;
  void copy(const LeafValues& values, const glm::ivec3& origin, float* leaf) const;
  glm::ivec3 size_of_block(const glm::ivec3& origin) const;
  /// Adds the next planes of an axis, whose first voxel is the array's first.
  void add(const ArrayValues& slab, int axis, bool in_place);
  /// Throws Error(input): slabs along that axis do not fit.
  [[noreturn]] void refuse_planes(int axis) const;

  glm::ivec3 shape_;
  int axis_ = 0;  ///< of the slabs
  int next_plane_ = 0;
  bool below_0_ = false;        ///< a value so far
  std::uint64_t on_faces_ = 0;  ///< active voxels so far on the array's faces
  Field field_;
  std::vector<std::shared_ptr<const void>> storage_;
};

/// Writes the values of a box of voxels, z fastest, with the field's channels; 0 where none is
/// stored.
void write_dense(const Field& field, const Box& box, float* out);

/// Bytes and counts of an atlas; exact, and known before a texel is allocated.
struct AtlasSize {
  std::uint64_t textured_bricks = 0;
  std::uint64_t constant_bricks = 0;  ///< entries; one may span many bricks
  std::uint64_t page_bytes = 0;
  std::uint64_t constant_bytes = 0;
  std::uint64_t texel_bytes = 0;
  /// Bytes of one copy, on the host or on the GPU.
  std::uint64_t bytes() const { return page_bytes + constant_bytes + texel_bytes; }
};

}  // namespace psivox
