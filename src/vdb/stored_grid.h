#pragma once

#include <memory>
#include <optional>

#include "archive.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// The field of a grid whose values stay in the file, found in one pass over it. Unset if the
/// values take no more than ReadOptions::memory, or if the grid must be converted whole.
/// Throws as VdbFile::read does.
std::optional<Field> stored_field(Archive& archive, const GridEntry& entry,
                                  const std::shared_ptr<FileBlocks>& file,
                                  const ReadOptions& options);

}  // namespace psivox::vdb
