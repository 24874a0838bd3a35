#include "view/transfer_editor.h"

#include <imgui.h>
#include <imgui_stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/text.h"
#include "base/text_file.h"
#include "colour/colour.h"
#include "psivox/parameters.h"
#include "scene/transfer_function.h"
#include "view/widgets.h"

namespace psivox::view {
namespace {

namespace fs = std::filesystem;

ImU32 screen_colour(const glm::dvec3& linear) {
  const auto encoded = [](double v) { return float(srgb_from_linear(std::clamp(v, 0.0, 1.0))); };
  return ImGui::GetColorU32(ImVec4(encoded(linear.x), encoded(linear.y), encoded(linear.z), 1));
}

ImVec2 at(const glm::dvec2& p) { return {float(p.x), float(p.y)}; }

/// Side of a handle [pixels].
double handle_size() { return 0.8 * double(ImGui::GetFontSize()); }

double greatest(const TransferPoints& points) {
  double most = 0;
  for (const TransferPoint& p : points) most = std::max(most, p.attenuation);
  return most;
}

/// The function of a volume without one, which draws the same picture: the attenuation is the
/// value, and the colour white.
std::vector<TransferPoint> identity(const Histogram& histogram) {
  std::vector<TransferPoint> points;
  for (const double value :
       {histogram.min, 0.0, 0.5 * (histogram.min + histogram.max), histogram.max})
    if (points.empty() || value > points.back().value)
      points.push_back({value, std::max(value, 0.0)});
  return points;
}

double three_digits(double value) { return std::strtod(formatted("%.3g", value).c_str(), nullptr); }

/// A new folder for temporary files, of which nobody else knows or writes.
fs::path private_folder() {
  std::string name = (fs::temp_directory_path() / "psivox-XXXXXX").string();
  if (!mkdtemp(name.data()))
    throw Error(ExitCode::output, "cannot make a folder in " +
                                      in_quotes(fs::temp_directory_path().string()) + ": " +
                                      std::strerror(errno));
  return name;
}

/// The name, or with a number the first like it that no file has.
std::string unused_name(const std::string& stem) {
  for (int i = 1;; ++i) {
    std::string name = stem + (i > 1 ? "-" + std::to_string(i) : "") + ".json";
    if (!fs::exists(name)) return name;
  }
}

}  // namespace

TransferEditor::TransferEditor() : own_files_((private_folder() / "transfer-").string()) {}

TransferEditor::~TransferEditor() {
  std::error_code ignored;
  fs::remove_all(fs::path(own_files_).parent_path(), ignored);
}

void TransferEditor::take(const Volume& volume, const Scene& scene) {
  if (dragging_ || sliding_ || taken_from_ == volume.key ||
      (edits_ > 0 && scene.transfer_function == own_file()))
    return;
  taken_from_ = volume.key;
  scale_ = volume.fields.density->scale;
  selected_ = -1;
  const auto& function = volume.function;
  points_ = function && !function->has_gradient() ? function->points() : identity(volume.histogram);
  has_color_ = !function || function->has_color() || scene.luminance_grid.empty();
  canvas_.low = std::min(volume.histogram.min, points_.front().value);
  canvas_.high = std::max(volume.histogram.max, points_.back().value);
  // Points beyond the data need not be on the canvas.
  fit_top();
}

void TransferEditor::fit_top() {
  const double most = greatest(points_);
  canvas_.top = most > 0 ? 1.15 * most : 1;
}

std::optional<glm::dvec2> TransferEditor::place_of(std::size_t point) const {
  if (point >= points_.size() || canvas_.size.x <= 0) return std::nullopt;
  return canvas_.pixel_of(points_[point]);
}

void TransferEditor::draw_histogram(const Histogram& histogram) const {
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const double bins = double(histogram.counts.size());
  const double most = *std::max_element(histogram.counts.begin(), histogram.counts.end());
  for (int x = 0; x < int(canvas_.size.x) && most > 0; ++x) {
    const double value = canvas_.low + (x + 0.5) / canvas_.size.x * (canvas_.high - canvas_.low);
    const double bin = bins * (value - histogram.min) / (histogram.max - histogram.min);
    if (bin < 0 || bin >= bins) continue;
    // logarithmic, because a few values have nearly all voxels
    const double part = std::log1p(histogram.counts[std::size_t(bin)]) / std::log1p(most);
    list.AddRectFilled(
        at({canvas_.corner.x + x, canvas_.corner.y + canvas_.size.y * (1 - 0.9 * part)}),
        at({canvas_.corner.x + x + 1, canvas_.corner.y + canvas_.size.y}),
        IM_COL32(70, 74, 84, 255));
  }
}

bool TransferEditor::draw_canvas(const Histogram& histogram) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float strip = float(1.2 * handle_size());
  const float width = std::max(ImGui::GetContentRegionAvail().x - strip, 50.0f);
  const float height = 0.45f * width;
  canvas_.corner = {corner.x, corner.y};
  canvas_.size = {width, height};
  ImGui::InvisibleButton("canvas", {width, height},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  const bool hovered = ImGui::IsItemHovered();
  const bool changed = drag_points(hovered);

  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + width, corner.y + height}, IM_COL32(20, 20, 24, 255));
  draw_histogram(histogram);
  list.PushClipRect(corner, {corner.x + width, corner.y + height}, true);
  for (std::size_t i = 0; i + 1 < points_.size(); ++i)
    list.AddLine(at(canvas_.pixel_of(points_[i])), at(canvas_.pixel_of(points_[i + 1])),
                 IM_COL32(230, 230, 230, 255), 1.5f);
  list.AddLine(at({canvas_.corner.x, canvas_.pixel_of(points_.front()).y}),
               at(canvas_.pixel_of(points_.front())), IM_COL32(150, 150, 150, 255));
  list.AddLine(at(canvas_.pixel_of(points_.back())),
               at({canvas_.corner.x + width, canvas_.pixel_of(points_.back()).y}),
               IM_COL32(150, 150, 150, 255));
  list.PopClipRect();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const bool chosen = int(i) == selected_;
    const float radius = (chosen ? 0.55f : 0.4f) * ImGui::GetFontSize();
    list.AddCircleFilled(at(canvas_.pixel_of(points_[i])), radius,
                         screen_colour(has_color_ ? points_[i].color : glm::dvec3(0.8)));
    list.AddCircle(at(canvas_.pixel_of(points_[i])), radius, IM_COL32(255, 255, 255, 255));
  }
  return changed;
}

bool TransferEditor::slide_opacity() {
  ImGui::SetCursorScreenPos(at(canvas_.corner + glm::dvec2(canvas_.size.x, 0)));
  ImGui::InvisibleButton("opacity", at({1.5 * handle_size(), canvas_.size.y}));
  if (ImGui::IsItemDeactivated()) fit_top();
  const bool active = ImGui::IsItemActive();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("opacity of all points");
  const glm::dvec2 tip = place_of(Handle::opacity), half(0.5 * handle_size());
  ImGui::GetWindowDrawList()->AddTriangleFilled(at(tip + glm::dvec2(-half.x, 0)), at(tip + half),
                                                at(tip + glm::dvec2(half.x, -half.y)),
                                                IM_COL32(230, 230, 230, 255));
  sliding_ |= active;
  if (!active || ImGui::GetIO().MouseDelta.y == 0) return false;
  const double wanted = canvas_.attenuation_at(double(ImGui::GetIO().MousePos.y));
  const double factor = std::max(wanted, 1e-3 * canvas_.top) / greatest(points_);
  if (std::isfinite(factor))
    for (TransferPoint& p : points_) p.attenuation *= factor;
  return true;
}

bool TransferEditor::slide_range() {
  // the ends of the slider are below the points that they move
  ImGui::SetCursorScreenPos(at(canvas_.corner + glm::dvec2(-end_margin(), canvas_.size.y + 2)));
  range_place_ = double(ImGui::GetCursorScreenPos().y) + 0.5 * double(ImGui::GetFrameHeight());
  ImGui::SetNextItemWidth(float(canvas_.size.x + 2 * end_margin()));
  const double first = points_.front().value, width = points_.back().value - first;
  glm::dvec2 ends(first, first + width);
  const bool moved = slide_ends("##range", ends, {canvas_.low, canvas_.high});
  sliding_ |= ImGui::IsItemActive();
  if (ImGui::IsItemHovered() && !ImGui::IsItemActive())
    ImGui::SetTooltip("range of the values: its ends, or all of it");
  if (!moved) return false;
  for (TransferPoint& p : points_)
    p.value = width > 0 ? ends.x + (p.value - first) / width * (ends.y - ends.x) : ends.x;
  return true;
}

glm::dvec2 TransferEditor::place_of(Handle handle) const {
  const auto x_of = [&](const TransferPoint& p) {
    return std::clamp(canvas_.pixel_of(p).x, canvas_.corner.x, canvas_.corner.x + canvas_.size.x);
  };
  const double low = x_of(points_.front()), high = x_of(points_.back());
  if (handle == Handle::low) return {low, range_place_};
  if (handle == Handle::high) return {high, range_place_};
  if (handle == Handle::range) return {0.5 * (low + high), range_place_};
  const double part = std::min(greatest(points_) / canvas_.top, 1.0);
  return {canvas_.corner.x + canvas_.size.x + 0.6 * handle_size(),
          canvas_.corner.y + (1 - part) * canvas_.size.y};
}

bool TransferEditor::drag_points(bool hovered) {
  const ImGuiIO& io = ImGui::GetIO();
  const glm::dvec2 mouse{io.MousePos.x, io.MousePos.y};
  const auto nearest = [&] {
    int found = -1;
    double best = 0.8 * ImGui::GetFontSize();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const glm::dvec2 d = canvas_.pixel_of(points_[i]) - mouse;
      if (std::hypot(d.x, d.y) < best) {
        best = std::hypot(d.x, d.y);
        found = int(i);
      }
    }
    return found;
  };
  bool changed = false;
  if (hovered && ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
    const int hit = nearest();
    if (hit >= 0 && points_.size() > 2) {
      points_.erase(points_.begin() + hit);
      selected_ = -1;
      return true;
    }
  }
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) dragging_ = false;  // of a hidden panel
  if (hovered && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    selected_ = nearest();
    if (selected_ < 0) {
      TransferPoint added = canvas_.point_at(mouse);
      const auto next =
          std::upper_bound(points_.begin(), points_.end(), added.value,
                           [](double v, const TransferPoint& p) { return v < p.value; });
      added.color = next != points_.end() ? next->color : points_.back().color;
      selected_ = int(next - points_.begin());
      points_.insert(next, added);
      changed = true;
    }
    dragging_ = true;
  }
  dragging_ &= ImGui::IsMouseDown(ImGuiMouseButton_Left);
  const bool moves = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
  if (!dragging_ || selected_ < 0 || !moves) return changed;
  const auto i = std::size_t(selected_);
  TransferPoint moved = canvas_.point_at(mouse);
  moved.color = points_[i].color;
  if (i > 0) moved.value = std::max(moved.value, points_[i - 1].value);
  if (i + 1 < points_.size()) moved.value = std::min(moved.value, points_[i + 1].value);
  points_[i] = moved;
  return true;
}

bool TransferEditor::draw_selected() {
  if (selected_ < 0 || selected_ >= int(points_.size())) {
    ImGui::TextWrapped("click: add a point; drag: move it; right click: remove it");
    return false;
  }
  TransferPoint& point = points_[std::size_t(selected_)];
  bool changed = false;
  float rgb[3] = {float(point.color.x), float(point.color.y), float(point.color.z)};
  if (has_color_ && ImGui::ColorEdit3("colour", rgb, ImGuiColorEditFlags_Float)) {
    for (int c = 0; c < 3; ++c) point.color[c] = std::max(rgb[c], 0.0f);
    changed = true;
  }
  double attenuation = point.attenuation;
  const double least = 0, most = 1e30;
  if (ImGui::DragScalar("attenuation", ImGuiDataType_Double, &attenuation,
                        float(0.005 * canvas_.top), &least, &most, "%.5g")) {
    point.attenuation = std::max(attenuation, 0.0);
    canvas_.top = std::max(canvas_.top, 1.15 * point.attenuation);
    changed = true;
  }
  ImGui::Text("value %.5g", scale_.value_of(point.value));
  return changed;
}

void TransferEditor::write(const std::string& path) const {
  TransferPoints points = points_;
  for (TransferPoint& point : points) point.value = scale_.value_of(point.value);
  write_text(path, to_json(TransferFunction(std::move(points), has_color_)));
}

void TransferEditor::name(Scene& scene, const std::string& path) {
  set_valid(scene, "transfer-function", path);
  taken_from_.clear();
}

void TransferEditor::draw(Scene& scene, const Volume& volume, bool& open, bool goes_on) {
  take(volume, scene);
  sliding_ = false;  // of a hidden panel, too
  const Panel panel("Transfer function", &open);
  if (!panel) return;
  const bool dragged = draw_canvas(volume.histogram);
  const bool stretched = slide_opacity() | slide_range();
  if (draw_selected() || dragged || stretched) {
    // `auto` would undo a change of all attenuations at once.
    if (!scene.extinction) scene.extinction = three_digits(volume.extinction);
    if (!goes_on || edits_ == 0) ++edits_;
    write(own_file());
    set_valid(scene, "transfer-function", own_file());
  }
  ImGui::InputText("file", &path_);
  if (ImGui::Button("load")) {
    points_ = scaled_function(read_transfer_function(path_), scale_).points();
    selected_ = -1;
    name(scene, path_);
  }
  ImGui::SameLine();
  if (ImGui::Button("save")) {
    write(path_);
    name(scene, path_);
  }
  ImGui::SameLine();
  if (!scene.transfer_function.empty() && ImGui::Button("none")) name(scene, "");
}

std::optional<std::string> TransferEditor::keep(Scene& scene) {
  if (!scene.transfer_function.starts_with(own_files_)) return std::nullopt;
  const std::string name = unused_name("transfer");
  write_text(name, read_text(scene.transfer_function, "transfer function"));
  scene.transfer_function = name;
  return name;
}

}  // namespace psivox::view
