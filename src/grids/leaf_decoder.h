#pragma once

#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <istream>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/file_blocks.h"
#include "topology.h"
#include "value_block.h"

namespace psivox::vdb {

/// Where a leaf's values are in the file [bytes].
struct LeafPlace {
  std::int64_t begin, end;
};

/// Decodes a grid's leaves, each from its place in the file, without the grid's tree.
class LeafDecoder {
 public:
  /// `head` has the grid's type and background. The stream is the one from which its topology was
  /// read. The file's format must be 222 or later. Inactive voxels that have the background's value
  /// become `fill`, if it is set.
  LeafDecoder(std::shared_ptr<FileBlocks> file, openvdb::GridBase::ConstPtr head,
              std::istream& stream, std::optional<double> fill = {});

  int channels() const { return channels_; }

  /// Moves the stream from the beginning of a leaf's values behind their end. Throws if a length is
  /// impossible.
  void skip(std::istream& stream) const;
  /// Skips a leaf that has so many active voxels without reading its mask.
  void skip(std::istream& stream, int active) const;

  /// How many bytes each leaf's values take in the file, as the grid's metadata for delayed loading
  /// say: their kinds, and their compressed lengths. Empty if those metadata do not have all of it,
  /// or cannot be right. `decode` checks them, for the file can claim anything.
  std::vector<std::int64_t> lengths(std::string_view metadata, const Topology& topology) const;

  /// Decodes the leaves at these places, in all threads. Reads large runs, which the file keeps, or
  /// nothing but the leaves. Throws if a leaf is longer or shorter than its place.
  void decode(std::span<const LeafPlace> places, bool in_runs, const TakeLeaf& take) const;

 private:
  template <typename LeafT>
  void decode_some(std::span<const LeafPlace> places, std::size_t first, bool in_runs,
                   const TakeLeaf& take) const;

  std::shared_ptr<FileBlocks> file_;
  openvdb::GridBase::ConstPtr head_;
  openvdb::io::StreamMetadata settings_;
  ValueCoding coding_;
  int channels_;
  std::optional<double> fill_;
};

}  // namespace psivox::vdb
