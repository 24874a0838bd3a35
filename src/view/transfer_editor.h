#pragma once

#include <algorithm>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "view/volume.h"

namespace psivox::view {

using TransferPoints = std::vector<TransferPoint>;

/// Where a transfer function is drawn: values from left to right, attenuation from bottom to top.
struct FunctionCanvas {
  glm::dvec2 corner{0}, size{0};      ///< of the window [pixels]
  double low = 0, high = 1, top = 1;  ///< values at the left and right, attenuation at the top

  glm::dvec2 pixel_of(const TransferPoint& point) const {
    return corner +
           size * glm::dvec2((point.value - low) / (high - low), 1 - point.attenuation / top);
  }
  double value_at(double x) const {
    return low + std::clamp((x - corner.x) / size.x, 0.0, 1.0) * (high - low);
  }
  /// Above the top too.
  double attenuation_at(double y) const { return std::max(1 - (y - corner.y) / size.y, 0.0) * top; }
  TransferPoint point_at(const glm::dvec2& pixel) const {
    TransferPoint point;
    point.value = value_at(pixel.x);
    point.attenuation = std::min(attenuation_at(pixel.y), top);
    return point;
  }
};

/// The panel of the transfer function, over the histogram of the values. An edited function is a
/// file of the viewer's own, so that the scene, the command line and a saved picture can name it.
class TransferEditor {
 public:
  TransferEditor();
  ~TransferEditor();
  TransferEditor(const TransferEditor&) = delete;
  TransferEditor& operator=(const TransferEditor&) = delete;

  /// Draws the panel; its close button clears `open`. A scene that is changed names the edited
  /// file: another one for each change, unless it `goes_on` with the last, so that the scene before
  /// names what it was drawn with. Throws Error(input), Error(output) for files.
  void draw(Scene& scene, const Volume& volume, bool& open, bool goes_on = false);

  /// If the scene names the viewer's own file, copies it to the working directory, has the scene
  /// name the copy and returns its name. Throws Error(output).
  std::optional<std::string> keep(Scene& scene);

  /// Where the window shows a point [pixels], if it does.
  std::optional<glm::dvec2> place_of(std::size_t point) const;
  const TransferPoints& points() const { return points_; }
  /// Handles that change all points at once: the ends of their range and the bar between them below
  /// the canvas, the opacity on its right.
  enum class Handle { low, high, range, opacity };
  /// Where the window shows a handle [pixels].
  glm::dvec2 place_of(Handle handle) const;

 private:
  void take(const Volume& volume, const Scene& scene);
  void draw_histogram(const Histogram& histogram) const;
  bool draw_canvas(const Histogram& histogram);
  bool drag_points(bool hovered);
  bool draw_selected();
  void write(const std::string& path) const;
  void name(Scene& scene, const std::string& path);
  bool slide_range();
  bool slide_opacity();
  void fit_top();

  std::string own_file() const { return own_files_ + std::to_string(edits_) + ".json"; }

  std::string own_files_;  ///< begins their names
  int edits_ = 0;
  TransferPoints points_;  ///< of scaled values
  ValueScale scale_;
  bool has_color_ = true;
  std::string taken_from_;  ///< key of the volume whose function `points_` is
  int selected_ = -1;
  bool dragging_ = false, sliding_ = false;
  FunctionCanvas canvas_;
  double range_place_ = 0;  ///< of the slider of the range, from top to bottom [pixels]
  std::string path_ = "transfer.json";
};

}  // namespace psivox::view
