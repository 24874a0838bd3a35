#include "view/function_handles.h"

#include <imgui.h>

#include <cmath>

namespace psivox::view {
namespace {

using Handle = FunctionHandles::Handle;

/// Smallest part of the canvas's width between the ends of the range.
constexpr double least_range = 1e-3;

double greatest(const TransferPoints& points) {
  double most = 0;
  for (const TransferPoint& p : points) most = std::max(most, p.attenuation);
  return most;
}

glm::dvec2 mouse_place() { return {ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y}; }

ImVec2 screen(const glm::dvec2& p) { return {static_cast<float>(p.x), static_cast<float>(p.y)}; }

constexpr ImU32 bar_colour = IM_COL32(70, 74, 84, 255),
                handle_colour = IM_COL32(230, 230, 230, 255);

void draw_shapes(const FunctionCanvas& canvas, const TransferPoints& points) {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const double half = 0.5 * FunctionHandles::size();
  const auto place = [&](Handle handle) {
    return FunctionHandles::place_of(handle, canvas, points);
  };
  const glm::dvec2 low = place(Handle::low), high = place(Handle::high),
                   opacity = place(Handle::opacity);
  list.AddRectFilled(screen(low - glm::dvec2(0, 0.4 * half)),
                     screen(high + glm::dvec2(0, 0.4 * half)), bar_colour);
  for (const glm::dvec2& at : {low, high})
    list.AddTriangleFilled(screen(at + glm::dvec2(0, -half)), screen(at + glm::dvec2(half, half)),
                           screen(at + glm::dvec2(-half, half)), handle_colour);
  list.AddTriangleFilled(screen(opacity + glm::dvec2(-half, 0)),
                         screen(opacity + glm::dvec2(half, half)),
                         screen(opacity + glm::dvec2(half, -half)), handle_colour);
}

}  // namespace

TransferPoints stretched(TransferPoints points, double low, double high) {
  const double first = points.front().value, width = points.back().value - first;
  for (TransferPoint& p : points)
    p.value = width > 0 ? low + (p.value - first) / width * (high - low) : low;
  return points;
}

TransferPoints scaled(TransferPoints points, double most) {
  const double before = greatest(points);
  for (TransferPoint& p : points)
    if (before > 0) p.attenuation *= most / before;
  return points;
}

double FunctionHandles::size() { return 0.8 * ImGui::GetFontSize(); }

glm::dvec2 FunctionHandles::place_of(Handle handle, const FunctionCanvas& canvas,
                                     const TransferPoints& points) {
  const double below = canvas.corner.y + canvas.size.y + 0.6 * size();
  const auto x_of = [&](const TransferPoint& p) {
    return std::clamp(canvas.pixel_of(p).x, canvas.corner.x, canvas.corner.x + canvas.size.x);
  };
  const double low = x_of(points.front()), high = x_of(points.back());
  switch (handle) {
    case Handle::low:
      return {low, below};
    case Handle::high:
      return {high, below};
    case Handle::range:
      return {0.5 * (low + high), below};
    case Handle::opacity:
      break;
  }
  const double part = std::min(greatest(points) / canvas.top, 1.0);
  return {canvas.corner.x + canvas.size.x + 0.6 * size(),
          canvas.corner.y + (1 - part) * canvas.size.y};
}

std::optional<Handle> FunctionHandles::pressed(const FunctionCanvas& canvas,
                                               const TransferPoints& points) const {
  const glm::dvec2 mouse = mouse_place();
  const double low = place_of(Handle::low, canvas, points).x,
               high = place_of(Handle::high, canvas, points).x;
  const double to_low = std::abs(mouse.x - low), to_high = std::abs(mouse.x - high);
  if (std::min(to_low, to_high) <= size()) return to_low < to_high ? Handle::low : Handle::high;
  if (mouse.x > low && mouse.x < high) return Handle::range;
  return std::nullopt;
}

TransferPoints FunctionHandles::moved(const FunctionCanvas& canvas, const glm::dvec2& mouse) const {
  const double low = begun_.front().value, high = begun_.back().value;
  const double least = least_range * (canvas.high - canvas.low);
  switch (*dragged_) {
    case Handle::low:
      return stretched(begun_, std::min(canvas.value_at(mouse.x), high - least), high);
    case Handle::high:
      return stretched(begun_, low, std::max(canvas.value_at(mouse.x), low + least));
    case Handle::range: {
      const double wanted = (mouse.x - from_.x) / canvas.size.x * (canvas.high - canvas.low);
      const double shift =
          std::clamp(wanted, std::min(canvas.low - low, 0.0), std::max(canvas.high - high, 0.0));
      return stretched(begun_, low + shift, high + shift);
    }
    case Handle::opacity:
      break;
  }
  return scaled(begun_, std::max(canvas.attenuation_at(mouse.y), 1e-3 * canvas.top));
}

std::optional<TransferPoints> FunctionHandles::draw(const FunctionCanvas& canvas,
                                                    const TransferPoints& points) {
  const auto strip = [&](const char* name, const glm::dvec2& at, const glm::dvec2& area) {
    ImGui::SetCursorScreenPos(screen(at));
    ImGui::InvisibleButton(name, screen(area));
    return ImGui::IsItemActivated();
  };
  const double side = 1.2 * size();
  std::optional<Handle> begun;
  if (strip("opacity", canvas.corner + glm::dvec2(canvas.size.x, 0), {side, canvas.size.y}))
    begun = Handle::opacity;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("opacity of all points");
  if (strip("range", canvas.corner + glm::dvec2(0, canvas.size.y), {canvas.size.x, side}))
    begun = pressed(canvas, points);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("range of the values: its ends, or all of it");
  if (begun) {
    dragged_ = begun;
    begun_ = points;
    from_ = mouse_place();
  }
  draw_shapes(canvas, points);
  // a panel that was hidden meanwhile has not seen the end of its last drag
  const bool another = ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !begun;
  if (another || !ImGui::IsMouseDown(ImGuiMouseButton_Left)) dragged_.reset();
  const ImVec2 delta = ImGui::GetIO().MouseDelta;
  if (!dragged_ || begun || (delta.x == 0 && delta.y == 0)) return std::nullopt;
  return moved(canvas, mouse_place());
}

}  // namespace psivox::view
