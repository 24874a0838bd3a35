#pragma once

#if __has_include(<nanovdb/io/IO.h>)
#include <nanovdb/io/IO.h>
#else
#include <nanovdb/util/IO.h>
#endif
#include <openvdb/openvdb.h>

#include <filesystem>
#include <string>
#include <vector>

namespace psivox::test {

/// Writes grids as a .nvdb in the scratch folder, as NanoVDB's own tool does.
std::filesystem::path written_nano(const std::vector<openvdb::GridBase::Ptr>& grids,
                                   nanovdb::io::Codec codec, const std::string& name = "made.nvdb");

}  // namespace psivox::test
