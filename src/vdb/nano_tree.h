#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "decoded_leaf.h"
#include "topology.h"

// NanoVDB keeps a grid as one block of bytes whose nodes point to each other by offsets. The block
// comes from a file that can hold anything, so each offset and each size is checked here before it
// is followed, and no code of NanoVDB that follows them is used.

namespace psivox::vdb {

/// How NanoVDB stores a grid.
struct NanoType {
  std::string name;         ///< NanoVDB's: float, Fp8, ...
  std::string grid_type{};  ///< OpenVDB's type with these values; empty if it cannot be rendered
  bool quantised = false;
};

/// Grids have numbers for type and class, nanovdb::GridType and nanovdb::GridClass.
NanoType nano_type(std::uint32_t type, std::uint32_t grid_class);
openvdb::GridClass nano_class(std::uint32_t grid_class);

/// The major version of NanoVDB by which psivox is compiled, the only one whose files it reads.
std::uint32_t nano_major_version();

/// The nodes of a grid, in its bytes.
class NanoTree {
 public:
  virtual ~NanoTree() = default;

  /// Walks the nodes, in OpenVDB's order. The grid, which is empty and has the tree's type, gets
  /// the tree's background. Throws openvdb::IoError if a node is not within the bytes.
  virtual Topology topology(openvdb::GridBase& empty, const TopologyWish& wish) = 0;

  /// Decodes the n-th leaf of the topology. Inactive voxels that have the background's value become
  /// `fill`, if it is set. Several threads may call it. Throws openvdb::IoError.
  virtual void decode(std::size_t n, const std::optional<double>& fill,
                      const TakeLeaf& take) const = 0;
};

/// A grid's bytes, of which the first is aligned to 32 bytes. They must live as long as the tree.
using NanoBytes = std::span<const char>;

/// A grid of the file's directory without its tree: name, class, transform. Throws openvdb::IoError
/// if the bytes are not a grid of this type and class.
openvdb::GridBase::Ptr nano_head(NanoBytes bytes, std::uint32_t type, std::uint32_t grid_class);

/// The tree of such a grid, whose type can be rendered.
std::unique_ptr<NanoTree> nano_tree(NanoBytes bytes, std::uint32_t type, std::uint32_t grid_class);

}  // namespace psivox::vdb
