#include "medium/fill_domain.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <unordered_set>

#include "field/field_index.h"
#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

constexpr std::size_t most_tiles = std::size_t{1} << 22;  // 128 MiB of them

void check_count(const Field& field, std::size_t tiles) {
  if (tiles > most_tiles)
    throw Error(ExitCode::memory,
                "grid " + in_quotes(field.name) +
                    ": the function gives 0 a meaning, and the domain is too large to be filled "
                    "with it; take --classification post, or a function that is 0 at 0");
}

class Filler {
 public:
  explicit Filler(const Field& field) : field_(field), index_(field), domain_(field.domain()) {}

  /// Fills the cubes of one width that lie in [min, max].
  void fill(int level, const glm::ivec3& min, const glm::ivec3& max) {
    const int width = FieldIndex::widths[static_cast<std::size_t>(level)];
    const glm::ivec3 first = min & ~(width - 1);
    for (int x = first.x; x <= max.x; x += width)
      for (int y = first.y; y <= max.y; y += width)
        for (int z = first.z; z <= max.z; z += width) fill_cube(level, width, {x, y, z});
  }

  std::vector<Tile> tiles;

 private:
  void fill_cube(int level, int width, const glm::ivec3& origin) {
    if (index_.is_one(level, origin)) return;
    // Cubes of the greatest width that reach beyond a small domain lie mostly outside it, and an
    // atlas visits all of a tile's surface. So they are split.
    const glm::ivec3 last = origin + (width - 1);
    const bool sticks_out = level == 0 && (glm::any(glm::lessThan(origin, domain_.min)) ||
                                           glm::any(glm::greaterThan(last, domain_.max)));
    if (sticks_out || index_.holds_any(level, origin)) {
      fill(level + 1, glm::max(origin, domain_.min), glm::min(origin + (width - 1), domain_.max));
      return;
    }
    tiles.push_back({origin, width, glm::vec3(0)});
    check_count(field_, tiles.size());
  }

  const Field& field_;
  FieldIndex index_;
  Box domain_;
};

}  // namespace

void fill_domain(Field& field) {
  Filler filler(field);
  const Box domain = field.domain();
  filler.fill(0, domain.min, domain.max);
  field.tiles.insert(field.tiles.end(), filler.tiles.begin(), filler.tiles.end());
}

void fill_surroundings(Field& field) {
  const FieldIndex index(field);
  std::unordered_set<glm::ivec3, VoxelHash> blocks;
  // Adds the shell of blocks around a cube.
  const auto surround = [&](const glm::ivec3& origin, int width) {
    for (int x = -8; x <= width; x += 8)
      for (int y = -8; y <= width; y += 8) {
        const bool side = x == -8 || x == width || y == -8 || y == width;
        for (int z = -8; z <= width; z += side ? 8 : width + 8) {
          const glm::ivec3 block = origin + glm::ivec3(x, y, z);
          if (!index.stores(block)) blocks.insert(block);
        }
      }
    check_count(field, blocks.size());
  };
  for (const Leaf& leaf : field.leaves) surround(leaf.origin, 8);
  for (const Tile& tile : field.tiles) surround(tile.origin, tile.width);
  for (const glm::ivec3& block : blocks) field.tiles.push_back({block, 8, glm::vec3(0)});
}

}  // namespace psivox
