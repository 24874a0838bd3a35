// What `psivox info` prints: first what a picture can be made of, then everything else.

#include <algorithm>
#include <sstream>

#include "psivox/file_report.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "psivox/printable.h"
#include "psivox/text.h"

namespace psivox {
namespace {

/// Six digits, as OpenVDB prints numbers.
template <typename Vector>
std::string spaced(const Vector& v, const char* between) {
  std::ostringstream out;
  out << v.x << between << v.y << between << v.z;
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
  return out.str();
}

std::size_t longest_name(const std::vector<GridReport>& grids) {
  std::size_t length = 0;
  for (const GridReport& row : grids) length = std::max(length, row.grid.name.size());
  return length;
}

void print_usable(const FileReport& report, std::ostream& out) {
  const std::size_t width = longest_name(report.grids);
  for (const GridReport& row : report.grids) {
    const std::string name = row.grid.name + std::string(width - row.grid.name.size(), ' ');
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
void print_chosen(const FileReport& report, std::ostream& out) {
  if (!report.chosen) return;
  const Scene& scene = *report.chosen;
  const Scene defaults;
  out << "\nauto:";
  for (const std::string& name : chosen_by_auto()) {
    const Parameter& p = *find_parameter(name);
    const std::string text = parameter_text(scene, p);
    if (text != parameter_text(defaults, p)) out << " --" << name << "=" << text;
  }
  out << "\n  look " << report.look << (report.set.empty() ? "" : ":");
  for (const Setting& setting : report.set) out << " --" << setting.name << "=" << setting.text;
  if (!report.dark_because.empty()) out << ", without light: " << report.dark_because;
  out << '\n';
  if (!report.z_up.empty()) out << "  Z is up: " << report.z_up << '\n';
}

void print_metadata(const std::map<std::string, std::string>& metadata, std::ostream& out) {
  for (const auto& [name, value] : metadata) {
    std::string line = value.substr(0, 200);
    std::replace(line.begin(), line.end(), '\n', ' ');
    out << "  metadata    " << printable(name) << ": " << printable(line)
        << (value.size() > 200 ? "..." : "") << '\n';
  }
}

void print_grid(const GridReport& row, std::ostream& out) {
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
  if (row.float32)
    out << "  atlas       " << mebibytes(row.float32->bytes()) << " in float32, "
        << mebibytes(row.float16->bytes()) << " in float16: " << row.float32->textured_bricks
        << " textured and " << row.float32->constant_bricks << " constant bricks\n";
  print_metadata(grid.metadata, out);
  if (!grid.problem.empty()) out << "  problem     " << grid.problem << '\n';
}

}  // namespace

std::string FileReport::text() const {
  std::ostringstream out;
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
