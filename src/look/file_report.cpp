#include "psivox/file_report.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "psivox/error.h"
#include "psivox/look.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "scene/vector_json.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

/// A message where the file, or the grid of it, has been named.
std::string without(const std::string& subject, const std::string& message) {
  return message.starts_with(subject) ? message.substr(subject.size()) : message;
}

GridReport describe(const VdbFile& file, const std::string& path, const GridInfo& grid) {
  GridReport row{grid, {}, {}};
  if (!grid.problem.empty() || !grid.values_read) return row;
  try {
    // as auto draws it: a level set is a surface, which may have no inside
    const Field field = file.read(
        grid.name, {.role = grid.channels == 1 ? GridRole::attenuation : GridRole::luminance,
                    .distances = grid.grid_class == "level set"});
    row.float32 = predict_atlas(field, {TexelType::float32});
    row.float16 = row.float32;
    row.float16->texel_bytes /= 2;
  } catch (const Error& error) {
    row.grid.problem = without(path + ": grid '" + grid.name + "' ", error.what());
  }
  return row;
}

template <typename Vector>
Json box_json(const Vector& min, const Vector& max) {
  return {{"min", vector_json(min)}, {"max", vector_json(max)}};
}

Json matrix_json(const glm::dmat4& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) {
    Json values = Json::array();
    for (int c = 0; c < 4; ++c) values.push_back(matrix[c][r]);
    rows.push_back(values);
  }
  return rows;
}

Json to_json(const GridReport& row) {
  const GridInfo& grid = row.grid;
  Json out = {{"name", grid.name},
              {"type", grid.type},
              {"value_type", grid.value_type},
              {"class", grid.grid_class},
              {"channels", grid.channels},
              {"saved_as_half", grid.saved_as_half},
              {"active_voxels", grid.active_voxels},
              {"leaves", grid.leaves},
              {"active_tiles", grid.active_tiles}};
  if (grid.values)
    out["values"] = {{"least", grid.values->least},
                     {"greatest", grid.values->greatest},
                     {"mean", grid.values->mean},
                     {"not_finite", grid.values->not_finite}};
  const Box& box = grid.active_box;
  out["active_box"] = box.empty() ? Json(nullptr) : box_json(box.min, box.max);
  out["world_box"] = box.empty() ? Json(nullptr) : box_json(grid.world_min, grid.world_max);
  out["transform"] = grid.transform;
  out["voxel_size"] = vector_json(grid.voxel_size);
  out["world_from_index"] = matrix_json(grid.world_from_index);
  out["background"] = grid.background;
  if (row.float32)
    out["atlas"] = {{"float32_bytes", row.float32->bytes()},
                    {"float16_bytes", row.float16->bytes()},
                    {"textured_bricks", row.float32->textured_bricks},
                    {"constant_bricks", row.float32->constant_bricks}};
  out["metadata"] = grid.metadata;
  if (!grid.problem.empty()) out["problem"] = grid.problem;
  return out;
}

/// Why no picture can be drawn.
std::string advice_for(const FileReport& report, const std::string& refusal) {
  if (std::ranges::any_of(report.grids, &GridReport::usable))
    return without(report.path + ": ", refusal);
  return "nothing here can be rendered; each grid's problem is above";
}

}  // namespace

const std::vector<std::string>& chosen_by_auto() {
  static const std::vector<std::string> names{"grid",    "extinction",      "colormap",     "range",
                                              "up-axis", "camera-position", "camera-target"};
  return names;
}

FileReport report_of(const std::string& path, bool values) {
  FileReport report;
  report.path = path;
  const VdbFile file(path);
  report.bytes = std::filesystem::file_size(path);
  report.metadata = file.metadata();
  report.z_up = file.z_up();
  for (const GridInfo& grid : file.info(values)) report.grids.push_back(describe(file, path, grid));
  if (!values) {
    report.advice = advice_for(report, "");
    return report;
  }
  try {
    Scene scene;
    scene.input = path;
    LookedScene looked = with_look(scene, file, "auto", true, {.allowed = true});
    report.chosen = make_view(looked.scene, looked.fields).scene;
    report.look = std::move(looked.look);
    report.dark_because = std::move(looked.dark_because);
    for (const Setting& setting : looked.settings)
      if (!std::ranges::count(chosen_by_auto(), setting.name)) report.set.push_back(setting);
  } catch (const Error& error) {
    report.advice = advice_for(report, error.what());
  }
  return report;
}

std::string FileReport::json() const {
  Json rows = Json::array();
  for (const GridReport& row : grids) rows.push_back(to_json(row));
  Json out = {{"file", path}, {"bytes", bytes}, {"metadata", metadata}};
  out["z_up"] = z_up.empty() ? Json(nullptr) : Json(z_up);
  out["auto"] = nullptr;
  if (chosen) {
    const Json scene = Json::parse(psivox::to_json(*chosen));
    for (const std::string& name : chosen_by_auto()) out["auto"][name] = scene.at(name);
    out["auto"]["look"] = look;
    for (const Setting& setting : set) out["auto"][setting.name] = scene.at(setting.name);
  }
  out["grids"] = rows;
  if (!advice.empty()) out["advice"] = advice;
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace psivox
