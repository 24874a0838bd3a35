#include "medium/visible_parts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <span>
#include <vector>

#include "field/field_index.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Counts voxels by their weight, four bins to a power of two.
class WeightCounts {
 public:
  template <typename Real>
  void add(Real weight, std::uint64_t voxels) {
    if (weight > 0) counts_[bin_of(weight)] += voxels;
  }
  WeightCounts& operator+=(const WeightCounts& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    return *this;
  }
  /// Lower end of the bin in which lies the weight that a share of the voxels exceeds; 0 if there
  /// are none.
  double exceeded_by(double share) const {
    std::uint64_t all = 0, above = 0;
    for (const std::uint64_t count : counts_) all += count;
    for (std::size_t i = counts_.size(); i-- > 0;) {
      above += counts_[i];
      if (above > 0 && double(above) >= share * double(all)) return begin_of(i);
    }
    return 0;
  }

 private:
  template <typename Real>
  static std::size_t bin_of(Real weight) {
    return std::bit_cast<std::uint32_t>(float(weight)) >> 21;
  }
  static double begin_of(std::size_t bin) {
    return double(std::bit_cast<float>(std::uint32_t(bin) << 21));
  }

  std::array<std::uint64_t, 1024> counts_{};  // of the positive floats, by their upper 11 bits
};

/// Cubes of 8^3 voxels that begin at the active box, wherever a tree's leaves begin: what is found
/// in them depends on the values alone. A leaf has parts of up to eight.
struct CubeLattice {
  explicit CubeLattice(const Field& field)
      : first(field.active_box.min), offset(field.active_box.min & 7) {}

  glm::ivec3 cube_of(const glm::ivec3& voxel) const { return (voxel - first) >> 3; }
  /// Number of a leaf's part, 0 to 7, that has a voxel of the leaf.
  std::size_t part_of(const glm::ivec3& place) const {
    std::size_t part = 0;
    for (int axis = 0; axis < 3; ++axis)
      part = 2 * part + (offset[axis] > 0 && place[axis] >= offset[axis]);
    return part;
  }

  glm::ivec3 first, offset;
};

/// The voxels of a part of a leaf, inside the domain, that weigh enough.
struct LeafPart {
  double amount = 0;             ///< sum of their weights
  unsigned x = 0, y = 0, z = 0;  ///< a bit for each place along the axis

  glm::ivec3 low() const { return {std::countr_zero(x), std::countr_zero(y), std::countr_zero(z)}; }
  glm::ivec3 high() const {
    return glm::ivec3(std::bit_width(x), std::bit_width(y), std::bit_width(z)) - 1;
  }
};
using LeafParts = std::array<LeafPart, 8>;

/// The parts of a leaf by their numbers. `faintest`, above 0: what weighs less does not count.
template <typename Weight>
LeafParts weigh_leaf(const Field& field, const Leaf& leaf, const Weight& weight, double faintest) {
  const int channels = field.channels;
  const Box domain = field.domain();
  const Box inside =
      common({domain.min - leaf.origin, domain.max - leaf.origin}, {glm::ivec3(0), glm::ivec3(7)});
  const CubeLattice lattice(field);
  const OrderedValues values(field, leaf);
  LeafParts parts;
  // voxels from..to of a row along z, which belong to one part
  const auto weigh_row = [&](int x, int y, int from, int to, LeafPart& part) {
    const float* const row = values.data() + (x * 8 + y) * 8 * channels;
    double amount = 0;
    unsigned places = 0;
    for (int z = from; z <= to; ++z) {
      const auto w = double(weight(row + z * channels));
      if (!(w >= faintest)) continue;
      amount += w;
      places |= 1u << z;
    }
    if (places == 0) return;
    part.amount += amount;
    part.x |= 1u << x;
    part.y |= 1u << y;
    part.z |= places;
  };
  const int cut = lattice.offset.z;
  for (int x = inside.min.x; x <= inside.max.x; ++x)
    for (int y = inside.min.y; y <= inside.max.y; ++y) {
      weigh_row(x, y, inside.min.z, std::min(inside.max.z, cut - 1),
                parts[lattice.part_of({x, y, 0})]);
      weigh_row(x, y, std::max(inside.min.z, cut), inside.max.z,
                parts[lattice.part_of({x, y, cut})]);
    }
  return parts;
}

/// The weight of a density without a transfer function.
struct ValueWeight {
  float operator()(const float* value) const { return *value; }
};

constexpr double least_weight = 1e-3;  // of the greatest: less does not count
constexpr double odd_share = 1e-3;     // of the voxels, which may be greater still

/// Attenuation of values by a transfer function, from a table: the greatest within an entry.
class FunctionTable {
 public:
  FunctionTable(const TransferFunction& function, const Field& field) {
    const glm::dvec2 range = stored_range(field);
    constexpr int entries = 4096;
    low_ = range.x;
    scale_ = range.y > range.x ? entries / (range.y - range.x) : 0;
    const auto attenuation = [&](double from, double to) {
      return function.max_attenuation(glm::dvec2(from, to), glm::dvec2(0, HUGE_VAL));
    };
    zero_ = attenuation(0, 0);
    for (int i = 0; i < entries; ++i)
      entries_.push_back(scale_ > 0 ? attenuation(low_ + i / scale_, low_ + (i + 1) / scale_)
                                    : attenuation(low_, low_));
  }
  double operator()(float value) const {
    if (value == 0) return zero_;
    if (std::isnan(value)) return 0;  // absent
    const double place = (double(value) - low_) * scale_;
    return entries_[std::size_t(std::clamp(place, 0.0, double(entries_.size() - 1)))];
  }

 private:
  double low_ = 0, scale_ = 0;
  double zero_ = 0;  ///< attenuation of 0, the value of vacuum
  std::vector<double> entries_;
};

VisibleBlock domain_block(const Field& field) {
  const Box domain = field.domain();
  return {glm::dvec3(domain.min), glm::dvec3(domain.max), 1};
}

/// Whether leaves and tiles hold all of a domain that ends with them.
bool stores_domain(const Field& field) {
  const Box domain = field.domain();
  const glm::dvec3 cells((domain.max >> 3) - (domain.min >> 3) + 1);
  double stored = double(field.leaves.size());
  for (const Tile& tile : field.tiles) stored += std::pow(tile.width / 8, 3);
  return field.margin == 0 && stored >= cells.x * cells.y * cells.z;
}

/// Blocks in the cells of a lattice, one a cell; or one a cube of cells, so wide that there are not
/// too many.
class MergedBlocks {
 public:
  explicit MergedBlocks(std::size_t leaves) : shift_(shift_for(leaves)) {}

  void add(const glm::ivec3& cell, const VisibleBlock& block) {
    blocks_.push_back({cell >> shift_, block});
    if (blocks_.size() >= full_) merge();
  }
  std::vector<VisibleBlock> take() {
    merge();
    std::vector<VisibleBlock> blocks;
    blocks.reserve(blocks_.size());
    for (const Merged& some : blocks_) blocks.push_back(some.block);
    return blocks;
  }

 private:
  struct Merged {
    glm::ivec3 cube;
    VisibleBlock block;
  };

  void merge() {
    std::ranges::stable_sort(blocks_, comes_before, &Merged::cube);
    std::size_t count = 0;
    for (const Merged& some : blocks_) {
      if (count == 0 || blocks_[count - 1].cube != some.cube) {
        blocks_[count++] = some;
        continue;
      }
      VisibleBlock& joined = blocks_[count - 1].block;
      joined.min = glm::min(joined.min, some.block.min);
      joined.max = glm::max(joined.max, some.block.max);
      joined.amount += some.block.amount;
    }
    blocks_.resize(count);
    full_ = std::max(full_, 2 * count);
  }

  static int shift_for(std::size_t leaves) {
    constexpr std::size_t most = std::size_t{1} << 17;  // with all that framing needs: 20 MB
    int shift = 0;
    for (; leaves > most; leaves /= 8) ++shift;
    return shift;
  }

  int shift_;  ///< of cells to cubes
  std::size_t full_ = std::size_t{1} << 18;
  std::vector<Merged> blocks_;
};

/// Collects the blocks of one grid. `Weight` gives what the voxel with these channels hides.
template <typename Weight>
class BlockFinder {
 public:
  BlockFinder(const Field& field, const Weight& weight)
      : field_(field), weight_(weight), lattice_(field) {}

  std::vector<VisibleBlock> find() const {
    const double greatest = counts().exceeded_by(odd_share);
    if (!(greatest > 0)) return {};
    const double faintest = least_weight * greatest;
    const float vacuum[3] = {0, 0, 0};
    if (weight_(vacuum) >= faintest && !stores_domain(field_)) return {domain_block(field_)};
    MergedBlocks merged(field_.leaves.size());
    visit_leaves(field_, [&](std::span<const Leaf> some) {
      constexpr std::size_t at_once = 2048;
      for (; !some.empty(); some = some.subspan(std::min(at_once, some.size())))
        add(some.first(std::min(at_once, some.size())), faintest, merged);
    });
    for (const Tile& tile : field_.tiles)
      if (const double weight = weight_(&tile.value.x); weight >= faintest)
        add(tile, weight, merged);
    return merged.take();
  }

 private:
  /// Of all voxels, inside the domain or not.
  WeightCounts counts() const {
    const auto stride = std::size_t(field_.channels);
    WeightCounts sum = fold_leaves(
        field_, WeightCounts(),
        [&](WeightCounts& own, const Leaf&, const OrderedValues& values) {
          for (std::size_t i = 0; i < values.size(); i += stride)
            own.add(weight_(values.data() + i), 1);
        },
        [](WeightCounts a, const WeightCounts& b) { return a += b; });
    for (const Tile& tile : field_.tiles) sum.add(weight_(&tile.value.x), tile_voxels(tile));
    return sum;
  }

  void add(std::span<const Leaf> leaves, double faintest, MergedBlocks& merged) const {
    std::vector<LeafParts> found(leaves.size());
    tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t n) {
      found[n] = weigh_leaf(field_, leaves[n], weight_, faintest);
    });
    for (std::size_t n = 0; n < leaves.size(); ++n)
      for (const LeafPart& part : found[n]) {
        if (!(part.amount > 0)) continue;
        const glm::ivec3 low = leaves[n].origin + part.low();
        merged.add(lattice_.cube_of(low), grown(low, leaves[n].origin + part.high(), part.amount));
      }
  }

  /// Grown by a voxel, inside the domain.
  VisibleBlock grown(const glm::ivec3& min, const glm::ivec3& max, double amount) const {
    const Box domain = field_.domain();
    return {glm::max(glm::dvec3(min - 1), glm::dvec3(domain.min)),
            glm::min(glm::dvec3(max + 1), glm::dvec3(domain.max)), amount};
  }

  /// The cells that the tile fills are one block, which is as visible as they are.
  void add(const Tile& tile, double weight, MergedBlocks& merged) const {
    const Box domain = field_.domain();
    const Box whole{glm::max(tile.origin, domain.min),
                    glm::min(tile.origin + (tile.width - 1), domain.max)};
    if (whole.empty()) return;
    const auto add_box = [&](const glm::ivec3& min, const glm::ivec3& max) {
      const glm::dvec3 size(max - min + 1);
      merged.add(lattice_.cube_of(min), grown(min, max, weight * size.x * size.y * size.z));
    };
    const glm::ivec3 first = lattice_.cube_of(whole.min), last = lattice_.cube_of(whole.max);
    const auto start = [&](const glm::ivec3& cell) { return lattice_.first + 8 * cell; };
    glm::ivec3 inner_first = first, inner_last = last;
    for (int axis = 0; axis < 3; ++axis) {
      inner_first[axis] += start(first)[axis] < whole.min[axis];
      inner_last[axis] -= start(last)[axis] + 7 > whole.max[axis];
    }
    const Box inner{inner_first, inner_last};
    constexpr int widest = 128;  // a wider one has millions of cells at its faces
    if (tile.width > widest && !inner.empty()) return add_box(whole.min, whole.max);
    if (!inner.empty()) add_box(start(inner.min), start(inner.max) + 7);
    for_points({first, last}, [&](const glm::ivec3& cell) {
      if (inner.empty() || !inner.contains(cell))
        add_box(glm::max(start(cell), whole.min), glm::min(start(cell) + 7, whole.max));
    });
  }

  const Field& field_;
  const Weight& weight_;
  CubeLattice lattice_;
};

/// The value around what a surface encloses: 0, or where the domain ends with its voxels that of
/// the first.
double value_outside(const Field& field) {
  if (field.margin > 0 || field.active_box.min != glm::ivec3(0)) return 0;
  return FieldIndex(field).at(glm::ivec3(0)).x;
}

template <typename Weight>
void add_grid(const Field& field, const Weight& weight, Subject& subject) {
  std::vector<VisibleBlock> blocks = BlockFinder(field, weight).find();
  if (!blocks.empty()) subject.grids.push_back({field.world_from_index, std::move(blocks)});
}

void add_density(const Medium& medium, Mode mode, Subject& subject) {
  const Field& field = *medium.density;
  if (info(mode).shows == Shows::surface) {
    const double outside = value_outside(field);
    return add_grid(
        field,
        [&](const float* value) {
          const auto is_in = [&](const Surface& surface) {
            const double isovalue = surface.isovalue;
            return isovalue < outside ? double(*value) <= isovalue : double(*value) >= isovalue;
          };
          return std::ranges::any_of(medium.surfaces, is_in) ? 1.0 : 0.0;
        },
        subject);
  }
  if (!medium.transfer) return add_grid(field, ValueWeight(), subject);
  const FunctionTable table(*medium.transfer, field);
  add_grid(
      field, [&](const float* value) { return table(*value); }, subject);
}

void add_volume(const Medium& first, const Medium& other, Mode mode, Subject& subject) {
  Subject own = subject_of(other, mode);
  for (VisibleGrid& grid : own.grids) {
    if (first.extinction > 0 && other.extinction > 0)
      for (VisibleBlock& block : grid.blocks) block.amount *= other.extinction / first.extinction;
    subject.grids.push_back(std::move(grid));
  }
  subject.box_min = glm::min(subject.box_min, own.box_min);
  subject.box_max = glm::max(subject.box_max, own.box_max);
}

}  // namespace

Subject subject_of(const Medium& medium, Mode mode) {
  Subject subject;
  if (medium.extinction > 0 || medium.emission.empty()) add_density(medium, mode, subject);
  for (const Emission& emission : medium.emission) {
    const int channels = emission.field->channels;
    add_grid(
        *emission.field,
        [channels](const float* value) {
          return double(*std::max_element(value, value + channels));
        },
        subject);
  }
  if (subject.grids.empty())
    subject.grids.push_back({medium.density->world_from_index, {domain_block(*medium.density)}});
  world_bounds(*medium.density, subject.box_min, subject.box_max);
  for (const Medium& other : medium.others) add_volume(medium, other, mode, subject);
  return subject;
}

}  // namespace psivox
