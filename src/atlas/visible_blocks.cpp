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
#include "field/block_map.h"
#include "field/index_space.h"
#include "psivox/error.h"

namespace psivox {
namespace {

using atlas::BrickSource;
using atlas::Piece;

constexpr std::size_t most_blocks = std::size_t{1} << 24;  // 32 GiB of floats

/// Distinct blocks inside a field's domain.
class BlockList {
 public:
  /// Inside a box of bricks, too, and beside its far faces.
  BlockList(const Field& field, const Box& bricks) : name_(field.name), seen_(field.leaves.size()) {
    const Box domain = field.domain();
    bounds_ = common({domain.min >> 3, domain.max >> 3}, {bricks.min, bricks.max + 1});
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
    for_points(box, [&](const glm::ivec3& block) { add(block); });
  }
  /// Adds the blocks at the corners of distinct bricks whose bits are set: their own, and those
  /// that the far faces of their cells lie in. If they are too many, none is listed.
  void add_reached(std::span<const Box> bricks, std::span<const std::uint8_t> reached) {
    std::uint64_t count = 0;
    for (std::size_t k = 0; k < bricks.size(); ++k)
      if (reached[k] & 1) check(count += count_of(common(bricks[k], bounds_)));
    for (std::size_t k = 0; k < bricks.size(); ++k) {
      const auto& [min, max] = bricks[k];
      if (reached[k] == all_corners) add_box(min, max + 1);
      for (int i = 0; i < 8 && reached[k] != all_corners; ++i)
        if (reached[k] >> i & 1) add_box(min + cube_corner(i), max + cube_corner(i));
    }
  }
  void add_domain() { add_box(bounds_.min, bounds_.max); }

  /// The blocks' first voxels, sorted.
  std::vector<glm::ivec3> origins() const {
    std::vector<glm::ivec3> result = blocks_;
    std::ranges::sort(result, comes_before);
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

  static constexpr std::uint8_t all_corners = 255;

  std::string name_;
  BlockMap seen_;
  std::vector<glm::ivec3> blocks_;
  Box bounds_;  ///< of the blocks that may be added
};

/// A bit for each corner of a cube at which something holds.
template <typename Holds>
std::uint8_t corners(const Holds& holds) {
  unsigned bits = 0;
  for (int i = 0; i < 8; ++i) bits |= unsigned(holds(i)) << i;
  return std::uint8_t(bits);
}

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
    if (std::ranges::all_of(from, &FieldIndex::Block::is_constant)) {
      all_ = atlas::value_range(from, 1);  // each layer of cells has corners in all of them
      return;
    }
    all_.reset();
    source.gather(from, values_.data());
  }
  /// The range towards a neighbour.
  ValueRange towards(int i) const {
    return all_ ? *all_ : range_towards(values_.data(), cube_corner(i));
  }

 private:
  std::optional<ValueRange> all_ = ValueRange{};  ///< of equal blocks: towards each
  std::array<float, brick_texels> values_;
};

}  // namespace

std::vector<glm::ivec3> visible_blocks(const Field& field, const AtlasOptions& options) {
  BrickSource::check_width(field);
  BlockList blocks(field, options.region);
  if (options.sees({})) {
    blocks.add_domain();
    return blocks.origins();
  }
  const BrickSource source(field);
  std::optional<BrickSource> companion;
  if (options.companion) companion.emplace(*options.companion);
  std::vector<Box> pieces;
  for (const Piece& piece : source.candidates())
    if (const Box bricks = piece.bricks(options.region); !bricks.empty()) pieces.push_back(bricks);
  std::vector<std::uint8_t> reached(pieces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size(), 16), [&](const auto& some) {
    BrickRanges ranges, others;
    for (std::size_t k = some.begin(); k != some.end(); ++k) {
      ranges.find(source, pieces[k].min);
      if (companion) others.find(*companion, pieces[k].min);
      reached[k] =
          corners([&](int i) { return options.sees(ranges.towards(i), others.towards(i)); });
    }
  });
  blocks.add_reached(pieces, reached);
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
  if (!atlas.own_texels || !atlas.texels || options.companion) return {};
  std::vector<std::uint8_t> reached(atlas.places.size());
  tbb::parallel_for(std::size_t{0}, reached.size(), [&](std::size_t k) {
    const float* values = atlas.texels.get() + k * brick_texels;
    reached[k] =
        corners([&](int i) { return options.sees(range_towards(values, cube_corner(i))); });
  });
  BlockList blocks(field, everywhere);
  std::vector<Box> bricks;
  for (const glm::ivec3& place : atlas.places) bricks.push_back({place, place});
  blocks.add_reached(bricks, reached);
  return blocks.origins();
}

}  // namespace psivox
