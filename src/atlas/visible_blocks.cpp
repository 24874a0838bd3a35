#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "atlas/atlas.h"
#include "atlas/brick_source.h"
#include "field/index_space.h"
#include "psivox/error.h"

namespace psivox {
namespace {

using atlas::BlockMap;
using atlas::BrickSource;
using atlas::Piece;

constexpr std::size_t most_blocks = std::size_t{1} << 24;  // 32 GiB of floats

/// A brick's blocks of voxels: its own, and the seven that the far faces of its cells lie in.
glm::ivec3 neighbour(int i) { return {i >> 2, i >> 1 & 1, i & 1}; }

/// Distinct blocks inside a field's domain.
class BlockList {
 public:
  /// Inside a box of bricks, too, and beside its far faces, if there is one.
  BlockList(const Field& field, const std::optional<Box>& region)
      : name_(field.name), seen_(field.leaves.size()) {
    const Box domain = field.domain();
    bounds_ = {domain.min >> 3, domain.max >> 3};
    if (region) bounds_ = common(bounds_, {region->min, region->max + 1});
  }

  void add(const glm::ivec3& block) {
    if (!bounds_.contains(block)) return;
    const auto next = std::int32_t(blocks_.size());
    if (seen_.insert(block, next) != next) return;
    blocks_.push_back(block);
    check(blocks_.size());
  }

  void add_box(const glm::ivec3& min, const glm::ivec3& max) {
    const Box box = common({min, max}, bounds_);
    check(count_of(box));
    for (int x = box.min.x; x <= box.max.x; ++x)
      for (int y = box.min.y; y <= box.max.y; ++y)
        for (int z = box.min.z; z <= box.max.z; ++z) add({x, y, z});
  }
  /// Boxes that share no block. If they are too many, none is listed.
  void add_disjoint(std::span<const Box> boxes) {
    std::uint64_t count = 0;
    for (const Box& box : boxes) check(count += count_of(common(box, bounds_)));
    for (const Box& box : boxes) add_box(box.min, box.max);
  }
  /// Adds the neighbours of a box's bricks whose bits are set.
  void add_reached(const Box& bricks, std::uint8_t reached) {
    for (int i = 0; i < 8; ++i)
      if (reached >> i & 1) add_box(bricks.min + neighbour(i), bricks.max + neighbour(i));
  }
  void add_domain() { add_box(bounds_.min, bounds_.max); }

  /// The blocks' first voxels, sorted.
  std::vector<glm::ivec3> origins() const {
    std::vector<glm::ivec3> result = blocks_;
    std::sort(result.begin(), result.end(), [](const glm::ivec3& a, const glm::ivec3& b) {
      return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
    });
    for (glm::ivec3& block : result) block *= brick_cells;
    return result;
  }

 private:
  void check(std::uint64_t count) const {
    if (count > most_blocks)
      throw Error(ExitCode::memory,
                  "grid '" + name_ + "' has something in more than " + std::to_string(most_blocks) +
                      " blocks of 8^3 voxels, too many to light; leave light out, or"
                      " take a --lod");
  }

  std::string name_;
  BlockMap seen_;
  std::vector<glm::ivec3> blocks_;
  Box bounds_;  ///< of the blocks that may be added
};

/// Least and greatest corner value of those cells of a brick that reach into the block at `offset`
/// (0 or 1 per axis): all cells, or the last layer.
ValueRange range_towards(const float* values, const glm::ivec3& offset) {
  return atlas::range_in_brick(values, 7 * offset, glm::ivec3(brick_values - 1));
}

/// Ranges of the corner values of a brick in a field, towards its neighbours.
class BrickRanges {
 public:
  void find(const BrickSource& source, const glm::ivec3& brick) {
    const BrickSource::Neighbours from = source.neighbours(brick);
    if (from.are_constant()) {  // each layer of cells has corners in all of them
      all_ = {HUGE_VALF, -HUGE_VALF};
      for (const atlas::Block& block : from.blocks)
        all_ = {std::min(all_->min, block.constant.x), std::max(all_->max, block.constant.x)};
      return;
    }
    all_.reset();
    source.gather(from, values_.data());
  }
  /// The range towards a neighbour.
  ValueRange towards(int i) const {
    return all_ ? *all_ : range_towards(values_.data(), neighbour(i));
  }

 private:
  std::optional<ValueRange> all_ = ValueRange{};  ///< of equal blocks: towards each
  std::array<float, brick_texels> values_;
};

}  // namespace

std::vector<glm::ivec3> visible_blocks(const Field& field, const AtlasOptions& options) {
  BrickSource::check_width(field);
  const auto visible = [&](const ValueRange& own, const ValueRange& companions) {
    return options.visible ? options.visible(own, companions) : own.min != 0 || own.max != 0;
  };
  BlockList blocks(field, options.region);
  if (visible({}, {})) {
    blocks.add_domain();
    return blocks.origins();
  }
  const BrickSource source(field);
  std::optional<BrickSource> companion;
  if (options.companion) companion.emplace(*options.companion);
  const Box region = options.region.value_or(everywhere);
  std::vector<Piece> pieces = source.candidates();
  std::erase_if(pieces, [&](const Piece& piece) { return piece.bricks(region).empty(); });
  std::vector<std::uint8_t> reached(pieces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size(), 16), [&](const auto& some) {
    BrickRanges ranges, others;
    for (std::size_t k = some.begin(); k != some.end(); ++k) {
      ranges.find(source, pieces[k].first);
      if (companion) others.find(*companion, pieces[k].first);
      for (int i = 0; i < 8; ++i)
        if (visible(ranges.towards(i), others.towards(i)))
          reached[k] = std::uint8_t(reached[k] | 1 << i);
    }
  });
  std::vector<Box> tiles;
  for (const BrickSource::ConstantBox& box : source.wide_tiles())
    if (visible({box.value.x, box.value.x}, {})) tiles.push_back({box.min, box.max + 1});
  blocks.add_disjoint(tiles);
  for (std::size_t k = 0; k < pieces.size(); ++k)
    blocks.add_reached(pieces[k].bricks(region), reached[k]);
  return blocks.origins();
}

double most_visible_blocks(const Field& field) {
  double most = 8 * double(field.leaves.size());
  for (const Tile& tile : field.tiles) most += std::pow(tile.width / brick_cells + 2, 3);
  return most;
}

std::optional<std::vector<glm::ivec3>> visible_blocks(const Field& field,
                                                      const AtlasOptions& options,
                                                      const BrickAtlas& atlas) {
  if (!atlas.own_texels || !atlas.texels32 || options.companion) return {};
  std::vector<std::uint8_t> reached(atlas.places.size());
  tbb::parallel_for(std::size_t{0}, reached.size(), [&](std::size_t k) {
    const float* values = atlas.texels32.get() + k * brick_texels;
    for (int i = 0; i < 8; ++i) {
      const ValueRange range = range_towards(values, neighbour(i));
      if (options.visible ? options.visible(range, {}) : range.min != 0 || range.max != 0)
        reached[k] = std::uint8_t(reached[k] | 1 << i);
    }
  });
  BlockList blocks(field, {});
  for (std::size_t k = 0; k < reached.size(); ++k)
    blocks.add_reached({atlas.places[k], atlas.places[k]}, reached[k]);
  return blocks.origins();
}

}  // namespace psivox
