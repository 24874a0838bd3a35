#include "psivox/file_report.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <type_traits>
#include <utility>

#include "atlas/atlas.h"
#include "base/file_blocks.h"
#include "base/text.h"
#include "psivox/error.h"
#include "psivox/open.h"

namespace psivox {
namespace {

using Json = nlohmann::ordered_json;

GridReport describe(const VolumeFile& file, const std::string& path, const GridInfo& grid) {
  GridReport row{grid};
  if (!grid.problem.empty() || !grid.values_read) return row;
  try {
    // as auto draws it: a level set is a surface, which may have no inside
    const Field field = file.read(
        grid.name, {.role = grid.channels == 1 ? GridRole::attenuation : GridRole::luminance,
                    .distances = grid.grid_class == "level set"});
    row.atlas = predict_atlas(field);
  } catch (const Error& error) {
    row.grid.problem = without_subject(error.what(), path, grid.name);
  }
  return row;
}

template <typename Vector>
Json vector_json(const Vector& v) {
  return {v.x, v.y, v.z};
}

template <typename Vector>
Json box_json(const Vector& min, const Vector& max) {
  return {{"min", vector_json(min)}, {"max", vector_json(max)}};
}

Json matrix_json(const glm::dmat4& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r)
    rows.push_back({matrix[0][r], matrix[1][r], matrix[2][r], matrix[3][r]});
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
                     {"not_finite", grid.values->not_finite},
                     {"filled", grid.values->filled}};
  const Box& box = grid.active_box;
  out["active_box"] = box.empty() ? Json(nullptr) : box_json(box.min, box.max);
  out["world_box"] = box.empty() ? Json(nullptr) : box_json(grid.world_min, grid.world_max);
  out["transform"] = grid.transform;
  out["voxel_size"] = vector_json(grid.voxel_size);
  out["world_from_index"] = matrix_json(grid.world_from_index);
  out["background"] = grid.background;
  if (row.atlas)
    out["atlas"] = {{"float32_bytes", row.atlas->bytes()},
                    {"textured_bricks", row.atlas->textured_bricks},
                    {"constant_bricks", row.atlas->constant_bricks}};
  out["metadata"] = grid.metadata;
  if (!grid.problem.empty()) out["problem"] = grid.problem;
  return out;
}

/// Why no picture can be drawn.
std::string advice_for(const FileReport& report, const std::string& refusal) {
  if (report.grids.empty() || std::ranges::any_of(report.grids, &GridReport::usable))
    return without_subject(refusal, report.path, "");
  return "nothing here can be rendered; each grid's problem is above";
}

// --- text: first what a picture can be made of, then everything else -----------------------------

/// Lines of which no text of a file can make others: the breaks are those of literals.
class Lines {
 public:
  Lines& operator<<(const char* literal) { return add(literal); }
  Lines& operator<<(char c) { return add(c); }
  Lines& operator<<(const std::string& text) { return add(printable(text)); }
  template <typename Number>
  requires std::is_arithmetic_v<Number> Lines& operator<<(Number number) { return add(number); }
  std::string str() const { return out_.str(); }

 private:
  template <typename T>
  Lines& add(const T& item) {
    out_ << item;
    return *this;
  }
  std::ostringstream out_;
};

/// Six digits, as OpenVDB prints numbers. No number is -0.
template <typename Vector>
std::string spaced(const Vector& v, const char* between) {
  std::ostringstream out;
  out << v.x + 0 << between << v.y + 0 << between << v.z + 0;
  return out.str();
}

std::string range_text(const GridInfo& grid) {
  if (!grid.values_read) return "values not read";
  if (!grid.values) return "no value is finite";
  const ValueStatistics& values = *grid.values;
  std::ostringstream out;
  out << (grid.channels == 3 ? "lengths " : "") << values.least << " to " << values.greatest
      << ", mean " << values.mean;
  if (values.not_finite > 0) out << ", " << values.not_finite << " not finite";
  if (values.filled > 0) out << ", " << values.filled << " of " << values.fill << " are no data";
  return out.str();
}

/// Letters of a text in UTF-8, as it is printed.
std::size_t letters(const std::string& text) {
  return std::size_t(
      std::ranges::count_if(printable(text), [](char c) { return (c & 0xc0) != 0x80; }));
}

void print_usable(const FileReport& report, Lines& out) {
  std::size_t width = 0;
  for (const GridReport& row : report.grids) width = std::max(width, letters(row.grid.name));
  for (const GridReport& row : report.grids) {
    const std::string name = row.grid.name + std::string(width - letters(row.grid.name), ' ');
    if (!row.usable()) {
      out << "  " << name << "  not usable: " << row.grid.problem << '\n';
      continue;
    }
    out << "  " << name << "  " << row.grid.value_type << ' ' << row.grid.grid_class << ", "
        << range_text(row.grid) << "\n  " << std::string(width, ' ') << "  from "
        << spaced(row.grid.world_min, " ") << " to " << spaced(row.grid.world_max, " ")
        << " [world units]\n";
  }
}

/// What psivox chooses, as the options that give it.
void print_chosen(const FileReport& report, Lines& out) {
  if (!report.chosen) return;
  const Scene& scene = *report.chosen;
  const Scene defaults;
  out << "\nauto:";
  for (const std::string& name : chosen_by_auto()) {
    const Parameter& p = *find_parameter(name);
    const std::string text = parameter_text(scene, p);
    if (text != parameter_text(defaults, p)) out << " " << shell_word("--" + name + "=" + text);
  }
  out << "\n  look " << report.look << (report.set.empty() ? "" : ":");
  for (const Setting& setting : report.set)
    out << " " << shell_word("--" + setting.name + "=" + setting.text);
  if (!report.dark_because.empty()) out << ", without light: " << report.dark_because;
  out << '\n';
  if (!report.z_up.empty()) out << "  Z is up: " << report.z_up << '\n';
}

void print_metadata(const std::map<std::string, std::string>& metadata, Lines& out) {
  for (const auto& [name, value] : metadata) {
    std::string line = value.substr(0, 200);
    std::replace(line.begin(), line.end(), '\n', ' ');
    out << "  metadata    " << name << ": " << line << (value.size() > 200 ? "..." : "") << '\n';
  }
}

void print_grid(const GridReport& row, Lines& out) {
  const GridInfo& grid = row.grid;
  out << '\n' << grid.name << '\n';
  if (grid.value_type.empty()) {
    out << "  problem     " << grid.problem << '\n';
    return;
  }
  out << "  type        " << grid.value_type << " (" << grid.type
      << (grid.saved_as_half ? ", saved as half" : "") << "), " << grid.grid_class << '\n';
  out << "  voxels      " << grid.active_voxels << " active, in " << grid.leaves << " leaves and "
      << grid.active_tiles << " active tiles\n";
  if (!grid.active_box.empty())
    out << "  box         " << spaced(grid.active_box.min, " ") << " to "
        << spaced(grid.active_box.max, " ") << " ("
        << spaced(grid.active_box.max - grid.active_box.min + 1, " x ") << ")\n";
  out << "  transform   " << grid.transform << ", voxel " << spaced(grid.voxel_size, " x ")
      << ", origin " << spaced(glm::dvec3(grid.world_from_index[3]), " ") << '\n';
  out << "  background  " << grid.background << '\n';
  if (row.atlas)
    out << "  atlas       " << mebibytes(row.atlas->bytes()) << ": " << row.atlas->textured_bricks
        << " textured and " << row.atlas->constant_bricks << " constant bricks\n";
  print_metadata(grid.metadata, out);
  if (!grid.problem.empty()) out << "  problem     " << grid.problem << '\n';
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
  const VolumeFile file(path);
  report.bytes = std::filesystem::file_size(frame_of_file(path).file);
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
    OpenedScene opened = open_scene(scene, file, {.parts = {.allowed = true}});
    LookedScene& looked = opened.looked;
    report.chosen = std::move(opened.view.scene);
    report.look = std::move(looked.look);
    report.dark_because = std::move(looked.dark_because);
    for (const Setting& setting : looked.settings)
      if (!std::ranges::count(chosen_by_auto(), setting.name) && setting.name != "azimuth" &&
          setting.name != "elevation")  // the camera is turned already
        report.set.push_back(setting);
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

std::string FileReport::text() const {
  Lines out;
  out << path << ": " << mebibytes(bytes) << ", " << grids.size()
      << (grids.size() == 1 ? " grid\n" : " grids\n");
  print_usable(*this, out);
  print_chosen(*this, out);
  if (!metadata.empty()) out << '\n';
  print_metadata(metadata, out);
  for (const GridReport& row : grids) print_grid(row, out);
  if (!advice.empty()) out << '\n' << advice << '\n';
  return out.str();
}

}  // namespace psivox
