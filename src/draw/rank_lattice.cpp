#include "draw/rank_lattice.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <map>
#include <numeric>
#include <tuple>

namespace psivox {
namespace {

/// Slabs of 8 slices that are exchanged at once.
constexpr int slabs_at_once = 4;

constexpr std::size_t brick_columns = lattice_columns * lattice_columns;
constexpr std::size_t brick_depths = lattice_depths_of_brick;

/// The columns of bricks that follow each other.
using Square = std::pair<int, int>;
Square square_of(const LatticeBrick& brick) {
  return {brick.x / lattice_columns, brick.y / lattice_columns};
}

using Carry = std::array<double, brick_columns>;
using Message = std::vector<glm::vec4>;

/// Both ends inclusive.
struct Squares {
  glm::ivec2 min{0}, max{-1};
  bool empty() const { return max.x < min.x || max.y < min.y; }
  bool has(const Square& s) const {
    return s.first >= min.x && s.first <= max.x && s.second >= min.y && s.second <= max.y;
  }
};

/// What a rank asks for, slab by slab: a prism that leans with the light, so that it meets a square
/// in slabs that follow each other.
class Wanted {
 public:
  Wanted(const LatticeFrame& frame, const Box& bricks, const Box& domain)
      : frame_(frame),
        low_(glm::max(8 * glm::max(bricks.min, -most), domain.min & ~7)),
        high_(glm::min(8 * glm::min(bricks.max, most) + 15, domain.max | 7)) {
    if (glm::any(glm::lessThan(high_, low_))) return;
    const int a = frame.slice(low_[frame.axis]), b = frame.slice(high_[frame.axis]);
    first_ = std::min(a, b) >> 3;
    last_ = std::max(a, b) >> 3;
  }

  /// Squares whose columns its voxels in a slab are interpolated from.
  Squares in(int slab) const {
    if (slab < first_ || slab > last_) return {};
    const glm::dvec2 low = glm::dvec2(frame_.across(low_)) - 1.0;
    const glm::dvec2 high = glm::dvec2(frame_.across(high_)) + 1.0;
    const glm::dvec2 a = frame_.column(low, 8 * slab), b = frame_.column(low, 8 * slab + 7);
    const glm::dvec2 c = frame_.column(high, 8 * slab), d = frame_.column(high, 8 * slab + 7);
    // whole tiles of 8 x 8 columns
    constexpr int bricks = 8 / lattice_columns;
    return {bricks * ((glm::ivec2(glm::floor(glm::min(a, b))) - 1) >> 3),
            bricks * ((glm::ivec2(glm::floor(glm::max(c, d))) + 2) >> 3) + (bricks - 1)};
  }

 private:
  static constexpr glm::ivec3 most{1 << 27};
  const LatticeFrame& frame_;
  glm::ivec3 low_, high_;  ///< voxels
  int first_ = 0, last_ = -1;
};

/// Depths through this rank's own part.
class OwnColumns {
 public:
  void add(const LatticeBrick& brick, const double* depths) {
    auto& kept = slabs_[brick.z >> 3][square_of(brick)];
    std::copy_n(depths, brick_depths, kept.begin());
  }

  /// Adds to the messages what the ranks need in a slab, and forgets it.
  void send(int slab, const std::vector<Wanted>& wanted, std::vector<Message>& messages) {
    const auto found = slabs_.find(slab);
    for (std::size_t rank = 0; rank < wanted.size(); ++rank) {
      const Squares now = wanted[rank].in(slab), before = wanted[rank].in(slab - 1);
      if (now.empty()) continue;
      for (const auto& [square, carry] : carries_)
        if (now.has(square) && !before.has(square))
          write(messages[rank], slab, square, carry.data(), brick_columns);
      if (found == slabs_.end()) continue;
      for (const auto& [square, depths] : found->second)
        if (now.has(square)) write(messages[rank], slab, square, depths.data(), brick_depths);
    }
    if (found == slabs_.end()) return;
    for (const auto& [square, depths] : found->second) {
      Carry& carry = carries_[square];
      for (std::size_t column = 0; column < brick_columns; ++column)
        carry[column] += depths[8 * column + 7];
    }
    slabs_.erase(found);
  }

 private:
  static void write(Message& message, int slab, const Square& square, const double* depths,
                    std::size_t count) {
    message.emplace_back(slab, square.first, square.second, count);
    for (std::size_t i = 0; i < count; i += 4)
      message.emplace_back(depths[i], depths[i + 1], depths[i + 2], depths[i + 3]);
  }

  std::map<int, std::map<Square, std::array<double, brick_depths>>> slabs_;
  std::map<Square, Carry> carries_;  ///< up to the slab that comes next
};

/// Depths through all parts, in what this rank asks for.
class JoinedColumns {
 public:
  void add(const Message& message) {
    for (std::size_t at = 0; at < message.size();) {
      const glm::vec4 head = message[at++];
      const Square square(int(head.y), int(head.z));
      const auto count = std::size_t(head.w);
      double* to = count == brick_columns ? arriving_[int(head.x)][square].data()
                                          : slabs_[int(head.x)][square].data();
      for (std::size_t i = 0; i < count; ++i) to[i] += double(message[at + i / 4][int(i % 4)]);
      at += count / 4;
    }
  }

  /// Those of a slab from the light on, which must have taken the columns that arrive there.
  void write(std::span<const LatticeBrick> bricks, std::span<double> depths) const {
    for (const LatticeBrick& brick : bricks) {
      const Square square = square_of(brick);
      const auto slab = slabs_.find(brick.z >> 3);
      const auto carry = carries_.find(square);
      const double* own = nullptr;
      if (slab != slabs_.end())
        if (const auto found = slab->second.find(square); found != slab->second.end())
          own = found->second.data();
      for (std::size_t i = 0; i < brick_depths; ++i)
        depths[i] = (own ? own[i] : 0) + (carry != carries_.end() ? carry->second[i / 8] : 0);
      depths = depths.subspan(brick_depths);
    }
  }

  void enter(int slab) {
    for (const auto& [square, carry] : arriving_[slab]) carries_[square] = carry;
    arriving_.erase(slab);
  }
  void leave(int slab) {
    for (const auto& [square, depths] : slabs_[slab]) {
      Carry& carry = carries_[square];
      for (std::size_t column = 0; column < brick_columns; ++column)
        carry[column] += depths[8 * column + 7];
    }
    slabs_.erase(slab);
  }

 private:
  std::map<int, std::map<Square, Carry>> arriving_;
  std::map<int, std::map<Square, std::array<double, brick_depths>>> slabs_;
  std::map<Square, Carry> carries_;  ///< up to the slab that comes next
};

/// The blocks, and those below them along the axis of slices: what lies on the lowest face of a
/// part also weighs in the step from there to the next slice, which may be of the next slab.
std::vector<glm::ivec3> with_below(const LatticeFrame& frame, std::span<const glm::ivec3> blocks) {
  std::vector<glm::ivec3> all(blocks.begin(), blocks.end());
  for (glm::ivec3 block : blocks) {
    block[frame.axis] -= 8;
    if (block[frame.axis] + 7 >= frame.domain.min[frame.axis]) all.push_back(block);
  }
  const auto before = [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::ranges::sort(all, before);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

void RankLattice::depths(const LatticeFrame& frame, const LatticeColumns& columns,
                         const LightBlocks& blocks, const TakeDepths& take,
                         const Progress& progress) {
  const Box& domain = frame.domain;
  const int slabs =
      (std::max(frame.slice(domain.min[frame.axis]), frame.slice(domain.max[frame.axis])) >> 3) + 1;
  std::vector<Wanted> wanted;
  for (const Box& bricks : bricks_) wanted.emplace_back(frame, bricks, domain);
  std::vector<std::vector<std::size_t>> wanted_blocks(std::size_t(slabs),
                                                      std::vector<std::size_t>{});
  for (const std::size_t block : blocks.wanted) {
    const int z = blocks.all[block][frame.axis];
    wanted_blocks[std::size_t(std::min(frame.slice(z), frame.slice(z + 7)) >> 3)].push_back(block);
  }
  // no octants: what other ranks hide is not known here
  const BrickAtlas unknown;
  LatticeFrame all_parts = frame;
  all_parts.density = &unknown;
  all_parts.part.reset();
  OwnColumns own;
  JoinedColumns joined;
  const LatticeColumns joined_columns = [&](std::span<const LatticeBrick> bricks,
                                            std::span<double> depths) {
    joined.write(bricks, depths);
  };

  // alone, so that no carry of another slab is added to those that are joined
  const auto in_slab = [&](const std::vector<std::size_t>& numbers) {
    std::vector<glm::ivec3> places;
    for (const std::size_t block : numbers) places.push_back(blocks.all[block]);
    std::vector<std::size_t> all(numbers.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    lattice_depths(all_parts, {places, all}, joined_columns,
                   [&](std::size_t i, std::span<const double> found) { take(numbers[i], found); });
  };
  int done = 0;
  const auto finish_before = [&](int slab) {
    while (done < slabs && done + slabs_at_once <= slab) {
      const int end = std::min(done + slabs_at_once, slabs);
      std::vector<Message> messages(std::size_t(team_.size()));
      for (int s = done; s < end; ++s) own.send(s, wanted, messages);
      for (const Message& message : team_.exchange(messages)) joined.add(message);
      for (; done < end; ++done) {
        joined.enter(done);
        in_slab(wanted_blocks[std::size_t(done)]);
        joined.leave(done);
      }
      if (progress) progress(double(done) / slabs);
    }
  };
  const LatticeColumns own_columns = [&](std::span<const LatticeBrick> bricks,
                                         std::span<double> depths) {
    columns(bricks, depths);
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      finish_before(bricks[i].z >> 3);
      own.add(bricks[i], depths.data() + i * brick_depths);
    }
  };
  const std::vector<glm::ivec3> own_blocks = with_below(frame, blocks.all);
  lattice_depths(frame, {own_blocks, {}}, own_columns, {});
  finish_before(slabs + slabs_at_once);
}

}  // namespace psivox
