// What the viewer shows beside the picture.

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <filesystem>

#include "psivox/parameters.h"
#include "view/keys.h"
#include "view/parameter_panel.h"
#include "view/recent_files.h"
#include "view/viewer.h"

namespace psivox::view {
namespace {

constexpr auto message_time = std::chrono::seconds(8);

ImVec2 scaled(double x, double y, double scale) {
  return {static_cast<float>(x * scale), static_cast<float>(y * scale)};
}

bool slide(const char* label, double& value, double least, double most, const char* format) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &least, &most, format);
}

std::string digits_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

std::string format_ms(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, ms < 1000 ? "%.0f ms" : "%.1f s", ms < 1000 ? ms : ms / 1000);
  return text;
}

std::string percent(double fraction) {
  return fraction > 0 ? " " + std::to_string(static_cast<int>(100 * fraction)) + " %" : "";
}

}  // namespace

void Viewer::draw_panels() {
  draw_box();
  if (look_.comparison == Comparison::wipe) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const auto x = static_cast<float>(look_.divider) * size.x;
    ImGui::GetBackgroundDrawList()->AddLine({x, 0}, {x, size.y}, IM_COL32(255, 255, 255, 200));
  }
  if (show_panels_) draw_scene_panel();
  draw_timeline();
  draw_status();
  if (show_help_) draw_help();
  if (show_transfer_ && volume_) {
    const ImGuiIO& io = ImGui::GetIO();
    const double s = gui_.scale();
    const ImGuiCond when = gui_.places_panels() ? ImGuiCond_Always : ImGuiCond_FirstUseEver;
    ImGui::SetNextWindowPos({io.DisplaySize.x - static_cast<float>(410 * s), 10}, when);
    ImGui::SetNextWindowSize(scaled(400, 330, s), when);
    attempt([&] { editor_.draw(scene_, *volume_, show_transfer_); });
  }
}

void Viewer::draw_scene_panel() {
  const double s = gui_.scale();
  const ImGuiCond when = gui_.places_panels() ? ImGuiCond_Always : ImGuiCond_FirstUseEver;
  ImGui::SetNextWindowPos({10, 10}, when);
  ImGui::SetNextWindowSize(scaled(330, 560, s), when);
  if (ImGui::Begin("Scene", &show_panels_)) {
    draw_file_section();
    draw_output_section();
    draw_display_section();
    Scene edited = scene();
    const glm::ivec2 resolution = scene_.resolution;
    const std::vector<std::string> none;
    const ParameterChoices choices{volume_ ? volume_->grids : none,
                                   volume_ ? volume_->extinction : 1};
    if (edit_parameters(edited, choices, [&](const std::string& why) { error(why); })) {
      edited.resolution = resolution;
      set_scene(edited);
    }
  }
  ImGui::End();
}

void Viewer::draw_file_section() {
  if (!ImGui::CollapsingHeader("File")) return;
  if (ImGui::InputText("open", &open_path_, ImGuiInputTextFlags_EnterReturnsTrue)) open(open_path_);
  if (ImGui::BeginCombo("recent", "", ImGuiComboFlags_NoPreview)) {
    for (const std::string& file : recent_files())
      if (ImGui::Selectable(file.c_str())) open(file);
    ImGui::EndCombo();
  }
  if (ImGui::Button("reload (R)")) reload();
  ImGui::SameLine();
  ImGui::Checkbox("when it changes", &options_.watch);
}

void Viewer::draw_output_section() {
  if (!ImGui::CollapsingHeader("Save", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::InputText("##picture", &picture_path_);
  ImGui::SameLine();
  if (ImGui::Button(save_.running() ? "saving" : "picture"))
    attempt([&] { save_picture(picture_path_); });
  ImGui::InputText("##scene", &scene_path_);
  ImGui::SameLine();
  if (ImGui::Button("scene")) attempt([&] { save_scene(scene_path_); });
  ImGui::InputTextWithHint("size", "the window's", &picture_size_);
  if (ImGui::Button("copy as command line")) attempt([&] { copy_command_line(); });
}

void Viewer::draw_display_section() {
  if (!ImGui::CollapsingHeader("Display", ImGuiTreeNodeFlags_DefaultOpen)) return;
  slide("exposure", look_.exposure, -10, 10, "%.2f");
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("powers of 2, on the screen only: saved pictures are linear radiance");
  int layer = static_cast<int>(layer_);
  if (ImGui::Combo("show", &layer, shown_layers, IM_ARRAYSIZE(shown_layers)))
    show(static_cast<ShownLayer>(layer));
  ImGui::Checkbox("transfer function (T)", &show_transfer_);
  const char* names[] = {"one picture", "two, with a divider", "signed difference"};
  int chosen = static_cast<int>(look_.comparison);
  if (ImGui::Combo("compare (X)", &chosen, names, 3))
    compare(static_cast<Comparison>(chosen), other_);
  if (!other_) return;
  if (look_.comparison == Comparison::difference) slide("gain", look_.gain, 1, 10000, "%.0f");
  Scene right = *other_;
  static constexpr const char* names_right[] = {"integrator", "sampling", "segments", "step",
                                                "renderer"};
  ImGui::PushID("right");
  if (edit_parameters(
          right, {}, [&](const std::string& why) { error(why); }, names_right))
    other_ = right;
  ImGui::PopID();
}

std::string Viewer::status() const {
  const std::string file = std::filesystem::path(scene_.input).filename().string();
  if (const auto loading = loader_.progress())
    return loading->first + " " + file + percent(loading->second);
  if (scene_.input.empty()) return "drop a .vdb here, or open one in the panel";
  if (refined_ == wished_ && refined_)
    return (layer_ == ShownLayer::picture ? "exact: as psivox render draws it, after "
                                          : "complete, after ") +
           format_ms(refine_ms_) +
           (estimated_rms_ ? ", error about " + digits_of(*estimated_rms_) : "");
  if (const auto stage = maker_.progress()) return stage->first + percent(stage->second);
  if (!shown_) return "";
  char rung[64];
  std::snprintf(rung, sizeof rung, "preview, 1/%g of the size, %s", rung_.divisor,
                format_ms(preview_ms_).c_str());
  return rung;
}

void Viewer::draw_status() {
  std::string text = status();
  if (layer_ != ShownLayer::picture && layer_range_ != glm::dvec2(0)) {
    static constexpr const char* what[] = {"", "segments of a ray", "depth [world units]",
                                           "error of radiance and alpha"};
    char range[100];
    std::snprintf(range, sizeof range, "; %s from %.4g (violet) to %.4g (yellow)",
                  what[static_cast<int>(layer_)], layer_range_.x, layer_range_.y);
    text += range;
  } else if (layer_ == ShownLayer::error) {
    text += "; the error is computed once the picture is at rest";
  }
  if (save_.running()) text += "; saving " + save_.what();
  const ImGuiIO& io = ImGui::GetIO();
  ImDrawList& list = *ImGui::GetForegroundDrawList();
  const auto s = static_cast<float>(gui_.scale());
  const float wrap = io.DisplaySize.x - 20 * s;
  float bottom = io.DisplaySize.y - 8 * s;
  const auto print = [&](ImU32 colour, const std::string& what) {
    const ImVec2 size = ImGui::CalcTextSize(what.c_str(), nullptr, false, wrap);
    const float y = bottom - size.y;
    bottom = y - 10 * s;
    list.AddRectFilled({6 * s, y - 3 * s}, {14 * s + size.x, y + size.y + 3 * s},
                       IM_COL32(0, 0, 0, 150), 3 * s);
    list.AddText(nullptr, 0, {10 * s, y}, colour, what.c_str(), nullptr, wrap);
  };
  if (!text.empty()) print(IM_COL32(220, 220, 220, 255), text);
  if (Clock::now() - message_since_ > message_time) return;
  if (!last_error_.empty())
    print(IM_COL32(255, 120, 100, 255), last_error_);
  else if (!message_.empty())
    print(IM_COL32(150, 220, 150, 255), message_);
}

void Viewer::draw_help() {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({io.DisplaySize.x / 2, io.DisplaySize.y / 2}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  if (ImGui::Begin("Keys", &show_help_,
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse)) {
    for (const KeyHelp& row : key_help) {
      ImGui::TextUnformatted(row.keys);
      ImGui::SameLine(static_cast<float>(170 * gui_.scale()));
      ImGui::TextUnformatted(row.what);
    }
  }
  ImGui::End();
}

void Viewer::draw_box() {
  if (!box_ || volume_) return;
  const auto& [low, high] = *box_;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const auto corner = [&](int i) {
    return glm::dvec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  };
  for (int i = 0; i < 8; ++i)
    for (int axis = 1; axis < 8; axis *= 2) {
      if (i & axis) continue;
      glm::dvec2 a, b;
      if (!navigation_.project(corner(i), a) || !navigation_.project(corner(i | axis), b)) continue;
      list.AddLine({static_cast<float>(a.x), static_cast<float>(a.y)},
                   {static_cast<float>(b.x), static_cast<float>(b.y)},
                   IM_COL32(200, 200, 200, 255));
    }
}

void Viewer::draw_timeline() {
  if (sequence_.empty()) return;
  const ImGuiIO& io = ImGui::GetIO();
  const float height = static_cast<float>(62 * gui_.scale());
  // above the status line
  const float bottom = io.DisplaySize.y - static_cast<float>(34 * gui_.scale());
  ImGui::SetNextWindowPos({io.DisplaySize.x * 0.25f, bottom - height});
  ImGui::SetNextWindowSize({io.DisplaySize.x * 0.5f, height});
  if (ImGui::Begin("Frames", nullptr, ImGuiWindowFlags_NoDecoration)) {
    if (ImGui::Button(sequence_.playing ? "pause" : "play")) sequence_.playing = !sequence_.playing;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(static_cast<float>(120 * gui_.scale()));
    slide("frames/s", sequence_.rate, 1, 60, "%.0f");
    if (sequence_.missing()) {
      ImGui::SameLine();
      ImGui::TextColored({1, 0.6f, 0.4f, 1}, "%d missing", sequence_.missing());
    }
    int frame = sequence_.current();
    ImGui::SetNextItemWidth(-1);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    if (ImGui::SliderInt("##frame", &frame, sequence_.first(), sequence_.last()))
      sequence_.go_to(frame);
    const float width = ImGui::GetItemRectSize().x;
    const int count = sequence_.last() - sequence_.first();
    for (int i = sequence_.first(); count < 5000 && i <= sequence_.last(); ++i)
      if (!sequence_.file(i)) {
        const float x = corner.x + width * static_cast<float>(i - sequence_.first()) /
                                       static_cast<float>(std::max(count, 1));
        ImGui::GetWindowDrawList()->AddLine({x, corner.y - 3}, {x, corner.y + 3},
                                            IM_COL32(255, 120, 80, 255), 2);
      }
  }
  ImGui::End();
}

}  // namespace psivox::view
