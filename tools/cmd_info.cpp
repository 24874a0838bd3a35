// psivox info IN.vdb: tells what the file contains, and what psivox would make of it.

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/regions.h"
#include "base/text.h"
#include "command_line.h"
#include "psivox/file_report.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

/// What one of several processes would hold of a volume (psivox render under mpirun).
Json json_of(const Field& field, const Region& region) {
  Json box = nullptr;
  std::uint64_t leaves = 0;  // to read; neighbours read some of them too
  const auto channels = std::uint64_t(field.channels);
  if (region.count > 0) {
    const Box voxels = voxels_of(region.bricks);
    const auto [min, max] = common({voxels.min, voxels.max + 1}, field.domain());
    box = {{"min", {min.x, min.y, min.z}}, {"max", {max.x, max.y, max.z}}};
    // as part_of_field reads them: with the voxels on the far faces
    const Box read{voxels.min, voxels.max + 8};
    for (const Leaf& leaf : field.leaves) leaves += read.contains(leaf.origin);
  }
  // the atlas: at most, in float32, on host and GPU
  return {{"voxels", box},
          {"bricks", region.count},
          {"leaves", leaves},
          {"value_bytes", leaves * 512 * sizeof(float) * channels},
          {"atlas_bytes", 2 * region.count * brick_texels * sizeof(float) * channels}};
}

/// The bricks of the largest region, as a multiple of their mean.
double imbalance(const std::vector<Region>& regions) {
  double most = 0, sum = 0;
  for (const Region& region : regions) {
    most = std::max(most, double(region.count));
    sum += double(region.count);
  }
  return sum > 0 ? most * double(regions.size()) / sum : 1;
}

/// Prints how the grid that `render` draws would be split. Throws Error(input).
void print_regions(const std::string& path, int count, bool as_json) {
  const VolumeFile file(path);
  const Field field =
      file.read(file.default_grid(), {.role = GridRole::data, .in_file = true, .survey = false});
  const std::vector<Region> regions =
      Regions::in_parts(leaf_bricks(field), std::size_t(count)).all();
  Json report = {{"file", path}, {"grid", field.name}, {"imbalance", imbalance(regions)}};
  for (const Region& region : regions) report["regions"].push_back(json_of(field, region));
  if (as_json) {
    std::cout << report.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    return;
  }
  std::cout << formatted("grid %s in %zu regions; the largest has %.2f times the mean\n",
                         in_quotes(field.name).c_str(), regions.size(), imbalance(regions))
            << "region    bricks    leaves  values to read  atlas, host + GPU  voxels\n";
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Json& row = report["regions"][i];
    const Json& box = row["voxels"];
    std::cout << formatted("%6zu  %8zu  %8s  %14s  %17s  ", i, regions[i].count,
                           row["leaves"].dump().c_str(), mebibytes(row["value_bytes"]).c_str(),
                           mebibytes(row["atlas_bytes"]).c_str())
              << (box.is_null() ? "none" : box["min"].dump() + " to " + box["max"].dump()) << '\n';
  }
}

}  // namespace

void info_command(Arguments arguments) {
  std::string path;
  bool as_json = false, topology = false;
  std::optional<int> regions;
  CommandLine line("info",
                   "Tells what a file (.vdb, NIfTI, NRRD) contains: grids, values, boxes, and what "
                   "auto chooses.",
                   {}, {"smoke.vdb", "smoke.vdb --json", "smoke.vdb --regions 4"});
  line.add_value("IN.vdb", path, "", "file to describe")->required();
  line.add_flag("--topology", topology,
                "read no values of voxels: no ranges, sizes of atlases, nor what auto chooses");
  line.add_flag("--json", as_json, "print JSON");
  line.add_value("--regions", regions, "K",
                 "print instead how K processes of MPI would split the volume: bricks, leaves and "
                 "memory of each")
      ->check(number_in<int>({.min = 1, .max = 100000}));
  line.add_trust();
  if (!line.read(arguments)) return;
  if (regions) return print_regions(path, *regions, as_json);
  const FileReport report = report_of(path, !topology);
  std::cout << (as_json ? report.json() : report.text());
}

}  // namespace psivox
