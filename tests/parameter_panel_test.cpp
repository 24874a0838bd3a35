// The panel of parameters by itself, without a device.

#include <gtest/gtest.h>
#include <imgui.h>

#include <string>
#include <vector>

#include "view/widgets.h"

namespace psivox::view {
namespace {

/// ImGui with a window that holds the panel.
class Panel {
 public:
  Panel() : before_(ImGui::GetCurrentContext()), own_(ImGui::CreateContext()) {
    ImGui::SetCurrentContext(own_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {width + 100, height + 400};
    unsigned char* texels = nullptr;
    int columns = 0, rows = 0;
    io.Fonts->GetTexDataAsRGBA32(&texels, &columns, &rows);
    frame();
  }
  ~Panel() {
    ImGui::DestroyContext(own_);
    ImGui::SetCurrentContext(before_);
  }

  /// Clicks each row once, left of the middle of its widget. Returns how many lists that opened.
  int click_rows() {
    int opened = 0;
    for (float y = row_height_; y < height; y += row_height_) {
      click(0.2f * width, y);
      if (!has_list()) continue;
      ++opened;
      click(width + 50, height + 200);
    }
    return opened;
  }

  Scene scene{};

 private:
  static constexpr float width = 400, height = 2000;

  static bool has_list() {
    return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
  }

  void frame() {
    ImGui::GetIO().DeltaTime = 0.02f;
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({width, height});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove);
    row_height_ = ImGui::GetFrameHeightWithSpacing();
    for (int group = 0; group <= int(ParameterGroup::machine); ++group)
      edit_group(ParameterGroup(group), scene, {grids_, {}, [](const std::string&) {}});
    ImGui::End();
    ImGui::Render();
  }

  void click(float x, float y) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {x, y};
    frame();
    for (const bool down : {true, false}) {
      io.MouseDown[0] = down;
      frame();
    }
    frame();
  }

  ImGuiContext* before_;
  ImGuiContext* own_;
  std::vector<std::string> grids_{"density", "color", "color"};
  float row_height_ = 0;
};

TEST(ParameterPanel, EveryListOpens) {
  Panel panel;
  // the second time those groups are open that the first time closes, and the other way round
  const int opened = panel.click_rows() + panel.click_rows();
  EXPECT_GE(opened, 12);
}

}  // namespace
}  // namespace psivox::view
