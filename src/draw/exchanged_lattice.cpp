#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <unordered_map>

#include "draw/part_marcher.h"
#include "field/index_space.h"
#include "march/lattice_tiles.h"

namespace psivox {
namespace {

using light_tiles::ColumnHash;
using light_tiles::SlabTiles;
using light_tiles::TileNumbers;
using light_tiles::TileRange;

/// Slabs of 8 slices that are exchanged at once.
constexpr int slabs_at_once = 4;

/// Columns of a brick, and where the depths of its last slice begin.
constexpr std::size_t brick_columns = lattice_columns * lattice_columns,
                      last_slice = lattice_depths_of_brick - brick_columns;

/// What a member wants of a tile of columns: depths in each slab from the light to the one that
/// begins with slice `last`. From the slab of slice `first` on it wants all slices, before that
/// only each slab's last one.
struct WantedTile {
  glm::ivec2 tile;
  int first, last;
};

/// The depths of a brick through a member's atlas, as they are sent: at all slices, or at the last.
struct SentBrick {
  LatticeBrick brick;
  std::array<float, lattice_depths_of_brick> depths;
};
struct SentEnds {
  LatticeBrick brick;
  std::array<float, brick_columns> depths;
};

/// What all members want.
class WantedColumns {
 public:
  WantedColumns(Team& team, const LatticeFrame& frame, const LightSlabs& slabs,
                std::span<const glm::ivec3> blocks) {
    std::unordered_map<glm::ivec2, WantedTile, ColumnHash> own;
    for (const LightSlab& slab : slabs.all())
      for (const std::uint32_t block : slab.wanted) {
        const TileRange range = light_tiles::tiles_of(frame, blocks[block], slab.first_slice);
        for (int x = range.min.x; x <= range.max.x; ++x)
          for (int y = range.min.y; y <= range.max.y; ++y) {
            const glm::ivec2 tile(x, y);
            own.try_emplace(tile, WantedTile{tile, slab.first_slice, slab.first_slice})
                .first->second.last = slab.first_slice;
          }
      }
    std::vector<WantedTile> list;
    for (const auto& [tile, want] : own) list.push_back(want);
    for (const std::vector<WantedTile>& some : team.gather(list)) {
      auto& of_member = members_.emplace_back();
      for (const WantedTile& want : some) {
        of_member.emplace(want.tile, want);
        int& last = last_.try_emplace(want.tile, want.last).first->second;
        last = std::max(last, want.last);
        end_ = std::max(end_, want.last + lattice_slices);
      }
    }
  }

  /// What a member wants of a tile in a slab; null: nothing.
  const WantedTile* of(std::size_t rank, const glm::ivec2& tile, int slab) const {
    const auto found = members_[rank].find(tile);
    return found != members_[rank].end() && found->second.last >= slab ? &found->second : nullptr;
  }
  /// The last slab in which any member wants each tile.
  const TileNumbers& last() const { return last_; }
  /// The slice behind all that is needed.
  int end() const { return end_; }

 private:
  std::vector<std::unordered_map<glm::ivec2, WantedTile, ColumnHash>> members_;
  TileNumbers last_;
  int end_ = 0;
};

/// The blocks, and those below them along the axis of slices: what lies on the lowest face of a
/// part also weighs in the step from there to the next slice, which may be of the next slab.
std::vector<glm::ivec3> with_below(const LatticeFrame& frame, std::span<const glm::ivec3> blocks) {
  std::vector<glm::ivec3> all(blocks.begin(), blocks.end());
  for (glm::ivec3 block : blocks) {
    block[frame.axis] -= 8;
    if (block[frame.axis] + 7 >= frame.domain.min[frame.axis]) all.push_back(block);
  }
  std::ranges::sort(all, comes_before);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// The columns through this member's atlas.
class OwnColumns {
 public:
  OwnColumns(const LatticeFrame& frame, const LatticeColumns& columns,
             std::span<const glm::ivec3> blocks)
      : frame_(frame),
        columns_(in_part(frame_, columns)),
        blocks_(with_below(frame, blocks)),
        slabs_(frame, {blocks_, {}}) {
    slabs_.add_octants(frame, *frame.density, 0, std::numeric_limits<int>::max());
  }

  /// Adds to the messages what the members want of the slabs before `end`.
  void send(int end, const WantedColumns& wanted, std::vector<std::vector<SentBrick>>& bricks,
            std::vector<std::vector<SentEnds>>& ends) {
    for (; next_ < slabs_.all().size() && slabs_.all()[next_].first_slice < end; ++next_) {
      const LightSlab& slab = slabs_.all()[next_];
      const std::vector<LatticeBrick> some = bricks_of(slab, wanted);
      found_.resize(some.size() * lattice_depths_of_brick);
      if (!some.empty()) columns_(some, found_);
      for (std::size_t rank = 0; rank < bricks.size(); ++rank)
        for (std::size_t i = 0; i < some.size(); ++i) {
          const double* depths = found_.data() + i * lattice_depths_of_brick;
          const WantedTile* want = wanted.of(rank, tile_of(some[i]), slab.first_slice);
          if (!want || std::all_of(depths, depths + lattice_depths_of_brick,
                                   [](double depth) { return depth == 0; }))
            continue;
          if (slab.first_slice >= want->first) {
            SentBrick& sent = bricks[rank].emplace_back(SentBrick{some[i], {}});
            std::copy_n(depths, sent.depths.size(), sent.depths.begin());
          } else {
            SentEnds& sent = ends[rank].emplace_back(SentEnds{some[i], {}});
            std::copy_n(depths + last_slice, brick_columns, sent.depths.begin());
          }
        }
    }
  }

  static glm::ivec2 tile_of(const LatticeBrick& brick) { return {brick.x >> 3, brick.y >> 3}; }

 private:
  /// The slab's bricks in which something attenuates and which a member wants.
  std::vector<LatticeBrick> bricks_of(const LightSlab& slab, const WantedColumns& wanted) const {
    const SlabTiles tiles(frame_, slab, blocks_, &wanted.last(), false);
    std::vector<LatticeBrick> bricks;
    for (std::size_t i = 0; i < tiles.tiles().size(); ++i)
      if (tiles.is_dark(i)) bricks.push_back(tiles.brick(i));
    return bricks;
  }

  const LatticeFrame& frame_;
  LatticeColumns columns_;
  std::vector<glm::ivec3> blocks_;
  LightSlabs slabs_;
  std::size_t next_ = 0;
  std::vector<double> found_;
};

/// The columns of some slabs through all members' atlases.
class JoinedColumns {
 public:
  void add(const SentBrick& sent) {
    double* to = bricks_[sent.brick].data();
    for (std::size_t i = 0; i < sent.depths.size(); ++i) to[i] += double(sent.depths[i]);
  }
  void add(const SentEnds& sent) {
    double* to = bricks_[sent.brick].data() + last_slice;
    for (std::size_t i = 0; i < brick_columns; ++i) to[i] += double(sent.depths[i]);
  }
  void operator()(std::span<const LatticeBrick> bricks, std::span<double> depths) const {
    std::ranges::fill(depths, 0.0);
    for (std::size_t i = 0; i < bricks.size(); ++i)
      if (const auto found = bricks_.find(bricks[i]); found != bricks_.end())
        std::ranges::copy(found->second,
                          depths.begin() + std::ptrdiff_t(i * lattice_depths_of_brick));
  }

 private:
  struct Hash {
    std::size_t operator()(const LatticeBrick& brick) const {
      return ColumnHash()({brick.x, brick.y}) + 31 * std::size_t(brick.z);
    }
  };
  std::unordered_map<LatticeBrick, std::array<double, lattice_depths_of_brick>, Hash> bricks_;
};

}  // namespace

void exchanged_depths(Team& team, const LatticeFrame& frame, const LatticeColumns& columns,
                      const LightBlocks& blocks, const TakeDepths& take, const Progress& progress) {
  LatticeFrame all_parts = frame;
  all_parts.part.reset();
  LightSlabs slabs(all_parts, blocks);
  const WantedColumns wanted(team, all_parts, slabs, blocks.all);
  slabs.fill(wanted.end());
  LatticeRun run(all_parts, slabs, blocks, take, /*from_light=*/true);
  OwnColumns own(frame, columns, blocks.all);
  const auto size = std::size_t(team.size());
  for (int end = 0; end < wanted.end();) {
    end += slabs_at_once * lattice_slices;
    std::vector<std::vector<SentBrick>> bricks(size);
    std::vector<std::vector<SentEnds>> ends(size);
    own.send(end, wanted, bricks, ends);
    JoinedColumns joined;
    for (const auto& some : team.exchange(bricks))
      for (const SentBrick& sent : some) joined.add(sent);
    for (const auto& some : team.exchange(ends))
      for (const SentEnds& sent : some) joined.add(sent);
    run.go_on(end, std::cref(joined));
    if (progress) progress(std::min(double(end) / wanted.end(), 1.0));
  }
}

}  // namespace psivox
