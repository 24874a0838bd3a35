#include "view/cut_panel.h"

#include <imgui.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/clip.h"
#include "view/navigation.h"
#include "view/sliders.h"

namespace psivox::view {
namespace {

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

/// The menu of axes. True if another one was chosen; the plane then goes through the middle.
bool choose_axis(const char* label, Plane& plane, const Subject& subject,
                 const glm::dvec3& forward) {
  const int now = axis_of(plane);
  const bool backwards = now != oblique && plane.normal[now] < 0;
  bool changed = false;
  if (!ImGui::BeginCombo(label, now == oblique ? "oblique" : axis_names[now])) return false;
  for (int axis = 0; axis < 3; ++axis)
    if (ImGui::Selectable(axis_names[axis], axis == now) && axis != now) {
      plane.normal = (backwards ? -1.0 : 1.0) * unit_axis(axis);
      changed = true;
    }
  if (ImGui::Selectable("the view", now == oblique)) {
    plane.normal = rounded_to(-forward, 1e-4);
    changed = true;
  }
  ImGui::EndCombo();
  if (changed) {
    const glm::dvec2 limits = extent(subject, direction_of(plane));
    place(plane, 0.5 * (limits.x + limits.y), limits);
  }
  return changed;
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

bool edit_box(std::optional<WorldBox>& clip, const Subject& subject) {
  bool on = clip.has_value();
  bool changed = ImGui::Checkbox("clip box", &on);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("--clip: draw only what is in a box");
  if (changed && on) clip = WorldBox{subject.box_min, subject.box_max};
  if (!on) {
    clip.reset();
    return changed;
  }
  for (int axis = 0; axis < 3; ++axis) {
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
  bool on = scene.clip_plane.has_value();
  bool changed = ImGui::Checkbox("clip plane", &on);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("--clip-plane: draw only what is on one side of a plane");
  if (changed && on) {
    scene.clip_plane = Plane{unit_axis(0)};
    const glm::dvec2 limits = extent(subject, unit_axis(0));
    place(*scene.clip_plane, 0.5 * (limits.x + limits.y), limits);
  }
  if (!on) {
    scene.clip_plane.reset();
    return changed;
  }
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

CutEdits edit_cuts(Scene& scene, const Subject& subject, const glm::dvec3& forward) {
  ImGui::PushItemWidth(0.6f * ImGui::GetWindowWidth());
  CutEdits edits = edit_slice(scene, subject, forward);
  edits.clipped |= edit_box(scene.clip, subject);
  edits.clipped |= edit_clip_plane(scene, subject, forward);
  ImGui::PopItemWidth();
  return edits;
}

}  // namespace psivox::view
