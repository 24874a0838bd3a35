#include "atlas/atlas_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <glm/common.hpp>
#include <map>
#include <optional>

#include "atlas/brick_source.h"
#include "field/index_space.h"

namespace psivox::atlas {
namespace {

/// Bricks of one value get texels of their own if there are at most this many, or no more than
/// other bricks.
constexpr std::uint64_t few_constants = 4096;

/// Bricks between tiles, which have no leaf's values: those with equal blocks are equal, and are
/// stored once. A wide tile's millions of faces are six.
class AlikeBricks {
  using Bits = std::array<std::uint32_t, 24>;  // of floats: NaN is a value, too

 public:
  /// The slot of a brick that is equal, else `next`; unset where a leaf takes part.
  std::optional<std::uint32_t> slot(const BrickSource::Neighbours& from, int channels,
                                    std::uint32_t next) {
    Bits key{};
    for (std::size_t i = 0; i < 8; ++i) {
      if (!from[i].is_constant()) return {};
      for (int c = 0; c < channels; ++c)
        key[3 * i + std::size_t(c)] = std::bit_cast<std::uint32_t>(from[i].values.channel(c));
    }
    return slots_.try_emplace(key, next).first->second;
  }

 private:
  std::map<Bits, std::uint32_t> slots_;
};

/// Whether bricks of one value are few enough to store their texels.
bool few_are_constant(const std::vector<Candidate>& candidates) {
  std::uint64_t constants = 0, others = 0;
  for (const Candidate& candidate : candidates) {
    const std::uint64_t count = count_of(candidate.bricks);
    if (candidate.kind == EntryKind::constant) constants += count;
    if (candidate.kind == EntryKind::brick) others += count;
  }
  return constants <= std::max(few_constants, others);
}

/// What is known of a field's atlas before its bricks are.
BrickAtlas without_bricks(const Field& field, const AtlasOptions& options) {
  BrickAtlas atlas;
  atlas.channels = field.channels;
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
        region_(options.region),
        bricks_{atlas_.domain.min >> 3, (atlas_.domain.max - 1) >> 3},
        channels_(field.channels),
        zero_visible_(options.sees({})),
        keep_all_(zero_visible_ && !options.walked.empty()),
        pages_(bricks_.min, bricks_.max, options.top_entries) {}

  BrickAtlas run() {
    candidates_ = find_candidates(source_, options_, region_, keep_all_);
    place_background();
    atlas_.own_texels = options_.own_texels && !zero_visible_ && few_are_constant(candidates_);
    for (const Candidate& candidate : candidates_) place(candidate);
    atlas_.pages = pages_.finish();
    AtlasSize& size = atlas_.size;
    size.textured_bricks = atlas_.places.size();
    size.page_bytes = atlas_.pages.entries.size() * sizeof(std::uint32_t);
    size.constant_bytes = atlas_.constants.size() * sizeof(float);
    size.texel_bytes = texel_bytes(atlas_.places.size(), channels_);
    return std::move(atlas_);
  }

 private:
  static constexpr std::uint32_t nothing = make_entry(EntryKind::empty, 1);

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
    pages_.set_box(brick, brick, make_entry(EntryKind::brick, std::uint32_t(atlas_.places.size())));
    atlas_.places.push_back(brick);
  }

  /// Bricks that no leaf or tile reaches are 0.
  void place_background() {
    if (zero_visible_) return set_box(bricks_.min, bricks_.max, add_constant(glm::vec3(0)));
    if (options_.walked.empty()) return;
    const std::uint32_t zero = add_constant(glm::vec3(0));
    for (const Box& box : options_.walked) set_box(box.min >> 3, (box.max - 1) >> 3, zero);
  }

  void place(const Candidate& candidate) {
    const Box box = common(candidate.bricks, bricks_);
    if (box.empty()) return;
    if (candidate.kind == EntryKind::empty) {
      if (zero_visible_ && !keep_all_) pages_.set_box(box.min, box.max, nothing);
    } else if (atlas_.own_texels) {
      for_points(box, [&](const glm::ivec3& brick) { add_brick(brick); });
    } else if (candidate.kind == EntryKind::constant) {
      pages_.set_box(box.min, box.max, add_constant(candidate.value));
    } else {
      const auto next = std::uint32_t(atlas_.places.size());
      const std::uint32_t slot =
          alike_.slot(source_.neighbours(box.min), channels_, next).value_or(next);
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

std::uint64_t texel_bytes(std::size_t bricks, int channels) {
  return bricks * brick_texels * std::uint64_t(channels) * sizeof(float);
}

Plan make_plan(const Field& field, const AtlasOptions& options) {
  BrickSource::check_width(field);
  Plan plan{BrickSource(field), {}};
  plan.atlas = Planner(field, options, plan.source).run();
  return plan;
}

}  // namespace psivox::atlas
