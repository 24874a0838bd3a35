#include "region_report.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <nlohmann/json.hpp>

#include "psivox/atlas.h"
#include "psivox/text.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

/// Largest of a number over the regions, as a multiple of its mean.
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
  const Box domain = field.domain();
  const glm::ivec3 low = glm::floor(glm::vec3(domain.min) / 8.0f), high = domain.max / 8 + 1;
  const Box bricks{glm::max(region.bricks.min, low), glm::min(region.bricks.max, high)};
  row.voxels = {glm::max(8 * bricks.min, domain.min), glm::min(8 * bricks.max + 8, domain.max)};
  // as part_of_field reads them: with the voxels on the far faces
  for (const Leaf& leaf : field.leaves)
    row.leaves += glm::all(glm::lessThanEqual(leaf.origin, 8 * bricks.max + 15)) &&
                  glm::all(glm::greaterThanEqual(leaf.origin, 8 * bricks.min));
  row.values = row.leaves * 512 * sizeof(float) * std::uint64_t(field.channels);
  row.atlas = 2 * region.count * brick_texels * sizeof(float) * std::uint64_t(field.channels);
  return row;
}

}  // namespace

RegionReport regions_of(const std::string& path, int count) {
  const VdbFile file(path);
  RegionReport report{path, file.default_grid(), {}};
  const Field field =
      file.read(report.grid, {.role = GridRole::data, .in_file = true, .unsurveyed = true});
  report.grid = field.name;
  for (const Region& region : Regions::in_parts(leaf_bricks(field), std::size_t(count)).all())
    report.rows.push_back(row_of(field, region));
  return report;
}

std::string RegionReport::json() const {
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

std::string RegionReport::text() const {
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

}  // namespace psivox
