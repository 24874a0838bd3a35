#pragma once

#include <memory>

#include "grid_file.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "trees.h"

// What VdbFile asks of a grid of a file: a field, a row of `info`, or whether it holds something.

namespace psivox::vdb {

/// A field, and its voxels unless their values stay in the file.
struct ReadGrid {
  Field field;
  std::shared_ptr<const Voxels> voxels{};
};

/// Reads a grid, as VdbFile::read does, which says what is thrown.
ReadGrid read_grid(GridFile& file, const GridEntry& entry, const ReadOptions& options);

/// Finds in a field's voxels, none of which is bad, what the options ask for.
void look_again(Field& field, const Voxels& voxels, const ReadOptions& options);

}  // namespace psivox::vdb
