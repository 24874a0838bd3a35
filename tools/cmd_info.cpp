// psivox info IN.vdb: lists what the file contains and how much memory its atlases need.

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "command_line.h"
#include "commands.h"
#include "psivox/atlas.h"
#include "psivox/error.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

using json = nlohmann::ordered_json;

struct Row {
  GridInfo grid;
  std::optional<AtlasSize> float32, float16;  ///< set if the grid can be rendered
};

Row describe(const VdbFile& file, const GridInfo& grid) {
  Row row{grid, {}, {}};
  if (!grid.problem.empty()) return row;
  try {
    const GridRole role = grid.channels == 1 ? GridRole::attenuation : GridRole::luminance;
    const Field field = file.read(grid.name, {role, false});
    row.float32 = predict_atlas(field, {TexelType::float32});
    row.float16 = predict_atlas(field, {TexelType::float16});
  } catch (const Error& error) {
    row.grid.problem = error.what();
  }
  return row;
}

json vector_json(const glm::ivec3& v) { return {v.x, v.y, v.z}; }
json vector_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json to_json(const Row& row) {
  const GridInfo& grid = row.grid;
  json out = {{"name", grid.name},
              {"type", grid.type},
              {"value_type", grid.value_type},
              {"class", grid.grid_class},
              {"channels", grid.channels},
              {"saved_as_half", grid.saved_as_half},
              {"active_voxels", grid.active_voxels},
              {"leaves", grid.leaves},
              {"active_tiles", grid.active_tiles}};
  out["active_box"] = grid.active_box.empty() ? json(nullptr)
                                              : json{{"min", vector_json(grid.active_box.min)},
                                                     {"max", vector_json(grid.active_box.max)}};
  out["transform"] = grid.transform;
  out["voxel_size"] = vector_json(grid.voxel_size);
  json rows = json::array();
  for (int r = 0; r < 4; ++r) {
    json values = json::array();
    for (int c = 0; c < 4; ++c) values.push_back(grid.world_from_index[c][r]);
    rows.push_back(values);
  }
  out["world_from_index"] = rows;
  out["background"] = grid.background;
  if (row.float32)
    out["atlas"] = {{"float32_bytes", row.float32->bytes()},
                    {"float16_bytes", row.float16->bytes()},
                    {"textured_bricks", row.float32->textured_bricks},
                    {"constant_bricks", row.float32->constant_bricks}};
  if (!grid.problem.empty()) out["problem"] = grid.problem;
  return out;
}

template <typename Vector>
std::string spaced(const Vector& v, const char* between) {
  std::ostringstream out;
  out << v.x << between << v.y << between << v.z;
  return out.str();
}

void print(const Row& row) {
  const GridInfo& grid = row.grid;
  std::cout << '\n' << grid.name << '\n';
  if (grid.value_type.empty()) {
    std::cout << "  problem     " << grid.problem << '\n';
    return;
  }
  std::cout << "  type        " << grid.value_type << " (" << grid.type
            << (grid.saved_as_half ? ", saved as half" : "") << "), " << grid.grid_class << '\n';
  std::cout << "  voxels      " << grid.active_voxels << " active, in " << grid.leaves
            << " leaves and " << grid.active_tiles << " active tiles\n";
  if (!grid.active_box.empty())
    std::cout << "  box         " << spaced(grid.active_box.min, " ") << " to "
              << spaced(grid.active_box.max, " ") << " ("
              << spaced(grid.active_box.max - grid.active_box.min + 1, " x ") << ")\n";
  std::cout << "  transform   " << grid.transform << ", voxel " << spaced(grid.voxel_size, " x ")
            << ", origin " << spaced(glm::dvec3(grid.world_from_index[3]), " ") << '\n';
  std::cout << "  background  " << grid.background << '\n';
  if (row.float32)
    std::cout << "  atlas       " << mebibytes(row.float32->bytes()) << " in float32, "
              << mebibytes(row.float16->bytes()) << " in float16: " << row.float32->textured_bricks
              << " textured and " << row.float32->constant_bricks << " constant bricks\n";
  if (!grid.problem.empty()) std::cout << "  problem     " << grid.problem << '\n';
}

}  // namespace

void info_command(Arguments arguments) {
  std::string path;
  bool as_json = false;
  CommandLine line("info",
                   "Lists the grids of a .vdb: types, boxes, transforms, sizes on the GPU.");
  line.add_option("IN.vdb", path, "file to describe")->type_name("")->required();
  line.add_flag("--json", as_json, "print JSON");
  if (!line.read(arguments)) return;

  const VdbFile file(path);
  const std::uint64_t bytes = std::filesystem::file_size(path);
  json grids = json::array();
  if (!as_json)
    std::cout << path << ": " << mebibytes(bytes) << ", " << file.names().size()
              << (file.names().size() == 1 ? " grid\n" : " grids\n");
  for (const GridInfo& grid : file.info()) {
    const Row row = describe(file, grid);
    if (as_json)
      grids.push_back(to_json(row));
    else
      print(row);
  }
  if (as_json)
    std::cout << json{{"file", path}, {"bytes", bytes}, {"grids", grids}}.dump(
                     2, ' ', false, json::error_handler_t::replace)
              << '\n';
}

}  // namespace psivox
