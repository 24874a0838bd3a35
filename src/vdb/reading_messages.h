#pragma once

// What goes between a GuardedReader and its process.

#include <vector>

#include "guard/channel.h"
#include "guard/pack.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "reader.h"

namespace psivox::vdb {

/// Asks for one function of a Reader, with its arguments.
struct Request {
  enum class What { facts, info, content, leaves, data };  ///< data: a field
  What what = What::facts;
  LeavesWish of{};      ///< grid, and what else `what` takes
  bool values = false;  ///< as Reader::info
};

/// Copies the values of a field's leaves to shared memory, in blocks of the same number of leaves.
/// Frees the field's own blocks as they are copied. Throws std::bad_alloc.
std::vector<guard::Descriptor> shared_values(Field&& field);
/// Sets the values of all leaves, and storage, without a copy. Throws std::runtime_error if the
/// blocks do not have what the leaves need.
void take_values(Field& field, const std::vector<guard::SealedMemory>& blocks);

/// Throws std::runtime_error if the field cannot have been read like this: its values or places
/// break the rules of field.h. A process that a file has taken over could send such a field.
void check_field(const Field& field, const ReadOptions& options);

PSIVOX_PACK(LeavesWish, grid, options, largest, numbers)
PSIVOX_PACK(Request, what, of, values)
PSIVOX_PACK(GridFacts, name, base_name, channels, value_type, grid_class, place)
PSIVOX_PACK(FileFacts, grids, metadata, z_up, lost, value_bytes)

}  // namespace psivox::vdb

// A Codec finds these in the namespace of their structs.
namespace psivox {

PSIVOX_PACK(ValueStatistics, least, greatest, mean, not_finite, filled, fill)
PSIVOX_PACK(GridInfo, name, type, value_type, grid_class, channels, half, active, leaves, tiles,
            box, size, transform, map, background, values_read, values, lo, hi, metadata, problem)
PSIVOX_PACK(GridContent, active_voxels, nothing)
PSIVOX_PACK(GridPlace, voxels, known, world_min, world_max, voxel_size, domain)
PSIVOX_PACK(ReadOptions, role, strict, distances, absent, fill, fill_value, empty, active,
            background, percentiles, memory, in_file, survey)
PSIVOX_PACK(Fill, low, high, given)
PSIVOX_PACK(BadValues, nan, positive, negative_infinite, negative, filled, clamped, largest, least,
            least_fill, fill, absent)
PSIVOX_PACK(Tile, origin, width, value)
PSIVOX_PACK(Box, min, max)

inline void describe(guard::Codec& codec, ValueScale& scale) {
  using Kind = ValueScale::Kind;
  bool scaled = !scale.is_linear(), log = scale.kind == Kind::log;
  codec(scaled, log, scale.unit);
  scale.kind = !scaled ? Kind::linear : log ? Kind::log : Kind::symlog;
}

inline void describe(guard::Codec& codec, FieldHead& head) {
  auto& [name, value_type, channels, of_vectors, box, margin, absent, array_box, transform, active,
         active_range, stored_range, percentiles, width, scale, replaced, notices] = head;
  codec(name, value_type, channels, of_vectors, box, margin, absent, transform, active,
        active_range, stored_range, percentiles, width, scale, replaced, notices);
}

/// Without values of leaves.
inline void describe(guard::Codec& codec, Field& field) {
  std::vector<glm::ivec3> origins;
  for (const Leaf& leaf : field.leaves) origins.push_back(leaf.origin);
  codec(static_cast<FieldHead&>(field), origins, field.tiles);
  field.leaves.resize(origins.size());
  for (std::size_t n = 0; n < origins.size(); ++n) field.leaves[n].origin = origins[n];
}

}  // namespace psivox
