#pragma once

// What goes between a GuardedReader and its process.

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "guard/pack.h"
#include "guard/service.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

/// With the descriptor of the values that lie beside the file; before any other request.
struct DataRequest {
  using Answer = std::string;
  std::string grid{};  ///< always ""
  std::string path;
  std::int64_t size = 0;  ///< of that file [bytes]
};

struct FactsRequest {
  using Answer = FileFacts;
  std::string grid{};  ///< always ""
};

/// As Reader::info.
struct InfoRequest {
  using Answer = std::vector<GridInfo>;
  std::string grid;
  bool values = false;
};

struct ContentRequest {
  using Answer = GridContent;
  std::string grid;
};

/// With a descriptor of shared memory.
struct ReadRequest {
  using Answer = struct FieldFacts;
  std::string grid;
  ReadOptions options;
  bool holds_last = false;  ///< the values of the last field that was read are still used
};

/// Asks for values of the last field's leaves, with a descriptor of shared memory. They come in
/// pieces.
struct ValuesRequest {
  using Answer = std::string;  ///< as FieldFacts::bytes
  std::string grid;            ///< for messages
  std::uint64_t first = 0, count = 0;
};

struct LeavesAnswer {
  std::string values;  ///< the bytes of floats
  ValueSurvey survey{};
};

/// Asks for leaves of the last field, whose values stay in the file.
struct LeavesRequest {
  using Answer = LeavesAnswer;
  std::string grid{};  ///< always ""
  std::vector<std::uint32_t> numbers;
  LeafRead what = LeafRead::data;
};

using Request = std::variant<DataRequest, FactsRequest, InfoRequest, ContentRequest, ReadRequest,
                             ValuesRequest, LeavesRequest>;

/// A Field without leaves and tiles, whose places are in shared memory. Values are asked for.
struct FieldFacts {
  Field field;
  std::uint64_t leaves = 0, tiles = 0;
  bool same_values = false;  ///< the last field's values; nothing was written
  std::string bytes{};       ///< instead of shared memory, where a limit of file sizes holds for it
  std::vector<TileValue> active_tiles{};  ///< if stored

  /// Whether the values of leaves stay in the file.
  bool stored() const { return field.survey.has_value(); }
};

/// Empty memory that two processes can map. Throws Error(failure).
guard::Descriptor shared_memory();

/// Writes the origins of the field's leaves, and its tiles, to shared memory, and keeps no access
/// to it; or to FieldFacts::bytes if the system does not let it be that large. Throws
/// std::bad_alloc.
void write_places(const Field& field, int memory, FieldFacts& facts);
/// Writes values in the same way. Returns those that the system did not let it write.
std::string write_values(const Field& field, const ValuesRequest& request, int memory);

/// Sets leaves and tiles as write_places has written them. Throws std::runtime_error if the memory
/// does not have what the facts say, or another process can still write to it.
void take_places(FieldFacts& facts, int memory);

/// Answers by write_values.
using AskValues = std::function<std::string(const ValuesRequest& request, int memory)>;
/// Sets the values of all leaves, and storage. From then on nobody can change them. Nothing is
/// copied. Throws as take_places does.
void take_values(Field& field, const AskValues& ask);

/// Throws std::runtime_error if the field cannot have been read under this role: its values or
/// places break the rules of field.h. A process that a file has taken over could send such a field.
void check_field(const FieldFacts& facts, GridRole role);

/// Whether values can have been found like this.
bool is_possible(const ValueSurvey& survey);

PSIVOX_PACK(DataRequest, grid, path, size)
PSIVOX_PACK(FactsRequest, grid)
PSIVOX_PACK(InfoRequest, grid, values)
PSIVOX_PACK(ContentRequest, grid)
PSIVOX_PACK(GridFacts, name, base_name, channels, value_type, grid_class, place)
PSIVOX_PACK(FileFacts, grids, metadata, z_up, lost, value_bytes)
PSIVOX_PACK(ReadRequest, grid, options, holds_last)
PSIVOX_PACK(ValuesRequest, grid, first, count)
PSIVOX_PACK(LeavesRequest, grid, numbers, what)
PSIVOX_PACK(LeavesAnswer, values, survey)

inline void describe(guard::Codec& codec, FieldFacts& facts) {
  auto& [name, value_type, channels, of_vectors, box, margin, absent, array_box, transform, active,
         active_range, stored_range, percentiles, width, scale, leaves, tiles, array, storage,
         origin, reader, survey, replaced, notices] = facts.field;
  codec(name, value_type, channels, of_vectors, box, margin, absent, transform, active,
        active_range, stored_range, percentiles, width, survey, replaced, notices);
  codec(facts.leaves, facts.tiles, facts.same_values, facts.bytes, facts.active_tiles);
}

}  // namespace psivox::vdb

// A Codec finds these in the namespace of their structs.
namespace psivox {

PSIVOX_PACK(ValueStatistics, least, greatest, mean, not_finite, filled, fill)
PSIVOX_PACK(GridInfo, name, type, value_type, grid_class, channels, half, active, leaves, tiles,
            box, size, transform, map, background, values_read, values, lo, hi, metadata, problem)
PSIVOX_PACK(GridContent, active_voxels, nothing)
PSIVOX_PACK(GridPlace, voxels, known, world_min, world_max, voxel_size, domain)
PSIVOX_PACK(ReadOptions, role, strict, distances, absent, fill, fill_value, empty, active,
            background, percentiles, memory, in_file)
PSIVOX_PACK(Fill, low, high, given)
PSIVOX_PACK(BadValues, nan, positive, negative_infinite, negative, filled, clamped, largest, least,
            fill, absent)
PSIVOX_PACK(Extent, min, max, infinite)
PSIVOX_PACK(ValueSurvey, bad, largest, all, active, in_box)
PSIVOX_PACK(TileValue, value, voxels)
PSIVOX_PACK(Box, min, max)

}  // namespace psivox
