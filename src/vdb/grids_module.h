#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "grid_file.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "topology.h"

// The module `reader`: files of grids, which OpenVDB and NanoVDB read. It is no part of libpsivox,
// because linking OpenVDB takes longer than reading a small file. A guarded process has it from the
// server that it was forked from.

namespace psivox::vdb {

/// The grid whose transform is linear, and which is no level set.
struct ConvertedGrid {
  Topology topology;
  std::vector<float*> values;  ///< the 512 * channels of each leaf, vectors interleaved
  Storage storage;             ///< keeps `values` alive
  glm::dmat4 world_from_index{1};
  double half_width = 0;     ///< as Field::half_width
  bool wrong_class = false;  ///< a fog of the class of level sets
  std::vector<std::string> notices;
};

/// Where a frustum's voxels are in the world.
struct FrustumPlace {
  glm::dvec3 voxel_size, world_min, world_max;
};

/// How files of grids begin.
inline constexpr std::string_view vdb_magic(" BDV\0\0\0\0", 8), nano_magic = "NanoVDB";

/// Whether a file begins with these bytes.
bool begins(FileBlocks& file, std::string_view magic);
/// Whether it is for the module, by its first bytes.
bool has_grids(FileBlocks& file);

struct GridsModule {
  const char* (*version)();  ///< of OpenVDB

  /// Opens a .vdb or a .nvdb. Throws Error(input) if it is damaged before its first grid, or of a
  /// version that is not read.
  std::unique_ptr<GridFile> (*open)(std::shared_ptr<FileBlocks> file, Progress progress);

  /// Converts a level set to fog or, if the options say so, to distances; a frustum to cubic
  /// voxels. Throws std::runtime_error with the rest of a sentence.
  ConvertedGrid (*convert)(FileGrid& grid, const ReadOptions& options);

  /// `frustum` is no linear transform.
  FrustumPlace (*place)(const Transform& frustum, const Box& active_box);
};

/// The module's one symbol.
inline constexpr const char* grids_symbol = "psivox_reader";
using GetGridsModule = const GridsModule* (*)();

/// The module, which is loaded now if it was not before. Throws Error(failure) if it cannot be.
const GridsModule& grids_module();

}  // namespace psivox::vdb
