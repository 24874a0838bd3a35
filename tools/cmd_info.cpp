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

/// What one of several processes would hold of a volume (psivox render under mpirun).
struct RegionRow {
  Region region;
  Box voxels;                ///< of the domain; empty if the region has none
  std::uint64_t leaves = 0;  ///< to read; neighbours read some of them too
  std::uint64_t values = 0;  ///< of these leaves [bytes]
  std::uint64_t atlas = 0;   ///< at most, in float32, on host and GPU [bytes]
};

/// The bricks of the largest region, as a multiple of their mean.
double imbalance(const std::vector<RegionRow>& rows) {
  double most = 0, sum = 0;
  for (const RegionRow& row : rows) {
    most = std::max(most, double(row.region.count));
    sum += double(row.region.count);
  }
  return sum > 0 ? most * double(rows.size()) / sum : 1;
}

std::string voxel_text(const glm::ivec3& v) { return formatted("%d,%d,%d", v.x, v.y, v.z); }

RegionRow row_of(const Field& field, const Region& region) {
  RegionRow row{region, {}, 0, 0, 0};
  if (region.count == 0) return row;
  const Box voxels = voxels_of(region.bricks);
  row.voxels = common({voxels.min, voxels.max + 1}, field.domain());
  // as part_of_field reads them: with the voxels on the far faces
  const Box read{voxels.min, voxels.max + 8};
  for (const Leaf& leaf : field.leaves) row.leaves += read.contains(leaf.origin);
  row.values = row.leaves * 512 * sizeof(float) * std::uint64_t(field.channels);
  row.atlas = 2 * region.count * brick_texels * sizeof(float) * std::uint64_t(field.channels);
  return row;
}

std::string json_of(const std::string& path, const std::string& grid,
                    const std::vector<RegionRow>& rows) {
  using Json = nlohmann::ordered_json;
  Json regions = Json::array();
  for (const RegionRow& row : rows) {
    Json box = nullptr;
    if (!row.voxels.empty()) {
      const auto& [min, max] = row.voxels;
      box = {{"min", {min.x, min.y, min.z}}, {"max", {max.x, max.y, max.z}}};
    }
    regions.push_back({{"voxels", box},
                       {"bricks", row.region.count},
                       {"leaves", row.leaves},
                       {"value_bytes", row.values},
                       {"atlas_bytes", row.atlas}});
  }
  const Json report = {
      {"file", path}, {"grid", grid}, {"imbalance", imbalance(rows)}, {"regions", regions}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string text_of(const std::string& grid, const std::vector<RegionRow>& rows) {
  std::string out = formatted("grid %s in %zu regions; the largest has %.2f times the mean\n",
                              in_quotes(grid).c_str(), rows.size(), imbalance(rows));
  out += "region    bricks    leaves  values to read  atlas, host + GPU  voxels\n";
  for (const RegionRow& row : rows)
    out +=
        formatted("%6zu  %8zu  %8llu  %14s  %17s  %s\n", row.region.number, row.region.count,
                  static_cast<unsigned long long>(row.leaves), mebibytes(row.values).c_str(),
                  mebibytes(row.atlas).c_str(),
                  row.voxels.empty()
                      ? "none"
                      : (voxel_text(row.voxels.min) + " to " + voxel_text(row.voxels.max)).c_str());
  return out;
}

/// Prints how the grid that `render` draws would be split. Throws Error(input).
void print_regions(const std::string& path, int count, bool as_json) {
  const VdbFile file(path);
  const Field field =
      file.read(file.default_grid(), {.role = GridRole::data, .in_file = true, .survey = false});
  std::vector<RegionRow> rows;
  for (const Region& region : Regions::in_parts(leaf_bricks(field), std::size_t(count)).all())
    rows.push_back(row_of(field, region));
  std::cout << (as_json ? json_of(path, field.name, rows) : text_of(field.name, rows));
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
