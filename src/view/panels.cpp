#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <filesystem>

#include "base/text.h"
#include "psivox/parameters.h"
#include "view/viewer.h"
#include "view/widgets.h"

namespace psivox::view {
namespace {

ImVec2 scaled(double x, double y, double scale) { return {float(x * scale), float(y * scale)}; }

/// Where a panel is placed: always after a change of the display's scale, else by the user.
ImGuiCond placing(const Viewer& viewer) {
  return viewer.gui().places_panels() ? ImGuiCond_Always : ImGuiCond_FirstUseEver;
}

std::string format_ms(double ms) {
  return ms < 1000 ? formatted("%.0f ms", ms) : formatted("%.1f s", ms / 1000);
}

std::string work_text(const WorkStage& stage, const std::string& of = "") {
  const auto& [name, fraction] = stage;
  return name + of + (fraction > 0 ? formatted(" %.0f %%", std::floor(100 * fraction)) : "");
}

ParameterChoices choices_of(Viewer& viewer) {
  ParameterChoices choices;
  choices.refuse = [&viewer](const std::string& why) { viewer.messages().error(why); };
  if (const Volume* volume = viewer.volume()) {
    choices.grids = volume->grids;
    choices.resolved = with_default_tolerance(volume->resolved);
  }
  return choices;
}

void draw_look_menu(Viewer& viewer) {
  ImGui::SetNextItemWidth(0.6f * ImGui::GetWindowWidth());
  const bool open = ImGui::BeginCombo("look", viewer.look().text().c_str());
  if (!open && ImGui::IsItemHovered())
    ImGui::SetTooltip(
        "scene parameters that suit the file; it replaces what is set below.\n"
        "auto goes by the file's grids");
  if (!open) return;
  std::vector<std::string> names = available_looks();
  names.insert(names.begin(), "auto");
  for (const std::string& name : names)
    if (ImGui::Selectable(name.c_str())) viewer.choose_look(name);
  ImGui::EndCombo();
}

void draw_file_section(Viewer& viewer) {
  if (!ImGui::CollapsingHeader("File")) return;
  std::string& path = viewer.panels().open_path;
  if (ImGui::InputText("open", &path, ImGuiInputTextFlags_EnterReturnsTrue)) viewer.open({path});
  if (ImGui::BeginCombo("recent", "", ImGuiComboFlags_NoPreview)) {
    for (const std::string& file : recent_files())
      if (ImGui::Selectable(file.c_str())) viewer.open({file});
    ImGui::EndCombo();
  }
  if (ImGui::Button("reload (R)")) viewer.reload();
  ImGui::SameLine();
  ImGui::Checkbox("when it changes", &viewer.options().watch);
  ImGui::SameLine();
  if (ImGui::Button("browse")) viewer.panels().files = true;
}

void draw_output_section(Viewer& viewer) {
  if (!ImGui::CollapsingHeader("Save", ImGuiTreeNodeFlags_DefaultOpen)) return;
  Panels& panels = viewer.panels();
  ImGui::InputText("##picture", &panels.picture_path);
  ImGui::SameLine();
  if (ImGui::Button(viewer.saving() ? "saving" : "picture"))
    viewer.messages().attempt([&] { viewer.save_picture(panels.picture_path); });
  ImGui::InputText("##scene", &panels.scene_path);
  ImGui::SameLine();
  if (ImGui::Button("scene"))
    viewer.messages().attempt([&] { viewer.save_scene(panels.scene_path); });
  ImGui::InputTextWithHint("size", "the window's", &panels.picture_size);
  if (ImGui::Button("copy as command line"))
    viewer.messages().attempt([&] { viewer.copy_command_line(); });
}

/// The parameters in which the right side of a comparison may differ.
void draw_right_side(Viewer& viewer) {
  static constexpr const char* names[] = {"integrator", "sampling", "segments", "step", "renderer"};
  Scene right = *viewer.other();
  ImGui::PushID("right");
  if (edit_parameters(right, choices_of(viewer), names))
    viewer.compare(viewer.display().comparison, right);
  ImGui::PopID();
}

void draw_exposure(Viewer& viewer) {
  Scene edited = viewer.scene();
  double stops = viewer.exposure();
  ImGui::SetNextItemWidth(0.45f * ImGui::GetWindowWidth());
  bool changed = slide("exposure", stops, -10, 10, "%.2f");
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("powers of 2, in the window and in saved sRGB pictures");
  if (changed) edited.exposure = stops;
  ImGui::SameLine();
  if (ImGui::SmallButton("auto")) {
    edited.exposure.reset();
    changed = true;
  }
  static constexpr const char* names[] = {"tone-map"};
  changed |= edit_parameters(edited, choices_of(viewer), names);
  if (changed) viewer.set_scene(edited);
}

void draw_display_section(Viewer& viewer) {
  if (!ImGui::CollapsingHeader("Display", ImGuiTreeNodeFlags_DefaultOpen)) return;
  DisplaySettings& look = viewer.display();
  draw_exposure(viewer);
  int layer = int(viewer.layer());
  if (ImGui::Combo("show", &layer, shown_layers, IM_ARRAYSIZE(shown_layers)))
    viewer.show(static_cast<ShownLayer>(layer));
  Panels& panels = viewer.panels();
  ImGui::Checkbox("function (T)", &panels.transfer);
  for (const auto& [name, shown] :
       {std::pair("bar", &panels.color_bar), {"axes", &panels.axes}, {"box", &panels.box}}) {
    ImGui::SameLine();
    ImGui::Checkbox(name, shown);
  }
  const char* names[] = {"one picture", "two, with a divider", "signed difference"};
  int chosen = int(look.comparison);
  if (ImGui::Combo("compare (X)", &chosen, names, 3))
    viewer.compare(static_cast<Comparison>(chosen), viewer.other());
  if (!viewer.other()) return;
  if (look.comparison == Comparison::difference) slide("gain", look.gain, 1, 10000, "%.0f");
  draw_right_side(viewer);
}

void draw_cut_section(Viewer& viewer) {
  Scene edited = viewer.scene();
  const bool slices = edited.shows(Shows::plane);
  if (slices && !viewer.panels().slices) ImGui::SetNextItemOpen(true);
  viewer.panels().slices = slices;
  if (!ImGui::CollapsingHeader("Slice and clip") || !viewer.volume()) return;
  const CutEdits edits =
      edit_cuts(edited, *viewer.volume()->subject, viewer.navigation().forward());
  // the default camera would frame what the clip leaves: here it stays while a slider moves
  if (edits.clipped) viewer.navigation().hold();
  if (edits.sliced || edits.clipped) viewer.set_scene(edited);
  if (edits.turned && viewer.navigation().moved()) viewer.navigation().face(edited.slice->normal);
}

void draw_scene_panel(Viewer& viewer) {
  ImGui::SetNextWindowPos({10, 10}, placing(viewer));
  // above the status line
  const double s = viewer.gui().scale(), height = double(ImGui::GetIO().DisplaySize.y) / s - 50;
  ImGui::SetNextWindowSize(scaled(330, std::clamp(height, 120.0, 560.0), s), placing(viewer));
  const Panel panel("Scene", &viewer.panels().scene);
  if (!panel) return;
  // in the order of use: open, look, cut, save, and then all parameters
  using Group = ParameterGroup;
  draw_file_section(viewer);
  draw_look_menu(viewer);
  draw_display_section(viewer);
  draw_cut_section(viewer);
  draw_output_section(viewer);
  Scene edited = viewer.scene();
  bool changed = false;
  for (const ParameterGroup group : {Group::look, Group::light, Group::camera, Group::accuracy,
                                     Group::input, Group::output, Group::machine})
    changed |= edit_group(group, edited, choices_of(viewer));
  if (changed) viewer.set_scene(edited);
}

void draw_transfer_panel(Viewer& viewer) {
  const double s = viewer.gui().scale();
  const float right = ImGui::GetIO().DisplaySize.x - float(410 * s);
  ImGui::SetNextWindowPos({right, 10}, placing(viewer));
  ImGui::SetNextWindowSize(scaled(400, 345, s), placing(viewer));
  viewer.messages().attempt([&] { viewer.edit_transfer_function(); });
}

/// The state of the picture, or the work that it waits for.
std::string picture_status(const Viewer& viewer) {
  const std::string& input = viewer.input();
  const PictureState& pictures = viewer.pictures();
  if (const auto loading = viewer.loading_stage())
    return work_text(*loading, " " + std::filesystem::path(input).filename().string());
  if (input.empty()) return "drop a volume here, or open one in the panel";
  if (pictures.complete()) {
    const bool picture = viewer.layer() == ShownLayer::picture;
    std::string text = picture ? "exact: as psivox render draws it, after " : "complete, after ";
    text += format_ms(pictures.refine_ms);
    if (pictures.estimated_rms) text += formatted(", error about %.2g", *pictures.estimated_rms);
    return text;
  }
  if (const auto stage = viewer.drawing_stage()) return work_text(*stage);
  if (!pictures.shown) return "";
  return formatted("preview, 1/%g of the size, ", pictures.rung.divisor) +
         format_ms(pictures.preview_ms);
}

std::string status(const Viewer& viewer) {
  static constexpr const char* units[] = {"", "segments of a ray", "depth [world units]",
                                          "error of radiance and alpha"};
  std::string text = picture_status(viewer);
  const glm::dvec2 range = viewer.pictures().layer_range;
  if (viewer.layer() != ShownLayer::picture && range != glm::dvec2(0))
    text += formatted("; %s from %.4g (violet) to %.4g (yellow)", units[int(viewer.layer())],
                      range.x, range.y);
  else if (viewer.layer() == ShownLayer::error)
    text += "; the error is computed once the picture is at rest";
  if (const auto& probed = viewer.probed())
    text += formatted("; value %.4g at (%.4g, %.4g, %.4g)", probed->value, probed->point.x,
                      probed->point.y, probed->point.z);
  return viewer.saving() ? text + "; saving " + viewer.saved_path() : text;
}

/// Height of the panel of frames, and its place above the status [pixels, where text has its usual
/// size].
constexpr float timeline_height = 62, timeline_bottom = 34;

/// The status and above it the newest message, at the bottom of the window.
void draw_status(const Viewer& viewer) {
  const ImGuiIO& io = ImGui::GetIO();
  ImDrawList& list = *ImGui::GetForegroundDrawList();
  const auto s = float(viewer.gui().scale());
  const float wrap = io.DisplaySize.x - 20 * s;
  float bottom = io.DisplaySize.y - 8 * s;
  const auto print = [&](ImU32 colour, const std::string& what) {
    if (what.empty()) return;
    const ImVec2 size = ImGui::CalcTextSize(what.c_str(), nullptr, false, wrap);
    const float y = bottom - size.y;
    bottom = y - 10 * s;
    list.AddRectFilled({6 * s, y - 3 * s}, {14 * s + size.x, y + size.y + 3 * s},
                       IM_COL32(0, 0, 0, 150), 3 * s);
    list.AddText(nullptr, 0, {10 * s, y}, colour, what.c_str(), nullptr, wrap);
  };
  const Messages& messages = viewer.messages();
  print(IM_COL32(220, 220, 220, 255), status(viewer));
  if (!viewer.sequence().empty())
    bottom = io.DisplaySize.y - (timeline_bottom + timeline_height + 8) * s;
  print(messages.is_error() ? IM_COL32(255, 120, 100, 255) : IM_COL32(150, 220, 150, 255),
        messages.shown());
}

void draw_help(Viewer& viewer) {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({io.DisplaySize.x / 2, io.DisplaySize.y / 2}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  const Panel panel("Keys", &viewer.panels().help,
                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
  for (const Command& row : commands()) {
    ImGui::TextUnformatted(row.keys);
    ImGui::SameLine(float(170 * viewer.gui().scale()));
    ImGui::TextUnformatted(row.what);
  }
}

void draw_box(Viewer& viewer) {
  const Subject* subject = viewer.first_subject();
  if (!subject) return;
  const glm::dvec3 &low = subject->box_min, &high = subject->box_max;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const auto corner = [&](int i) {
    return glm::dvec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  };
  for (int i = 0; i < 8; ++i)
    for (int axis = 1; axis < 8; axis *= 2) {
      if (i & axis) continue;
      glm::dvec2 a, b;
      const Navigation& navigation = viewer.navigation();
      if (!navigation.project(corner(i), a) || !navigation.project(corner(i | axis), b)) continue;
      list.AddLine({float(a.x), float(a.y)}, {float(b.x), float(b.y)},
                   IM_COL32(200, 200, 200, 255));
    }
}

void draw_divider(double divider) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto x = float(divider) * size.x;
  ImGui::GetBackgroundDrawList()->AddLine({x, 0}, {x, size.y}, IM_COL32(255, 255, 255, 200));
}

/// Marks on the slider of the frames that have no file.
void mark_missing(const Sequence& sequence, const ImVec2& corner, float width) {
  const FrameNumber count = sequence.last() - sequence.first();
  if (sequence.missing().size() >= 1000) return;
  for (const FrameNumber frame : sequence.missing()) {
    const float x =
        corner.x + width * float(frame - sequence.first()) / float(std::max<FrameNumber>(count, 1));
    ImGui::GetWindowDrawList()->AddLine({x, corner.y - 3}, {x, corner.y + 3},
                                        IM_COL32(255, 120, 80, 255), 2);
  }
}

void draw_timeline(Sequence& sequence, double scale) {
  const ImGuiIO& io = ImGui::GetIO();
  const auto s = float(scale);
  const float height = timeline_height * s, bottom = io.DisplaySize.y - timeline_bottom * s;
  ImGui::SetNextWindowPos({io.DisplaySize.x * 0.25f, bottom - height});
  ImGui::SetNextWindowSize({io.DisplaySize.x * 0.5f, height});
  const Panel panel("Frames", nullptr, ImGuiWindowFlags_NoDecoration);
  if (ImGui::Button(sequence.playing ? "pause" : "play")) sequence.toggle_playing();
  ImGui::SameLine();
  ImGui::SetNextItemWidth(float(120 * scale));
  slide("frames/s", sequence.rate, 1, 60, "%.0f");
  if (!sequence.missing().empty()) {
    ImGui::SameLine();
    ImGui::TextColored({1, 0.6f, 0.4f, 1}, "%d missing", int(sequence.missing().size()));
  }
  FrameNumber frame = sequence.current();
  const FrameNumber first = sequence.first(), last = sequence.last();
  ImGui::SetNextItemWidth(-1);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (ImGui::SliderScalar("##frame", ImGuiDataType_S64, &frame, &first, &last))
    sequence.go_to(frame);
  mark_missing(sequence, corner, ImGui::GetItemRectSize().x);
}

}  // namespace

void draw_panels(Viewer& viewer) {
  const Panels& panels = viewer.panels();
  draw_box(viewer);
  if (viewer.display().comparison == Comparison::wipe) draw_divider(viewer.display().divider);
  if (panels.scene) draw_scene_panel(viewer);
  if (!viewer.sequence().empty()) draw_timeline(viewer.sequence(), viewer.gui().scale());
  draw_status(viewer);
  if (panels.color_bar) draw_color_bar(viewer);
  if (panels.axes || panels.box) viewer.messages().attempt([&] { draw_marks(viewer); });
  if (std::string file; panels.files && browse(viewer.panels().folder, file, viewer.panels().files))
    viewer.open({file});
  if (panels.help) draw_help(viewer);
  if (panels.transfer && viewer.volume()) draw_transfer_panel(viewer);
}

}  // namespace psivox::view
