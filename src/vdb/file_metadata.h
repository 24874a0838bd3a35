#pragma once

#include <openvdb/openvdb.h>

#include <istream>
#include <map>
#include <string>
#include <vector>

namespace psivox::vdb {

/// Metadata as text, by name.
using MetadataText = std::map<std::string, std::string>;

/// Reads metadata, each from its own bytes. OpenVDB would allocate what lengths in the file claim
/// and go on where a value ends by its type; here the stream throws if a length is beyond its end.
/// Metadata for delayed loading are left out; `delayed_load` gets their bytes.
void read_metadata(openvdb::MetaMap& metadata, std::istream& stream,
                   std::string* delayed_load = nullptr);

/// Moves the stream behind a string, which is a length and that many bytes.
void skip_string(std::istream& stream);

/// Throws if strings that OpenVDB is to read next are longer than the rest of the file. The stream
/// stays.
void check_strings(std::istream& stream, int count);

MetadataText text_of(const openvdb::MetaMap& metadata);

/// What VdbFile::z_up returns: evidence of a program whose Z axis is up. `grids` has the metadata
/// of each grid, `names` the grids' names.
std::string evidence_of_z_up(const MetadataText& file, const std::vector<std::string>& names,
                             const std::vector<MetadataText>& grids);

}  // namespace psivox::vdb
