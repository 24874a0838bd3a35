#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "atlas/brick_source.h"
#include "atlas/page_table.h"
#include "psivox/atlas.h"
#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

using atlas::BrickSource;

constexpr float largest_half = 65504;

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
    const atlas::Block& block = from.blocks[i];
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
    const atlas::Block& block = from.blocks[i];
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
  ValueRange range{HUGE_VALF, -HUGE_VALF};
  for (int x = low.x; x <= high.x; ++x)
    for (int y = low.y; y <= high.y; ++y)
      for (int z = low.z; z <= high.z; ++z) {
        const float value = values[(x * brick_values + y) * brick_values + z];
        range = {std::min(range.min, value), std::max(range.max, value)};
      }
  return range;
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
  atlas::BlockMap numbers(own), added;
  for (std::size_t i = 0; i < own; ++i) numbers.insert(candidates[i].bricks.min, std::int32_t(i));
  const std::vector<int> widths = source.widths();
  const auto is_stored = [&](const glm::ivec3& brick) {
    return std::ranges::any_of(widths, [&](int width) {
      const Box piece = atlas::Piece::at(brick, width).bricks(region);
      const std::int32_t i = numbers.find(piece.min);
      if (i == atlas::BlockMap::none) return false;
      const Candidate& found = candidates[std::size_t(i)];
      return found.kind != EntryKind::empty &&
             glm::clamp(brick, found.bricks.min, found.bricks.max) == brick;
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

/// Topology of an atlas: everything except the texels.
struct Plan {
  BrickSource source;
  BrickAtlas atlas;
};

/// Of a box that is not empty.
std::uint64_t brick_count(const Box& box) {
  const glm::u64vec3 size(box.max - box.min + 1);
  return size.x * size.y * size.z;
}

Box common(const Box& a, const Box& b) { return {glm::max(a.min, b.min), glm::min(a.max, b.max)}; }

/// Whether bricks of one value are few enough to store their texels.
bool few_are_constant(const std::vector<Candidate>& candidates,
                      const std::vector<BrickSource::ConstantBox>& tiles) {
  std::uint64_t constants = 0, others = 0;
  for (const Candidate& candidate : candidates) {
    const std::uint64_t count = brick_count(candidate.bricks);
    if (candidate.kind == EntryKind::constant) constants += count;
    if (candidate.kind == EntryKind::brick) others += count;
  }
  for (const BrickSource::ConstantBox& tile : tiles) constants += brick_count({tile.min, tile.max});
  return constants <= std::max(few_constants, others);
}

std::uint64_t texel_bytes(std::size_t bricks, int channels, TexelType texel) {
  return bricks * brick_texels * std::uint64_t(channels) * (texel == TexelType::float16 ? 2u : 4u);
}

Plan make_plan(const Field& field, const AtlasOptions& options) {
  BrickSource::check_width(field);
  Plan plan{BrickSource(field), {}};
  // for bricks of one value where the companion is 0
  const auto visible = [&](float value) {
    return options.visible ? options.visible({value, value}, {}) : value != 0;
  };
  std::optional<BrickSource> companion;
  if (options.companion) companion.emplace(*options.companion);
  // Bricks walked for another grid must stay distinct from the 0 around them.
  const bool keep_all = visible(0) && !options.walked.empty();
  std::vector<Candidate> candidates;
  const Box region = options.region.value_or(atlas::everywhere);
  for (const atlas::Piece& piece : plan.source.candidates())
    if (const Box bricks = piece.bricks(region); !bricks.empty()) candidates.push_back({bricks});
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, candidates.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        if (options.visible && !keep_all)
                          find_visible_kind(plan.source, companion ? &*companion : nullptr, options,
                                            candidates[i]);
                        else
                          find_kind(plan.source, plan.source.neighbours(candidates[i].bricks.min),
                                    candidates[i]);
                      }
                    });

  if (options.with_margin) add_margin(plan.source, options, region, candidates);

  BrickAtlas& result = plan.atlas;
  result.channels = field.channels;
  result.texel = options.texel;
  result.domain = field.domain();
  for (const Box& box : options.walked) {
    result.domain.min = glm::min(result.domain.min, box.min);
    result.domain.max = glm::max(result.domain.max, box.max);
  }
  const glm::ivec3 first = result.domain.min >> 3;
  const glm::ivec3 last = (result.domain.max - 1) >> 3;
  atlas::PageTableBuilder pages(first, last, options.top_entries);
  const auto set_box = [&](const glm::ivec3& min, const glm::ivec3& max, std::uint32_t entry) {
    const Box box = common({min, max}, region);
    if (!box.empty()) pages.set_box(box.min, box.max, entry);
  };
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> constants;  // their places, by their bits
  const auto add_constant = [&](const glm::vec3& value) {
    const auto next = std::uint32_t(result.constants.size() / std::size_t(field.channels));
    std::array<std::uint32_t, 3> bits{};
    for (int c = 0; c < field.channels; ++c)
      bits[std::size_t(c)] = std::bit_cast<std::uint32_t>(value[c]);
    const std::uint32_t index = constants.try_emplace(bits, next).first->second;
    if (index == next)
      for (int c = 0; c < field.channels; ++c) result.constants.push_back(value[c]);
    ++result.size.constant_bricks;
    return make_entry(EntryKind::constant, index);
  };
  // Bricks that no leaf or tile reaches are 0.
  if (visible(0))
    set_box(first, last, add_constant(glm::vec3(0)));
  else if (!options.walked.empty()) {
    const std::uint32_t zero = add_constant(glm::vec3(0));
    for (const Box& box : options.walked) set_box(box.min >> 3, (box.max - 1) >> 3, zero);
  }
  const std::vector<BrickSource::ConstantBox> tiles = plan.source.wide_tiles();
  result.own_texels = options.own_texels && !visible(0) && few_are_constant(candidates, tiles);
  const auto add_brick = [&](const glm::ivec3& brick) {
    pages.set_brick(brick, make_entry(EntryKind::brick, std::uint32_t(result.places.size())));
    result.places.push_back(brick);
  };
  constexpr std::uint32_t nothing = make_entry(EntryKind::empty, 1);
  for (const BrickSource::ConstantBox& box : tiles) {
    if (result.own_texels && visible(box.value.x))
      for_bricks(common({box.min, box.max}, region), add_brick);
    else if (keep_all || visible(box.value.x))
      set_box(box.min, box.max, add_constant(box.value));
    else if (visible(0))
      set_box(box.min, box.max, nothing);
  }
  AlikeBricks alike;
  for (const Candidate& candidate : candidates) {
    const Box box = common(candidate.bricks, {first, last});
    if (box.empty()) continue;
    if (candidate.kind == EntryKind::empty) {
      if (visible(0) && !keep_all) pages.set_box(box.min, box.max, nothing);
    } else if (result.own_texels) {
      for_bricks(box, add_brick);
    } else if (candidate.kind == EntryKind::constant) {
      pages.set_box(box.min, box.max, add_constant(candidate.value));
    } else {
      const auto next = std::uint32_t(result.places.size());
      const std::uint32_t slot = alike.slot(plan.source.neighbours(box.min), next).value_or(next);
      pages.set_box(box.min, box.max, make_entry(EntryKind::brick, slot));
      if (slot == next) result.places.push_back(box.min);
    }
  }
  result.pages = pages.finish();

  AtlasSize& size = result.size;
  size.textured_bricks = result.places.size();
  size.page_bytes = result.pages.entries.size() * sizeof(std::uint32_t);
  size.constant_bytes = result.constants.size() * sizeof(float);
  size.texel_bytes = texel_bytes(result.places.size(), field.channels, options.texel);
  return plan;
}

BrickStats measure(const float* values, int channels) {
  const auto stride = std::size_t(channels);
  std::array<float, brick_texels> v;
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = values[i * stride];
  BrickStats stats{v[0], v[0], 0};
  for (const float value : v) {
    stats.min = std::min(stats.min, value);
    stats.max = std::max(stats.max, value);
  }
  constexpr std::size_t n = brick_values;
  float largest = 0;
  for (const std::size_t step : {std::size_t{1}, n, n * n})
    for (std::size_t x = step == n * n; x < n - (step == n * n); ++x)
      for (std::size_t y = step == n; y < n - (step == n); ++y)
        for (std::size_t z = step == 1; z < n - (step == 1); ++z) {
          const std::size_t i = (x * n + y) * n + z;
          largest = std::max(largest, std::abs(v[i - step] - 2 * v[i] + v[i + step]));
        }
  stats.second_difference = largest;
  return stats;
}

/// A bit for each octant of a brick without a visible cell.
std::uint32_t hidden_octants(const float* values, const AtlasOptions& options) {
  constexpr int half = brick_cells / 2;
  std::uint32_t hidden = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 from = half * glm::ivec3(i >> 2, i >> 1 & 1, i & 1), to = from + half;
    ValueRange range{HUGE_VALF, -HUGE_VALF};
    for (int x = from.x; x <= to.x; ++x)
      for (int y = from.y; y <= to.y; ++y)
        for (int z = from.z; z <= to.z; ++z) {
          const float value = values[(x * brick_values + y) * brick_values + z];
          range = {std::min(range.min, value), std::max(range.max, value)};
        }
    if (!(options.visible ? options.visible(range, {}) : range.min != 0 || range.max != 0))
      hidden |= 1u << i;
  }
  return hidden;
}

/// Marks them in the page table, where its payloads have the room.
void mark_octants(const AtlasOptions& options, BrickAtlas& result) {
  if (!options.mark_octants || options.companion || !options.walked.empty() ||
      result.channels > 1 || !result.texels32 || result.bricks.size() >> entry_slot_bits)
    return;
  std::vector<std::uint32_t> hidden(result.bricks.size());
  tbb::parallel_for(std::size_t{0}, hidden.size(), [&](std::size_t slot) {
    hidden[slot] = hidden_octants(result.texels32.get() + slot * brick_texels, options);
  });
  result.pages.octants = true;
  for (std::uint32_t& entry : result.pages.entries)
    if (entry_kind(entry) == EntryKind::brick)
      entry |= hidden[entry_payload(entry)] << entry_slot_bits;
}

void check_limit(const AtlasSize& size, const std::string& grid, const AtlasOptions& options) {
  const std::uint64_t needed = 2 * size.bytes();
  if (options.memory_limit && needed > options.memory_limit)
    throw Error(ExitCode::memory,
                "grid '" + grid + "' needs an atlas of " + mebibytes(needed) +
                    " (host and GPU), over the limit of " + mebibytes(options.memory_limit) +
                    (options.texel == TexelType::float32 ? "; --texel float16 halves it" : ""));
}

/// Texels and statistics of the bricks at result.places.
void fill(const BrickSource& source, const std::string& grid, BrickAtlas& result) {
  const std::size_t per_brick = brick_texels * std::size_t(result.channels);
  const std::size_t texels = result.places.size() * per_brick;
  result.bricks.resize(result.places.size());
  const bool half = result.texel == TexelType::float16;
  if (half)
    result.texels16 = std::make_unique_for_overwrite<std::uint16_t[]>(texels);
  else
    result.texels32 = std::make_unique_for_overwrite<float[]>(texels);

  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, result.places.size(), 64),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      std::vector<float> values(half ? per_brick : 0);
                      for (std::size_t slot = range.begin(); slot != range.end(); ++slot) {
                        float* to = half ? values.data() : result.texels32.get() + slot * per_brick;
                        source.gather(source.neighbours(result.places[slot]), to);
                        result.bricks[slot] = measure(to, result.channels);
                        if (!half) continue;
                        for (std::size_t i = 0; i < per_brick; ++i) {
                          if (std::abs(to[i]) > largest_half)
                            throw Error(
                                ExitCode::input,
                                "grid '" + grid + "' has the value " + std::to_string(to[i]) +
                                    ", beyond float16's largest, 65504; use --texel float32");
                          result.texels16[slot * per_brick + i] = glm::packHalf1x16(to[i]);
                        }
                      }
                    });
}

}  // namespace

std::vector<glm::ivec3> textured_bricks(const Field& field, const AtlasOptions& options,
                                        AtlasSize* size) {
  Plan plan = make_plan(field, options);
  if (size) *size = plan.atlas.size;
  return std::move(plan.atlas.places);
}

AtlasSize predict_atlas(const Field& field, const AtlasOptions& options) {
  return make_plan(field, options).atlas.size;
}

BrickAtlas build_atlas(const Field& field, const AtlasOptions& options) {
  Plan plan = make_plan(field, options);
  check_limit(plan.atlas.size, field.name, options);
  fill(plan.source, field.name, plan.atlas);
  mark_octants(options, plan.atlas);
  return std::move(plan.atlas);
}

BrickAtlas build_beside(const Field& field, const BrickAtlas& layout, const AtlasOptions& options) {
  BrickAtlas result;
  result.channels = field.channels;
  result.texel = options.texel;
  result.domain = layout.domain;
  result.pages = layout.pages;
  result.places = layout.places;
  result.own_texels = true;
  const auto channels = std::uint64_t(field.channels);
  result.constants.assign(layout.constants.size() * channels, 0.0f);
  result.size = layout.size;
  result.size.constant_bytes = result.constants.size() * sizeof(float);
  result.size.texel_bytes = texel_bytes(result.places.size(), field.channels, options.texel);
  check_limit(result.size, field.name, options);
  fill(BrickSource(field), field.name, result);
  return result;
}

}  // namespace psivox
