#pragma once

#include "psivox/vdb.h"
#include "reading_messages.h"

namespace psivox::vdb {

/// Throws std::runtime_error if the field cannot have been read under this role: its values or
/// places break the rules of field.h. A process that a file has taken over could send such a field.
void check_field(const FieldFacts& facts, GridRole role);

/// Whether values can have been found like this.
bool is_possible(const ValueSurvey& survey);

}  // namespace psivox::vdb
