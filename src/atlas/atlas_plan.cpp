#include "atlas/atlas_plan.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <glm/common.hpp>
#include <map>
#include <optional>

#include "atlas/page_table.h"
#include "field/index_space.h"

namespace psivox::atlas {
namespace {

/// So many bricks of one value get texels of their own, or as many as others have [bricks].
constexpr std::uint64_t few_constants = 4096;

/// Candidate bricks and their kind.
struct Candidate {
  Box bricks;
  EntryKind kind = EntryKind::empty;
  glm::vec3 value{0};
};

/// Bricks between tiles, which have no leaf's values: those with equal blocks are equal, and are
/// stored once. A wide tile's millions of faces are six.
class AlikeBricks {
 public:
  /// The slot of a brick that is equal, else `next`; unset where a leaf takes part.
  std::optional<std::uint32_t> slot(const BrickSource::Neighbours& from, std::uint32_t next) {
    std::array<float, 24> key;
    for (std::size_t i = 0; i < 8; ++i) {
      if (!from.blocks[i].is_constant()) return {};
      for (int c = 0; c < 3; ++c) key[3 * i + std::size_t(c)] = from.blocks[i].constant[c];
    }
    return slots_.try_emplace(key, next).first->second;
  }

 private:
  std::map<std::array<float, 24>, std::uint32_t> slots_;
};

/// Smallest and largest first channel of the blocks' parts that a brick holds.
ValueRange value_range(const BrickSource::Neighbours& from, int channels) {
  std::array<float, 24> room;
  const float first = *from.blocks[0].row(0, 0, 1, channels, room.data());
  ValueRange range{first, first};
  const auto see = [&](float value) {
    range = {std::min(range.min, value), std::max(range.max, value)};
  };
  for (int i = 0; i < 8; ++i) {
    const Block& block = from.blocks[i];
    if (block.is_constant()) {
      see(block.constant.x);
      continue;
    }
    const int nx = i & 4 ? 1 : 8, ny = i & 2 ? 1 : 8, nz = i & 1 ? 1 : 8;
    for (int x = 0; x < nx; ++x)
      for (int y = 0; y < ny; ++y) {
        const float* row = block.row(x, y, nz, channels, room.data());
        for (int z = 0; z < nz; ++z) see(row[z * channels]);
      }
  }
  return range;
}

/// Finds a brick's kind from its blocks, without copying the values.
void find_kind(const BrickSource& source, const BrickSource::Neighbours& from,
               Candidate& candidate) {
  const int channels = source.channels();
  std::array<float, 24> room;
  const float* corner = from.blocks[0].row(0, 0, 1, channels, room.data());
  glm::vec3 first{0};
  for (int c = 0; c < channels; ++c) first[c] = corner[c];
  candidate.value = first;

  const auto row_is_first = [&](const float* values, int count) {
    for (int i = 0; i < count * channels; ++i)
      if (values[i] != first[i % channels]) return false;
    return true;
  };
  for (int i = 0; i < 8; ++i) {
    const Block& block = from.blocks[i];
    if (block.is_constant()) {
      for (int c = 0; c < channels; ++c)
        if (block.constant[c] != first[c]) {
          candidate.kind = EntryKind::brick;
          return;
        }
      continue;
    }
    const int nx = i & 4 ? 1 : 8, ny = i & 2 ? 1 : 8, nz = i & 1 ? 1 : 8;
    for (int x = 0; x < nx; ++x)
      for (int y = 0; y < ny; ++y) {
        if (row_is_first(block.row(x, y, nz, channels, room.data()), nz)) continue;
        candidate.kind = EntryKind::brick;
        return;
      }
  }
  candidate.kind = first == glm::vec3(0) ? EntryKind::empty : EntryKind::constant;
}

/// Finds a brick's kind by options.visible, under which constants of 0 may be visible.
void find_visible_kind(const BrickSource& source, const BrickSource* companion,
                       const AtlasOptions& options, Candidate& candidate) {
  const BrickSource::Neighbours from = source.neighbours(candidate.bricks.min);
  find_kind(source, from, candidate);
  const ValueRange own = value_range(from, source.channels());
  const ValueRange companions =
      companion ? value_range(companion->neighbours(candidate.bricks.min), 1) : ValueRange{};
  if (!options.visible(own, companions))
    candidate.kind = EntryKind::empty;
  else if (candidate.kind == EntryKind::empty)
    candidate.kind = EntryKind::constant;
}

/// Least and greatest corner of the cells of a brick that touch one of its faces.
ValueRange face_range(const float* values, int axis, bool upper) {
  glm::ivec3 low(0), high(brick_values - 1);
  (upper ? low : high)[axis] = upper ? brick_values - 2 : 1;
  return range_in_brick(values, low, high);
}

/// Calls `each` for the bricks of a box, whose ends are inclusive.
template <typename Each>
void for_bricks(const Box& box, const Each& each) {
  for (int x = box.min.x; x <= box.max.x; ++x)
    for (int y = box.min.y; y <= box.max.y; ++y)
      for (int z = box.min.z; z <= box.max.z; ++z) each(glm::ivec3(x, y, z));
}

/// A bit for each face of a brick at which one of its cells is visible.
std::uint8_t visible_faces(const BrickSource& source, const AtlasOptions& options,
                           const glm::ivec3& brick) {
  std::array<float, brick_texels> values;
  source.gather(source.neighbours(brick), values.data());
  unsigned faces = 0;
  for (int face = 0; face < 6; ++face)
    if (options.visible(face_range(values.data(), face >> 1, face & 1), {})) faces |= 1u << face;
  return std::uint8_t(faces);
}

/// The bricks beside a face of a box.
Box beside(Box box, int face) {
  const int axis = face >> 1;
  box.min[axis] = box.max[axis] = face & 1 ? box.max[axis] + 1 : box.min[axis] - 1;
  return box;
}

/// Makes bricks visible, with their values, beside faces at which another's cells are.
void add_margin(const BrickSource& source, const AtlasOptions& options, const Box& region,
                std::vector<Candidate>& candidates) {
  const std::size_t own = candidates.size();
  std::vector<std::uint8_t> reached(own);
  tbb::parallel_for(std::size_t{0}, own, [&](std::size_t i) {
    if (candidates[i].kind == EntryKind::brick)
      reached[i] = visible_faces(source, options, candidates[i].bricks.min);
  });
  BlockMap numbers(own), added;
  for (std::size_t i = 0; i < own; ++i) numbers.insert(candidates[i].bricks.min, std::int32_t(i));
  const std::vector<int> widths = source.widths();
  const auto is_stored = [&](const glm::ivec3& brick) {
    return std::ranges::any_of(widths, [&](int width) {
      const Box piece = Piece::at(brick, width).bricks(region);
      const std::int32_t i = numbers.find(piece.min);
      if (i == BlockMap::none) return false;
      const Candidate& found = candidates[std::size_t(i)];
      return found.kind != EntryKind::empty && found.bricks.contains(brick);
    });
  };
  for (std::size_t i = 0; i < own; ++i)
    for (int face = 0; face < 6; ++face) {
      if (!(reached[i] >> face & 1)) continue;
      for_bricks(beside(candidates[i].bricks, face), [&](const glm::ivec3& brick) {
        const auto next = std::int32_t(candidates.size());
        if (is_stored(brick) || added.insert(brick, next) != next) return;
        Candidate candidate{{brick, brick}};
        find_kind(source, source.neighbours(brick), candidate);
        if (candidate.kind == EntryKind::empty) candidate.kind = EntryKind::constant;
        candidates.push_back(candidate);
      });
    }
}

/// Whether bricks of one value are few enough to store their texels.
bool few_are_constant(const std::vector<Candidate>& candidates,
                      const std::vector<BrickSource::ConstantBox>& tiles) {
  std::uint64_t constants = 0, others = 0;
  for (const Candidate& candidate : candidates) {
    const std::uint64_t count = count_of(candidate.bricks);
    if (candidate.kind == EntryKind::constant) constants += count;
    if (candidate.kind == EntryKind::brick) others += count;
  }
  for (const BrickSource::ConstantBox& tile : tiles) constants += count_of({tile.min, tile.max});
  return constants <= std::max(few_constants, others);
}

/// What is known of a field's atlas before its bricks are.
BrickAtlas without_bricks(const Field& field, const AtlasOptions& options) {
  BrickAtlas atlas;
  atlas.channels = field.channels;
  atlas.texel = options.texel;
  atlas.domain = field.domain();
  for (const Box& box : options.walked) {
    atlas.domain.min = glm::min(atlas.domain.min, box.min);
    atlas.domain.max = glm::max(atlas.domain.max, box.max);
  }
  return atlas;
}

/// Makes an atlas's topology from a field's pieces.
class Planner {
 public:
  Planner(const Field& field, const AtlasOptions& options, const BrickSource& source)
      : options_(options),
        source_(source),
        atlas_(without_bricks(field, options)),
        region_(options.region.value_or(everywhere)),
        bricks_{atlas_.domain.min >> 3, (atlas_.domain.max - 1) >> 3},
        channels_(field.channels),
        zero_visible_(visible(0)),
        keep_all_(zero_visible_ && !options.walked.empty()),
        pages_(bricks_.min, bricks_.max, options.top_entries) {}

  BrickAtlas run() {
    find_candidates();
    place_background();
    const std::vector<BrickSource::ConstantBox> tiles = source_.wide_tiles();
    atlas_.own_texels =
        options_.own_texels && !zero_visible_ && few_are_constant(candidates_, tiles);
    for (const BrickSource::ConstantBox& box : tiles) place(box);
    for (const Candidate& candidate : candidates_) place(candidate);
    atlas_.pages = pages_.finish();
    AtlasSize& size = atlas_.size;
    size.textured_bricks = atlas_.places.size();
    size.page_bytes = atlas_.pages.entries.size() * sizeof(std::uint32_t);
    size.constant_bytes = atlas_.constants.size() * sizeof(float);
    size.texel_bytes = texel_bytes(atlas_.places.size(), channels_, options_.texel);
    return std::move(atlas_);
  }

 private:
  static constexpr std::uint32_t nothing = make_entry(EntryKind::empty, 1);

  /// Whether bricks of one value are visible where the companion is 0.
  bool visible(float value) const {
    return options_.visible ? options_.visible({value, value}, {}) : value != 0;
  }

  void find_candidates() {
    std::optional<BrickSource> companion;
    if (options_.companion) companion.emplace(*options_.companion);
    for (const Piece& piece : source_.candidates())
      if (const Box bricks = piece.bricks(region_); !bricks.empty())
        candidates_.push_back({bricks});
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, candidates_.size(), 256), [&](const auto& range) {
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            if (options_.visible && !keep_all_)
              find_visible_kind(source_, companion ? &*companion : nullptr, options_,
                                candidates_[i]);
            else
              find_kind(source_, source_.neighbours(candidates_[i].bricks.min), candidates_[i]);
          }
        });
    if (options_.with_margin) add_margin(source_, options_, region_, candidates_);
  }

  void set_box(const glm::ivec3& min, const glm::ivec3& max, std::uint32_t entry) {
    const Box box = common({min, max}, region_);
    if (!box.empty()) pages_.set_box(box.min, box.max, entry);
  }

  std::uint32_t add_constant(const glm::vec3& value) {
    const auto next = std::uint32_t(atlas_.constants.size() / std::size_t(channels_));
    std::array<std::uint32_t, 3> bits{};
    for (int c = 0; c < channels_; ++c)
      bits[std::size_t(c)] = std::bit_cast<std::uint32_t>(value[c]);
    const std::uint32_t index = constants_.try_emplace(bits, next).first->second;
    if (index == next)
      for (int c = 0; c < channels_; ++c) atlas_.constants.push_back(value[c]);
    ++atlas_.size.constant_bricks;
    return make_entry(EntryKind::constant, index);
  }

  void add_brick(const glm::ivec3& brick) {
    pages_.set_brick(brick, make_entry(EntryKind::brick, std::uint32_t(atlas_.places.size())));
    atlas_.places.push_back(brick);
  }

  /// Bricks that no leaf or tile reaches are 0.
  void place_background() {
    if (zero_visible_) return set_box(bricks_.min, bricks_.max, add_constant(glm::vec3(0)));
    if (options_.walked.empty()) return;
    const std::uint32_t zero = add_constant(glm::vec3(0));
    for (const Box& box : options_.walked) set_box(box.min >> 3, (box.max - 1) >> 3, zero);
  }

  void place(const BrickSource::ConstantBox& tile) {
    if (atlas_.own_texels && visible(tile.value.x))
      for_bricks(common({tile.min, tile.max}, region_),
                 [&](const glm::ivec3& brick) { add_brick(brick); });
    else if (keep_all_ || visible(tile.value.x))
      set_box(tile.min, tile.max, add_constant(tile.value));
    else if (zero_visible_)
      set_box(tile.min, tile.max, nothing);
  }

  void place(const Candidate& candidate) {
    const Box box = common(candidate.bricks, bricks_);
    if (box.empty()) return;
    if (candidate.kind == EntryKind::empty) {
      if (zero_visible_ && !keep_all_) pages_.set_box(box.min, box.max, nothing);
    } else if (atlas_.own_texels) {
      for_bricks(box, [&](const glm::ivec3& brick) { add_brick(brick); });
    } else if (candidate.kind == EntryKind::constant) {
      pages_.set_box(box.min, box.max, add_constant(candidate.value));
    } else {
      const auto next = std::uint32_t(atlas_.places.size());
      const std::uint32_t slot = alike_.slot(source_.neighbours(box.min), next).value_or(next);
      pages_.set_box(box.min, box.max, make_entry(EntryKind::brick, slot));
      if (slot == next) atlas_.places.push_back(box.min);
    }
  }

  const AtlasOptions& options_;
  const BrickSource& source_;
  BrickAtlas atlas_;
  Box region_, bricks_;  ///< bricks to store, and the domain's
  int channels_;
  bool zero_visible_;
  bool keep_all_;  ///< bricks walked for another grid must stay distinct from the 0 around them
  std::vector<Candidate> candidates_;
  PageTableBuilder pages_;
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> constants_;  ///< places, by their bits
  AlikeBricks alike_;
};

}  // namespace

std::uint64_t texel_bytes(std::size_t bricks, int channels, TexelType texel) {
  return bricks * brick_texels * std::uint64_t(channels) * (texel == TexelType::float16 ? 2u : 4u);
}

Plan make_plan(const Field& field, const AtlasOptions& options) {
  BrickSource::check_width(field);
  Plan plan{BrickSource(field), {}};
  plan.atlas = Planner(field, options, plan.source).run();
  return plan;
}

}  // namespace psivox::atlas
