#pragma once

#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <istream>
#include <memory>
#include <span>

#include "file_blocks.h"
#include "value_block.h"

namespace psivox::vdb {

using LeafMask = openvdb::util::NodeMask<3>;

/// Where a leaf's values are in the file [bytes].
struct LeafPlace {
  std::int64_t begin, end;
};

/// Decodes a grid's leaves, each from its place in the file, without the grid's tree.
class LeafDecoder {
 public:
  /// `empty` has the grid's type and background. The settings are the stream's from which its
  /// topology was read. The file's format must be 222 or later. `vacuum`: inactive voxels of the
  /// background's value become 0.
  LeafDecoder(std::shared_ptr<FileBlocks> file, openvdb::GridBase::Ptr empty,
              const openvdb::io::StreamMetadata& settings, bool vacuum = false);

  int channels() const { return channels_; }
  const ValueCoding& coding() const { return coding_; }
  /// Size of a value in the grid's own type.
  std::int64_t value_bytes() const;

  /// Moves the stream from the beginning of a leaf's values behind their end. Throws if a length is
  /// impossible.
  void skip(std::istream& stream) const;
  /// The same for a leaf that has so many active voxels, whose mask it does not read.
  void skip(std::istream& stream, int active) const;

  /// Decodes the leaves at these places, in all threads: 512 * channels floats each, and their
  /// active voxels unless `active` is null. Reads large runs, which the file keeps, or nothing but
  /// the leaves. Throws if a leaf's lengths are not those of its place.
  void decode(std::span<const LeafPlace> places, bool in_runs, float* values,
              LeafMask* active) const;

 private:
  template <typename LeafT>
  void decode_some(std::span<const LeafPlace> places, bool in_runs, float* values,
                   LeafMask* active) const;

  std::shared_ptr<FileBlocks> file_;
  openvdb::GridBase::Ptr empty_;
  openvdb::io::StreamMetadata settings_;
  ValueCoding coding_;
  int channels_;
  bool vacuum_;
};

}  // namespace psivox::vdb
