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

/// Writes a grid with values of BuildT: Fp4, Fp8, Fp16 or FpN.
template <typename BuildT>
std::filesystem::path quantised_nano(const openvdb::FloatGrid& grid, const std::string& name);

/// Writes a grid of one voxel, whose type OpenVDB lacks: Vec3d, int16 or uint32, or uint8 as a bare
/// grid. The type's name is that of grid and file.
template <typename ValueT>
std::filesystem::path built_nano(const std::string& type, ValueT value);

}  // namespace psivox::test
