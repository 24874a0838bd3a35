#include "view/widgets.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "base/text.h"
#include "scene/cuts.h"
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

// --- planes and boxes --------------------------------------------------------------------

constexpr const char* axis_names[] = {"x", "y", "z"};
constexpr int oblique = 3;

/// The axis that a plane is across: 0, 1 or 2, else `oblique`.
int axis_of(const Plane& plane) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 rest = plane.normal;
    rest[axis] = 0;
    if (rest == glm::dvec3(0)) return axis;
  }
  return oblique;
}

glm::dvec3 unit_axis(int axis) {
  glm::dvec3 unit(0);
  unit[axis] = 1;
  return unit;
}

/// The unit vector along which a plane's position counts: its axis, or its normal.
glm::dvec3 direction_of(const Plane& plane) {
  const int axis = axis_of(plane);
  return axis == oblique ? glm::normalize(plane.normal) : unit_axis(axis);
}

/// Where the subject's box begins and ends along a direction [world].
glm::dvec2 extent(const Subject& subject, const glm::dvec3& along) {
  const glm::dvec3 middle = 0.5 * (subject.box_min + subject.box_max);
  const double reach = glm::dot(glm::abs(along), 0.5 * (subject.box_max - subject.box_min));
  return {glm::dot(along, middle) - reach, glm::dot(along, middle) + reach};
}

/// The plane's position along its direction, rounded to a ten-thousandth of the box.
void place(Plane& plane, double at, const glm::dvec2& limits) {
  plane.point = rounded_to(at, 1e-4 * (limits.y - limits.x)) * direction_of(plane);
}

/// The plane of that normal through the middle of the box.
Plane middle_plane(const glm::dvec3& normal, const Subject& subject) {
  Plane plane{normal};
  const glm::dvec2 limits = extent(subject, direction_of(plane));
  place(plane, 0.5 * (limits.x + limits.y), limits);
  return plane;
}

/// The menu of axes. True if another one was chosen; the plane then goes through the middle.
bool choose_axis(const char* label, Plane& plane, const Subject& subject,
                 const glm::dvec3& forward) {
  const int now = axis_of(plane);
  const bool backwards = now != oblique && plane.normal[now] < 0;
  if (!ImGui::BeginCombo(label, now == oblique ? "oblique" : axis_names[now])) return false;
  std::optional<glm::dvec3> normal;
  for (int axis = 0; axis < 3; ++axis)
    if (ImGui::Selectable(axis_names[axis], axis == now) && axis != now)
      normal = (backwards ? -1.0 : 1.0) * unit_axis(axis);
  if (ImGui::Selectable("the view", now == oblique)) normal = rounded_to(-forward, 1e-4);
  ImGui::EndCombo();
  if (normal) plane = middle_plane(*normal, subject);
  return normal.has_value();
}

bool edit_normal(Plane& plane, const Subject& subject) {
  if (axis_of(plane) != oblique) return false;
  glm::dvec3 normal = plane.normal;
  if (!ImGui::DragScalarN("normal", ImGuiDataType_Double, &normal.x, 3, 0.005f, nullptr, nullptr,
                          "%.3f") ||
      normal == glm::dvec3(0))
    return false;
  const double at = glm::dot(plane.point.value_or(glm::dvec3(0)), direction_of(plane));
  plane.normal = rounded_to(normal, 1e-4);
  place(plane, at, extent(subject, direction_of(plane)));
  return true;
}

bool slide_plane(const char* label, Plane& plane, const Subject& subject) {
  const glm::dvec3 along = direction_of(plane);
  const glm::dvec2 limits = extent(subject, along);
  double at = glm::dot(along, plane.point.value_or(glm::dvec3(0)));
  const bool moved = slide(label, at, limits.x, limits.y, "%.4g");
  if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
    ImGui::SetTooltip("place of the plane along its %s [world units]",
                      axis_of(plane) == oblique ? "normal" : "axis");
  if (moved) place(plane, at, limits);
  return moved;
}

CutEdits edit_slice(Scene& scene, const Subject& subject, const glm::dvec3& forward) {
  if (!scene.shows(Shows::plane)) return {};
  Plane plane = *with_planes(scene, subject).slice;
  ImGui::PushID("slice");
  CutEdits edits;
  edits.turned = choose_axis("slice across", plane, subject, forward);
  edits.sliced = edits.turned;
  edits.sliced |= edit_normal(plane, subject);
  edits.sliced |= slide_plane("slice at", plane, subject);
  ImGui::PopID();
  if (edits.sliced) scene.slice = plane;
  return edits;
}

/// The box that sets a cut to `start`, or unsets it.
template <typename Cut>
bool switch_cut(const char* label, const char* help, std::optional<Cut>& cut, const Cut& start) {
  bool on = cut.has_value();
  const bool changed = ImGui::Checkbox(label, &on);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
  if (changed) cut = on ? std::optional(start) : std::nullopt;
  return changed;
}

bool edit_box(std::optional<WorldBox>& clip, const Subject& subject) {
  bool changed = switch_cut("clip box", "--clip: draw only what is in a box", clip,
                            WorldBox{subject.box_min, subject.box_max});
  for (int axis = 0; clip && axis < 3; ++axis) {
    glm::dvec2 ends(clip->min[axis], clip->max[axis]);
    if (!slide_ends(axis_names[axis], ends, {subject.box_min[axis], subject.box_max[axis]}))
      continue;
    clip->min[axis] = ends.x;
    clip->max[axis] = ends.y;
    changed = true;
  }
  return changed;
}

bool edit_clip_plane(Scene& scene, const Subject& subject, const glm::dvec3& forward) {
  const bool changed =
      switch_cut("clip plane", "--clip-plane: draw only what is on one side of a plane",
                 scene.clip_plane, middle_plane(unit_axis(0), subject));
  if (!scene.clip_plane) return changed;
  Plane plane = *with_planes(scene, subject).clip_plane;
  ImGui::PushID("plane");
  bool edited = choose_axis("plane across", plane, subject, forward);
  edited |= edit_normal(plane, subject);
  edited |= slide_plane("plane at", plane, subject);
  if (ImGui::Button("other side")) {
    plane.normal = rounded_to(-plane.normal, 1e-4);
    edited = true;
  }
  ImGui::PopID();
  if (edited) scene.clip_plane = plane;
  return changed || edited;
}

}  // namespace

Panel::Panel(const char* title, bool* shown, int flags)
    : open_(ImGui::Begin(title, shown, flags)) {}

Panel::~Panel() { ImGui::End(); }

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

CutEdits edit_cuts(Scene& scene, const Subject& subject, const glm::dvec3& forward) {
  ImGui::PushItemWidth(0.6f * ImGui::GetWindowWidth());
  CutEdits edits = edit_slice(scene, subject, forward);
  edits.clipped |= edit_box(scene.clip, subject);
  edits.clipped |= edit_clip_plane(scene, subject, forward);
  ImGui::PopItemWidth();
  return edits;
}

}  // namespace psivox::view
