#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>

#include "march/lattice_tiles.h"

namespace psivox {
namespace light_tiles {

constexpr std::size_t nowhere = ~std::size_t{0};
using Slice = std::array<double, lattice_depths_of_slice>;

/// A tile on its way through the slabs.
struct TileRun {
  glm::ivec2 number{0};
  int last = -1;                    ///< the last slab that needs it
  int mark = -1;                    ///< the turn in which it was found to be dark
  std::size_t place = nowhere;      ///< of its depths among those found in the slab
  std::unique_ptr<Slice> before{};  ///< depths before the slab; null: 0
  bool ended = false;               ///< all columns have, and are followed no further
};

struct NumberHash {
  std::size_t operator()(const glm::ivec2& v) const {
    const std::uint64_t key =
        std::uint64_t(std::uint32_t(v.x)) << 32 | std::uint64_t(std::uint32_t(v.y));
    return std::size_t((key * 0x9E3779B97F4A7C15ull) >> 17);
  }
};

/// What a run keeps.
struct Columns {
  Columns(const LatticeFrame& of, LightBlocks all, TakeDepths taken, const glm::dmat4* to_index)
      : frame(of), blocks(all), take(std::move(taken)), range(tiles_of(frame)) {
    if (to_index) placed.emplace(frame, *to_index);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const auto [from, to] = slabs_of(blocks[i]);
      for (int slab = from; slab <= to; ++slab) slabs[slab].wanted.push_back(i);
      tiles(blocks[i]).each([&, last = to](const glm::ivec2& number) {
        TileRun& run = runs[number];
        run.number = number;
        run.last = std::max(run.last, last);
      });
    }
    for (auto& [number, run] : runs)
      if (run.last >= 0) slabs[run.last].ending.push_back(&run);
  }

  /// The first and the last slab that a block reaches into.
  std::array<int, 2> slabs_of(const glm::ivec3& block) const {
    if (!placed) return {frame.slab(block), frame.slab(block)};
    const auto [low, high] = placed->of_block(block);
    const auto slab = [&](double slice) {
      return int(std::clamp(std::ceil((slice + 1) / 8) - 1, -1.0, double(frame.slabs() - 1)));
    };
    return {std::max(slab(low.z), 0), slab(high.z)};
  }

  TileRange tiles(const glm::ivec3& block) const {
    return common(placed ? placed->tiles_of(block) : tiles_of(frame, block), range);
  }

  Tile tile_at(const glm::ivec2& number) const {
    Tile tile;
    const TileRun& run = runs.at(number);
    if (run.before) tile.before = run.before->data();
    if (run.place != nowhere) tile.own = found.data() + run.place;
    return tile;
  }

  /// The needed tiles with columns through dark cells.
  std::vector<TileRun*> tiles_through_dark(int slab, const DarkCells& cells) {
    std::vector<TileRun*> some;
    for (const CellCube& cube : cells.in(slab))
      common(tiles_through(frame, cube, slab), range).each([&](const glm::ivec2& number) {
        const auto tile = runs.find(number);
        if (tile == runs.end()) return;
        TileRun& run = tile->second;
        if (run.last < slab || run.mark == turn || run.ended) return;
        run.mark = turn;
        some.push_back(&run);
      });
    ++turn;
    std::ranges::sort(some, [](const TileRun* a, const TileRun* b) {
      return a->number.x != b->number.x ? a->number.x < b->number.x : a->number.y < b->number.y;
    });
    return some;
  }

  void give(int slab) const {
    const std::vector<std::size_t>& some = slabs.at(slab).wanted;
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
      const glm::ivec3& block = blocks[some[k]];
      BlockTiles of_block{tiles(block), {}};
      of_block.range.each([&](const glm::ivec2& at) { of_block.tiles.push_back(tile_at(at)); });
      std::array<double, 512> depths{};
      if (of_block.are_clear())
        ;  // as they are
      else if (placed)
        write_depths(*placed, of_block, slab, slab + 1 == frame.slabs(), block, depths.data());
      else
        write_depths(frame, of_block, block, depths.data());
      take(some[k], depths);
    });
  }

  /// What wants a slab.
  struct Slab {
    std::vector<std::size_t> wanted;  ///< blocks
    std::vector<TileRun*> ending;     ///< tiles that no later one needs
  };

  LatticeFrame frame;
  LightBlocks blocks;
  TakeDepths take;
  std::optional<VoxelPlaces> placed{};
  TileRange range;                                             ///< tiles that may attenuate
  std::unordered_map<glm::ivec2, TileRun, NumberHash> runs{};  ///< those that blocks need
  std::map<int, Slab> slabs{};
  std::vector<double> found{};          ///< depths of the slab's dark tiles
  std::vector<TileRun*> found_tiles{};  ///< these tiles
  int turn = 0;
};

}  // namespace light_tiles

struct LatticeRun::Impl : light_tiles::Columns {
  using Columns::Columns;
};

LatticeRun::LatticeRun(const LatticeFrame& frame, LightBlocks blocks, TakeDepths take,
                       const glm::dmat4* to_index)
    : impl_(std::make_unique<Impl>(frame, blocks, std::move(take), to_index)) {}
LatticeRun::~LatticeRun() = default;
LatticeRun::LatticeRun(LatticeRun&&) noexcept = default;

int LatticeRun::next_slab(int slab, const DarkCells& dark) const {
  const auto& slabs = impl_->slabs;
  if (slabs.empty() || slab > slabs.rbegin()->first) return -1;
  return std::min(slabs.lower_bound(slab)->first, dark.next_slab(slab));
}

double LatticeRun::bytes(const LatticeFrame& frame) {
  constexpr double of_tile = 64 + lattice_depths_of_slice * sizeof(double);
  return of_tile * double(light_tiles::tiles_of(frame).count());
}

void LatticeRun::add(int slab, const DarkCells& dark, const LatticeColumns& columns) {
  light_tiles::Columns& impl = *impl_;
  const std::vector<light_tiles::TileRun*> some = impl.tiles_through_dark(slab, dark);
  if (some.empty()) return;
  std::vector<LatticeBrick> bricks;
  for (const auto* tile : some)
    bricks.emplace_back(lattice_columns * tile->number, lattice_slices * slab);
  std::vector<double> own(some.size() * lattice_depths_of_brick);
  columns(bricks, own);
  const bool first = impl.found_tiles.empty();
  const double* from = own.data();
  for (auto* tile : some) {
    if (tile->place == light_tiles::nowhere) {
      tile->place = impl.found_tiles.size() * lattice_depths_of_brick;
      impl.found_tiles.push_back(tile);
      if (!first) impl.found.resize(impl.found_tiles.size() * lattice_depths_of_brick);
    }
    if (first) continue;
    double* to = impl.found.data() + tile->place;
    for (int k = 0; k < lattice_depths_of_brick; ++k) to[k] += from[k];
    from += lattice_depths_of_brick;
  }
  if (first) impl.found = std::move(own);
}

void LatticeRun::finish(int slab) {
  light_tiles::Columns& impl = *impl_;
  const auto ended = impl.slabs.find(slab);
  if (ended != impl.slabs.end()) impl.give(slab);
  for (auto* tile : impl.found_tiles) {
    const double* end = impl.found.data() + tile->place + lattice_depths_of_brick;
    if (!tile->before) tile->before = std::make_unique<light_tiles::Slice>();
    std::ranges::transform(*tile->before, std::span(end - lattice_depths_of_slice, end),
                           tile->before->begin(), std::plus());
    tile->ended = *std::ranges::min_element(*tile->before) > impl.frame.end;
    tile->place = light_tiles::nowhere;
  }
  if (ended != impl.slabs.end())
    for (auto* tile : ended->second.ending) tile->before.reset();
  impl.found_tiles.clear();
  impl.found.clear();
}

}  // namespace psivox
