#pragma once

// What goes between a GuardedReader and its process. Each struct is listed once, for both
// directions. A structured binding names all members, so that a new one does not compile until it
// is listed.

#include <cstdint>
#include <string>
#include <vector>

#include "message.h"
#include "psivox/active_values.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

enum class MessageKind : std::uint32_t {
  open,      ///< path; with the file's descriptor. The answer: FileFacts
  info,      ///< a grid, or "" for all, and whether values too. The answer: rows
  content,   ///< a grid. The answer: GridContent
  read,      ///< ReadRequest; with a descriptor of shared memory. The answer: FieldFacts
  leaves,    ///< LeavesRequest. The answer: LeavesAnswer
  progress,  ///< a fraction
  answer,
  failure,  ///< Failure
};

struct ReadRequest {
  std::string grid;
  ReadOptions options;
  bool holds_last = false;  ///< the values of the last field that was read are still used
};

/// Of the last field's leaves, which stay in the file.
struct LeavesRequest {
  std::vector<std::uint32_t> numbers;
  bool survey = false;
  bool active = false;  ///< values of inactive voxels become NaN
};

struct LeavesAnswer {
  std::string values;  ///< the bytes of floats
  ValueSurvey survey{};
};

/// An Error.
struct Failure {
  int code;
  std::string message;
};

/// A Field without leaves and tiles, which are in shared memory.
struct FieldFacts {
  Field field;
  std::uint64_t leaves = 0, tiles = 0;
  bool stored = false;       ///< the values of leaves stay in the file
  bool same_values = false;  ///< those of the last field; nothing was written
  std::string bytes{};       ///< instead of shared memory, where a limit of file sizes holds for it
  std::vector<TileValue> active_tiles{};  ///< if stored
};

template <typename T, typename Struct>
concept Is = std::is_same_v<std::remove_const_t<T>, Struct>;

template <typename Pack, Is<ValueStatistics> T>
void describe(Pack& pack, T& statistics) {
  auto& [least, greatest, mean, not_finite] = statistics;
  pack(least, greatest, mean, not_finite);
}

template <typename Pack, Is<GridInfo> T>
void describe(Pack& pack, T& info) {
  auto& [name, type, value_type, grid_class, channels, half, active, leaves, tiles, box, size,
         transform, map, background, values_read, values, lo, hi, metadata, problem] = info;
  pack(name, type, value_type, grid_class, channels, half, active, leaves, tiles, box, size,
       transform, map, background, values_read, values, lo, hi, metadata, problem);
}

template <typename Pack, Is<GridContent> T>
void describe(Pack& pack, T& content) {
  auto& [active_voxels, nothing] = content;
  pack(active_voxels, nothing);
}

template <typename Pack, Is<FileFacts> T>
void describe(Pack& pack, T& facts) {
  auto& [names, base_names, channels, value_types, classes, metadata, z_up] = facts;
  pack(names, base_names, channels, value_types, classes, metadata, z_up);
}

template <typename Pack, Is<ReadOptions> T>
void describe(Pack& pack, T& options) {
  auto& [role, strict, distances, empty, active, background, percentiles, memory, in_file,
         unsurveyed] = options;
  pack(role, strict, distances, empty, active, background, percentiles, memory, in_file,
       unsurveyed);
}

template <typename Pack, Is<ReadRequest> T>
void describe(Pack& pack, T& request) {
  auto& [grid, options, holds_last] = request;
  pack(grid, options, holds_last);
}

template <typename Pack, Is<BadValues> T>
void describe(Pack& pack, T& bad) {
  auto& [nan, positive, negative_infinite, negative, largest, least] = bad;
  pack(nan, positive, negative_infinite, negative, largest, least);
}

template <typename Pack, Is<Extent> T>
void describe(Pack& pack, T& extent) {
  auto& [min, max, infinite] = extent;
  pack(min, max, infinite);
}

template <typename Pack, Is<ValueSurvey> T>
void describe(Pack& pack, T& survey) {
  auto& [bad, largest, all, active, in_box] = survey;
  pack(bad, largest, all, active, in_box);
}

template <typename Pack, Is<LeavesRequest> T>
void describe(Pack& pack, T& request) {
  auto& [numbers, survey, active] = request;
  pack(numbers, survey, active);
}

template <typename Pack, Is<LeavesAnswer> T>
void describe(Pack& pack, T& answer) {
  auto& [values, survey] = answer;
  pack(values, survey);
}

template <typename Pack, Is<Failure> T>
void describe(Pack& pack, T& failure) {
  auto& [code, message] = failure;
  pack(code, message);
}

template <typename Pack, Is<TileValue> T>
void describe(Pack& pack, T& tile) {
  auto& [value, voxels] = tile;
  pack(value, voxels);
}

template <typename Pack, Is<FieldFacts> T>
void describe(Pack& pack, T& facts) {
  auto& [name, value_type, channels, of_vectors, box, transform, active, active_range, stored_range,
         percentiles, width, leaves, tiles, array, storage, reader, survey, replaced, notices] =
      facts.field;
  pack(name, value_type, channels, of_vectors, box, transform, active, active_range, stored_range,
       percentiles, width, survey, replaced, notices);
  pack(facts.leaves, facts.tiles, facts.stored, facts.same_values, facts.bytes, facts.active_tiles);
}

}  // namespace psivox::vdb
