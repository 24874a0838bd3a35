// What the window draws over the picture, and the list of files.

#include <imgui.h>

#include <filesystem>
#include <map>

#include "base/text.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "scene/color.h"
#include "view/viewer.h"
#include "view/widgets.h"

namespace psivox::view {
namespace {

namespace fs = std::filesystem;

constexpr ImU32 ink = IM_COL32(200, 200, 200, 255), faint = IM_COL32(200, 200, 200, 90);

ImVec2 pixel_at(const glm::dvec2& p) { return {float(p.x), float(p.y)}; }

/// A text that begins at a place and lies on one side of it.
void write(const glm::dvec2& place, const glm::dvec2& away, const std::string& text) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const glm::dvec2 half(0.5 * double(size.x), 0.5 * double(size.y));
  ImGui::GetBackgroundDrawList()->AddText(pixel_at(place + away * half - half), ink, text.c_str());
}

/// A colour as the window's display shows it, but for a view of OpenColorIO.
ImU32 shown(const glm::dvec3& color, Display display) {
  display.ocio = {};
  Image pixel = rgba_image(1, 1);
  for (int c = 0; c < 3; ++c) pixel.rgba()[std::size_t(c)] = float(color[c]);
  const std::vector<std::uint8_t> codes = srgb_bytes(pixel, display);
  return IM_COL32(codes[0], codes[1], codes[2], 255);
}

}  // namespace

void draw_color_bar(const Viewer& viewer) {
  if (!viewer.volume() || !viewer.volume()->colors) return;
  const ColorScale& scale = *viewer.volume()->colors;
  Display display = display_of(viewer.scene());
  display.exposure = viewer.exposure();
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  const double s = viewer.gui().scale(), width = 14 * s, height = 0.5 * double(window.y);
  const glm::dvec2 corner(double(window.x) - 90 * s, 0.25 * double(window.y));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const double rows = double(scale.colors.size());
  for (std::size_t i = 0; i < scale.colors.size(); ++i) {
    const double bottom = corner.y + height * (1 - double(i) / rows);
    list.AddRectFilled(pixel_at({corner.x, bottom - height / rows - 1}),
                       pixel_at({corner.x + width, bottom}), shown(scale.colors[i], display));
  }
  write(corner - glm::dvec2(0, 6 * s), {1, -1}, scale.title);
  for (const double value : bar_values(scale)) {
    const glm::dvec2 tick(corner.x + width, corner.y + height * (1 - bar_place(scale, value)));
    list.AddLine(pixel_at(tick), pixel_at(tick + glm::dvec2(4 * s, 0)), ink);
    write(tick + glm::dvec2(7 * s, 0), {1, 0}, formatted("%.6g", value));
  }
}

void draw_marks(Viewer& viewer) {
  if (!viewer.volume()) return;
  View view;
  view.scene = viewer.scene();
  view.scene.axes = viewer.panels().axes;
  view.scene.box = viewer.panels().box;
  view.scene.title.clear();
  view.scene.scale_bar = true;  // the status line is in its place
  view.subject = viewer.volume()->subject;
  view.camera = make_camera(view.scene, *view.subject);
  Legend legend;
  add_annotations(view, legend);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const LegendLine& line : legend.lines) {
    const glm::dvec3 color = 255.0 * srgb_from_linear(line.color.value_or(glm::dvec3(0.5)));
    const ImU32 own = IM_COL32(int(color.r), int(color.g), int(color.b), 255);
    list.AddLine(pixel_at(line.from), pixel_at(line.to),
                 line.color    ? own
                 : line.behind ? faint
                               : ink,
                 line.color ? 2 : 1);
  }
  for (const LegendText& text : legend.texts) write(text.at, text.away, text.text);
}

bool browse(std::string& folder, std::string& file, bool& open) {
  const Panel panel("Open", &open);
  if (!panel) return false;
  std::error_code unreadable;
  if (folder.empty()) folder = fs::current_path(unreadable).string();
  ImGui::TextWrapped("%s", folder.c_str());
  std::map<std::string, std::string> folders{{"..", fs::path(folder).parent_path().string()}},
      files;
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;
    if (entry.is_directory(unreadable))
      folders[name + "/"] = entry.path().string();
    else if (has_volume_name(name))
      files[name] = entry.path().string();
  }
  for (const auto& [name, path] : folders)
    if (ImGui::Selectable(name.c_str())) folder = path;
  for (const auto& [name, path] : files)
    if (ImGui::Selectable(name.c_str())) file = path;
  open &= file.empty();
  return !file.empty();
}

}  // namespace psivox::view
