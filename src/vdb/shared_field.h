#pragma once

#include <cstdint>

#include "psivox/field.h"
#include "socket.h"

namespace psivox::vdb {

/// Empty memory that two processes can map. Throws Error(failure).
Descriptor shared_memory();

/// Writes the field's leaves and tiles to shared memory, and keeps no access to it; or to
/// FieldFacts::bytes if the system does not let it be that large. Values that stay in a file are
/// left out. Throws std::bad_alloc.
void write_shared(const Field& field, int memory, FieldFacts& facts);

/// Sets what write_shared has written, and storage. From then on nobody can change the memory.
/// Nothing is copied but origins and tiles. Throws std::runtime_error if the memory does not have
/// what the facts say, or another process can still write to it.
void take_shared(FieldFacts& facts, int memory);

}  // namespace psivox::vdb
