// Grids that NanoVDB's conversion of an OpenVDB grid does not make by itself.

#include "vdb_nano_made_file.h"

#if __has_include(<nanovdb/tools/CreateNanoGrid.h>)
#include <nanovdb/tools/CreateNanoGrid.h>
#include <nanovdb/tools/GridBuilder.h>
#define PSIVOX_NANO_TOOLS
#else
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#endif

#include "scratch.h"
#include "vdb_test_util.h"

namespace psivox {

template <typename BuildT>
std::filesystem::path test::quantised_nano(const openvdb::FloatGrid& grid,
                                           const std::string& name) {
  const auto path = scratch_dir() / name;
#ifdef PSIVOX_NANO_TOOLS
  const auto handle = nanovdb::tools::createNanoGrid<openvdb::FloatGrid, BuildT>(grid);
#else
  const auto handle = nanovdb::OpenToNanoVDB<float, BuildT>()(grid);
#endif
  nanovdb::io::writeGrid(path.string(), handle, nanovdb::io::Codec::BLOSC);
  return path;
}
template std::filesystem::path test::quantised_nano<nanovdb::Fp4>(const openvdb::FloatGrid&,
                                                                  const std::string&);
template std::filesystem::path test::quantised_nano<nanovdb::Fp8>(const openvdb::FloatGrid&,
                                                                  const std::string&);
template std::filesystem::path test::quantised_nano<nanovdb::Fp16>(const openvdb::FloatGrid&,
                                                                   const std::string&);
template std::filesystem::path test::quantised_nano<nanovdb::FpN>(const openvdb::FloatGrid&,
                                                                  const std::string&);

template <typename ValueT>
std::filesystem::path test::built_nano(const std::string& type, ValueT value) {
  const auto path = scratch_dir() / (type + ".nvdb");
#ifdef PSIVOX_NANO_TOOLS
  nanovdb::tools::build::Grid<ValueT> builder(ValueT(0), type);
  const auto handle = [&] { return nanovdb::tools::createNanoGrid(builder); };
#else
  nanovdb::GridBuilder<ValueT> builder(ValueT(0));
  const auto handle = [&] { return builder.getHandle(1.0, nanovdb::Vec3d(0), type); };
#endif
  builder.getAccessor().setValue({1, 2, 3}, value);
  const auto made = handle();
  if constexpr (std::is_same_v<ValueT, std::uint8_t>)  // NanoVDB 32.4 writes no file of it
    return write_bytes(path.filename(),
                       std::string(reinterpret_cast<const char*>(made.data()), made.size()));
  nanovdb::io::writeGrid(path.string(), made);
  return path;
}
template std::filesystem::path test::built_nano(const std::string&, nanovdb::Vec3d);
template std::filesystem::path test::built_nano(const std::string&, std::int16_t);
template std::filesystem::path test::built_nano(const std::string&, std::uint8_t);
template std::filesystem::path test::built_nano(const std::string&, std::uint32_t);

}  // namespace psivox
