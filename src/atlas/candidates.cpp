#include "atlas/brick_source.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "field/block_map.h"
#include "field/index_space.h"

namespace psivox::atlas {
namespace {

/// Calls take(values, count) for the rows of a brick's values, of one value once, as long as it
/// returns true. Returns what it returned last.
template <typename Take>
bool all_rows(const BrickSource::Neighbours& from, int channels, const Take& take) {
  std::array<float, 24> room;
  for (unsigned i = 0; i < 8; ++i) {
    const FieldIndex::Block& block = from[i];
    const int most = block.is_constant() ? 1 : 8;
    const int nx = i & 4 ? 1 : most, ny = i & 2 ? 1 : most, nz = i & 1 ? 1 : most;
    for (int x = 0; x < nx; ++x)
      for (int y = 0; y < ny; ++y)
        if (!take(block.values.row(x, y, nz, channels, room.data()), nz)) return false;
  }
  return true;
}

/// Finds a brick's kind from its blocks, without copying the values.
void find_kind(const BrickSource& source, const BrickSource::Neighbours& from, Candidate& candidate,
               bool keeps_absent = false) {
  const int channels = source.channels();
  glm::vec3 first{0};
  for (int c = 0; c < channels; ++c) first[c] = from[0].values.channel(c);
  candidate.value = first;
  const bool absent = std::isnan(first.x);
  const bool equal = all_rows(from, channels, [&](const float* values, int count) {
    for (int i = 0; i < count * channels; ++i)
      if (absent ? !std::isnan(values[i]) : values[i] != first[i % channels]) return false;
    return true;
  });
  candidate.kind = !equal                  ? EntryKind::brick
                   : absent                ? (keeps_absent ? EntryKind::constant : EntryKind::empty)
                   : first == glm::vec3(0) ? EntryKind::empty
                                           : EntryKind::constant;
}

/// Finds a brick's kind by options.visible, under which constants of 0 may be visible.
void find_visible_kind(const BrickSource& source, const BrickSource* companion,
                       const AtlasOptions& options, Candidate& candidate) {
  const BrickSource::Neighbours from = source.neighbours(candidate.bricks.min);
  find_kind(source, from, candidate);
  const ValueRange own = value_range(from, source.channels());
  const ValueRange companions =
      companion ? value_range(companion->neighbours(candidate.bricks.min), 1) : ValueRange{};
  if (!options.sees(own, companions))
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

/// A bit for each face of a brick at which one of its cells is visible.
std::uint8_t visible_faces(const BrickSource& source, const AtlasOptions& options,
                           const glm::ivec3& brick) {
  std::array<float, brick_texels> values;
  source.gather(source.neighbours(brick), values.data());
  unsigned faces = 0;
  for (int face = 0; face < 6; ++face)
    if (options.sees(face_range(values.data(), face >> 1, face & 1))) faces |= 1u << face;
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
  const auto is_stored = [&](const glm::ivec3& brick) {
    return std::ranges::any_of(FieldIndex::widths, [&](int width) {
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
      for_points(beside(candidates[i].bricks, face), [&](const glm::ivec3& brick) {
        const auto next = std::int32_t(candidates.size());
        if (is_stored(brick) || added.insert(brick, next) != next) return;
        Candidate candidate{{brick, brick}};
        find_kind(source, source.neighbours(brick), candidate);
        if (candidate.kind == EntryKind::empty) candidate.kind = EntryKind::constant;
        candidates.push_back(candidate);
      });
    }
}

}  // namespace

ValueRange value_range(const BrickSource::Neighbours& from, int channels) {
  ValueRange range{HUGE_VALF, -HUGE_VALF};
  all_rows(from, channels, [&](const float* values, int count) {
    for (int i = 0; i < count * channels; i += channels)
      range = {std::min(range.min, values[i]), std::max(range.max, values[i])};
    return true;
  });
  return range;
}

std::vector<Candidate> find_candidates(const BrickSource& source, const AtlasOptions& options,
                                       const Box& region, bool keep_all) {
  std::optional<BrickSource> companion;
  if (options.companion) companion.emplace(*options.companion);
  std::vector<Candidate> candidates;
  for (const Piece& piece : source.candidates())
    if (const Box bricks = piece.bricks(region); !bricks.empty()) candidates.push_back({bricks});
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, candidates.size(), 256), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          if (options.visible && !keep_all)
            find_visible_kind(source, companion ? &*companion : nullptr, options, candidates[i]);
          else
            find_kind(source, source.neighbours(candidates[i].bricks.min), candidates[i],
                      options.keeps_absent || keep_all);
        }
      });
  if (options.with_margin) add_margin(source, options, region, candidates);
  return candidates;
}

}  // namespace psivox::atlas
