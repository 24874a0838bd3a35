#include "view/sliders.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "view/navigation.h"

namespace psivox::view {
namespace {

enum class Held { low, high, both };

/// The drag of a slider with two ends; only one goes on at a time.
struct Drag {
  Held held = Held::both;
  glm::dvec2 begun{0};  ///< the ends before it
  double from = 0;      ///< [pixels]
};

/// The track of a slider on the screen [pixels].
struct Track {
  ImVec2 corner;
  float width, height;
  glm::dvec2 limits;

  double grab() const { return end_margin(); }
  double left() const { return double(corner.x) + grab(); }
  double length() const { return std::max(double(width) - 2 * grab(), 1.0); }
  double per_pixel() const { return (limits.y - limits.x) / length(); }
  float place_of(double value) const {
    const double part = (std::clamp(value, limits.x, limits.y) - limits.x) / (limits.y - limits.x);
    return float(left() + part * length());
  }
};

Drag begin_drag(const Track& track, const glm::dvec2& ends) {
  const double mouse = double(ImGui::GetIO().MousePos.x);
  const double to_low = mouse - double(track.place_of(ends.x)),
               to_high = mouse - double(track.place_of(ends.y));
  const double reach = 2 * track.grab();
  Drag drag{Held::both, ends, mouse};
  // where both ends are near, the pointer's side decides
  if (std::abs(to_low) <= reach || std::abs(to_high) <= reach || to_low < 0 || to_high > 0)
    drag.held = to_low + to_high < 0 ? Held::low : Held::high;
  return drag;
}

glm::dvec2 dragged(const Drag& drag, const Track& track) {
  const glm::dvec2 limits = track.limits;
  const double by = (double(ImGui::GetIO().MousePos.x) - drag.from) * track.per_pixel();
  const double least = 1e-3 * (limits.y - limits.x);
  const auto at = [&](double value, double low, double high) {
    return std::clamp(rounded_to(value, least), low, high);
  };
  glm::dvec2 ends = drag.begun;
  if (drag.held == Held::low)
    ends.x = at(ends.x + by, limits.x, std::max(ends.y - least, limits.x));
  else if (drag.held == Held::high)
    ends.y = at(ends.y + by, std::min(ends.x + least, limits.y), limits.y);
  else if (ends.x + by < limits.x)
    ends = {limits.x, limits.x + ends.y - ends.x};
  else if (ends.y + by > limits.y)
    ends = {limits.y - (ends.y - ends.x), limits.y};
  else
    ends = {rounded_to(ends.x + by, least), rounded_to(ends.y + by, least)};
  return ends;
}

void draw_track(const Track& track, const glm::dvec2& ends, bool hovered, bool active) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImGuiStyle& style = ImGui::GetStyle();
  const auto colour = [](ImGuiCol which) { return ImGui::GetColorU32(which); };
  const ImVec2 corner = track.corner, end{corner.x + track.width, corner.y + track.height};
  const ImGuiCol frame = active    ? ImGuiCol_FrameBgActive
                         : hovered ? ImGuiCol_FrameBgHovered
                                   : ImGuiCol_FrameBg;
  list.AddRectFilled(corner, end, colour(frame), style.FrameRounding);
  const float low = track.place_of(ends.x), high = track.place_of(ends.y);
  const auto half = float(track.grab());
  list.AddRectFilled({low, corner.y + 0.3f * track.height}, {high, end.y - 0.3f * track.height},
                     colour(ImGuiCol_Header));
  for (const float x : {low, high})
    list.AddRectFilled({x - half, corner.y + 2}, {x + half, end.y - 2},
                       colour(active ? ImGuiCol_SliderGrabActive : ImGuiCol_SliderGrab),
                       style.GrabRounding);
  const std::string text = formatted("%.4g to %.4g", ends.x, ends.y);
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list.AddText({corner.x + 0.5f * (track.width - size.x), corner.y + style.FramePadding.y},
               colour(ImGuiCol_Text), text.c_str());
}

}  // namespace

bool slide(const char* label, double& value, double least, double most, const char* format) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &least, &most, format);
}

double end_margin() { return 0.25 * double(ImGui::GetFrameHeight()); }

bool slide_ends(const char* label, glm::dvec2& ends, const glm::dvec2& limits) {
  static Drag drag;
  const Track track{ImGui::GetCursorScreenPos(), ImGui::CalcItemWidth(), ImGui::GetFrameHeight(),
                    limits};
  ImGui::PushID(label);
  ImGui::InvisibleButton("ends", {track.width, track.height});
  ImGui::PopID();
  const bool active = ImGui::IsItemActive();
  if (ImGui::IsItemActivated()) drag = begin_drag(track, ends);
  draw_track(track, ends, ImGui::IsItemHovered(), active);
  if (*label != '#') {
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(label);
  }
  if (!active || double(ImGui::GetIO().MousePos.x) == drag.from) return false;
  const glm::dvec2 moved = dragged(drag, track);
  if (moved == ends) return false;
  ends = moved;
  return true;
}

}  // namespace psivox::view
