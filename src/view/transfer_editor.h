#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "view/function_handles.h"
#include "view/volume.h"

namespace psivox::view {

/// The panel of the transfer function, over the histogram of the values. An edited function is a
/// file of the viewer's own, so that the scene, the command line and a saved picture can name it.
class TransferEditor {
 public:
  TransferEditor();
  ~TransferEditor();
  TransferEditor(const TransferEditor&) = delete;
  TransferEditor& operator=(const TransferEditor&) = delete;

  /// Draws the panel; its close button clears `open`. True if the scene was changed: it then names
  /// the edited file. Throws Error(input), Error(output) for files.
  bool draw(Scene& scene, const Volume& volume, bool& open);

  /// If the scene names the viewer's own file, copies it to the working directory, has the scene
  /// name the copy and returns its name. Throws Error(output).
  std::optional<std::string> keep(Scene& scene);

  /// Where the window shows a point [pixels], if it does.
  std::optional<glm::dvec2> place_of(std::size_t point) const;
  const TransferPoints& points() const { return points_; }
  /// Where the window shows a handle [pixels].
  glm::dvec2 place_of(FunctionHandles::Handle handle) const {
    return FunctionHandles::place_of(handle, canvas_, points_);
  }

 private:
  void take(const Volume& volume, const Scene& scene);
  void draw_histogram(const Histogram& histogram) const;
  bool draw_canvas(const Histogram& histogram);
  bool drag_points(bool hovered);
  bool draw_selected();
  void write(Scene& scene);
  bool drag_handles();
  void fit_top();

  std::string own_file_;
  TransferPoints points_;
  bool has_color_ = true;
  std::string taken_from_;  ///< key of the volume whose function `points_` is
  int selected_ = -1;
  bool dragging_ = false;
  FunctionCanvas canvas_;
  FunctionHandles handles_;
  std::string path_ = "transfer.json";
};

}  // namespace psivox::view
