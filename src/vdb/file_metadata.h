#pragma once

#include <openvdb/openvdb.h>

#include <map>
#include <string>
#include <vector>

namespace psivox::vdb {

/// Metadata as text, by name.
using MetadataText = std::map<std::string, std::string>;

MetadataText text_of(const openvdb::MetaMap& metadata);

/// What VdbFile::z_up returns: evidence of a program whose Z axis is up. `grids` has the metadata
/// of each grid, `names` the grids' names.
std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids);

}  // namespace psivox::vdb
