#pragma once

#include <memory>

#include "archive.h"
#include "file_blocks.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// What a picture could be made of. It reads the topology, and leaves up to the first that has an
/// active value other than 0. Throws Error(input).
GridContent content_of(Archive& archive, const GridEntry& entry,
                       const std::shared_ptr<FileBlocks>& file);

/// Of a grid of so many active voxels; `has_value`: some of them are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

}  // namespace psivox::vdb
