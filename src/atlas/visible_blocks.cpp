#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <optional>
#include <span>
#include <string>

#include "atlas/brick_source.h"
#include "psivox/atlas.h"
#include "psivox/error.h"

namespace psivox {
namespace {

using atlas::BlockMap;
using atlas::BrickSource;

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
    first_ = domain.min >> 3;
    last_ = domain.max >> 3;
    if (!region) return;
    first_ = glm::max(first_, region->min);
    last_ = glm::min(last_, region->max + 1);
  }

  void add(const glm::ivec3& block) {
    if (block != glm::clamp(block, first_, last_)) return;
    const auto next = std::int32_t(blocks_.size());
    if (seen_.insert(block, next) != next) return;
    blocks_.push_back(block);
    if (blocks_.size() > most_blocks)
      throw Error(ExitCode::memory, "grid '" + name_ + "' has something in more than " +
                                        std::to_string(most_blocks) +
                                        " blocks of 8^3 voxels, too many to light");
  }

  void add_box(const glm::ivec3& min, const glm::ivec3& max) {
    const glm::ivec3 lo = glm::max(min, first_), hi = glm::min(max, last_);
    for (int x = lo.x; x <= hi.x; ++x)
      for (int y = lo.y; y <= hi.y; ++y)
        for (int z = lo.z; z <= hi.z; ++z) add({x, y, z});
  }
  /// Of each brick those neighbours whose bits are set.
  void add_reached(std::span<const glm::ivec3> bricks, std::span<const std::uint8_t> reached) {
    for (std::size_t k = 0; k < bricks.size(); ++k)
      for (int i = 0; i < 8; ++i)
        if (reached[k] >> i & 1) add(bricks[k] + neighbour(i));
  }
  void add_domain() { add_box(first_, last_); }

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
  std::string name_;
  BlockMap seen_;
  std::vector<glm::ivec3> blocks_;
  glm::ivec3 first_, last_;
};

/// Least and greatest corner value of those cells of a brick that reach into the block at `offset`
/// (0 or 1 per axis): all cells, or the last layer.
ValueRange range_towards(const float* values, const glm::ivec3& offset) {
  ValueRange range{HUGE_VALF, -HUGE_VALF};
  const glm::ivec3 from = 7 * offset;
  for (int x = from.x; x < brick_values; ++x)
    for (int y = from.y; y < brick_values; ++y)
      for (int z = from.z; z < brick_values; ++z) {
        const float value = values[(x * brick_values + y) * brick_values + z];
        range = {std::min(range.min, value), std::max(range.max, value)};
      }
  return range;
}

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
  std::vector<glm::ivec3> bricks = source.candidates();
  if (const std::optional<Box>& region = options.region)
    std::erase_if(bricks, [&](const glm::ivec3& brick) {
      return brick != glm::clamp(brick, region->min, region->max);
    });
  std::vector<std::uint8_t> reached(bricks.size());  // a bit for each of 8 neighbours
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bricks.size(), 16), [&](const auto& some) {
    std::array<float, brick_texels> values;
    std::array<float, brick_texels> others{};
    for (std::size_t k = some.begin(); k != some.end(); ++k) {
      source.gather(source.neighbours(bricks[k]), values.data());
      if (companion) companion->gather(companion->neighbours(bricks[k]), others.data());
      for (int i = 0; i < 8; ++i) {
        const glm::ivec3 offset = neighbour(i);
        if (visible(range_towards(values.data(), offset), range_towards(others.data(), offset)))
          reached[k] = std::uint8_t(reached[k] | 1 << i);
      }
    }
  });
  blocks.add_reached(bricks, reached);
  for (const BrickSource::ConstantBox& box : source.wide_tiles())
    if (visible({box.value.x, box.value.x}, {})) blocks.add_box(box.min, box.max + 1);
  return blocks.origins();
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
  blocks.add_reached(atlas.places, reached);
  return blocks.origins();
}

}  // namespace psivox
