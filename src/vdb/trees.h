#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/file_blocks.h"
#include "grid_head.h"
#include "psivox/field.h"
#include "psivox/vdb.h"
#include "topology.h"

// What OpenVDB itself does. It is the module `trees`, because to load OpenVDB takes longer than to
// read a small file: most files need nothing of it.

namespace psivox::vdb {

/// What a field takes from a grid's voxels.
struct Voxels {
  std::vector<float*> leaves;    ///< the 512 * channels values of each leaf, vectors interleaved
  std::vector<LeafMask> active;  ///< of each leaf
  std::vector<TilePart> tiles;   ///< as Topology::tiles
  std::shared_ptr<const void> storage;  ///< keeps `leaves` alive
};

/// A grid that is to be converted, and how its leaves are read.
struct TreeSource {
  const GridHead& head;
  const Topology& topology;
  std::function<void(const TakeLeaf& take)> each_leaf;
};

/// The grid whose transform is linear, and which is no level set.
struct ConvertedGrid {
  Voxels voxels;
  GridSummary summary;
  std::vector<glm::ivec3> origins;  ///< of leaves
  glm::dmat4 world_from_index{1};
  double half_width = 0;     ///< as Field::half_width
  bool wrong_class = false;  ///< a fog of the class of level sets
  std::vector<std::string> notices;
};

/// Where a frustum's voxels are in the world.
struct FrustumPlace {
  glm::dvec3 voxel_size, world_min, world_max;
};

/// A grid of a file before format 222.
struct OldGrid {
  std::string type;         ///< OpenVDB's
  bool half;                ///< as GridEntry
  std::int64_t begin, end;  ///< in the file [bytes]
};
/// The file in today's format that has it alone.
struct RewrittenGrid {
  std::string bytes;
  std::int64_t end;  ///< of the old grid in its file [bytes]
};

struct Trees {
  const char* (*version)();  ///< of OpenVDB

  /// Converts a level set to fog or, if the options say so, to distances; a frustum to cubic
  /// voxels. Throws std::runtime_error with the rest of a sentence.
  ConvertedGrid (*convert)(const TreeSource& grid, const ReadOptions& options);

  /// `bytes` are Transform::frustum. Throws if the transform is damaged.
  FrustumPlace (*place)(const std::string& bytes, const Box& active_box);

  /// With the parent's tree if it is not null. Throws if the file is damaged.
  RewrittenGrid (*rewritten)(FileBlocks& file, const OldGrid& grid, const OldGrid* parent);
};

/// The module's one symbol.
inline constexpr const char* trees_symbol = "psivox_trees";
using GetTrees = const Trees* (*)();

/// The module, which is loaded now if it was not before. Throws Error(failure) if it cannot be, and
/// TreesNeeded in a process that may not load it.
const Trees& trees();

/// A guarded process needs the module and cannot load it. It is to be started again.
struct TreesNeeded {};
/// From now on trees() throws TreesNeeded unless the module is there or could not be loaded.
void load_no_trees();

}  // namespace psivox::vdb
