// What stands around the volume in a picture: the axes, a box with ticks, a title.

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <optional>

#include "base/text.h"
#include "image/canvas.h"
#include "psivox/camera.h"
#include "psivox/picture_file.h"

namespace psivox {
namespace {

constexpr std::array axis_names{"x", "y", "z"};
constexpr glm::dvec3 axis_colors[] = {{0.8, 0.05, 0.05}, {0.05, 0.5, 0.05}, {0.1, 0.2, 0.9}};

glm::dvec2 unit(const glm::dvec2& v) {
  const double size = glm::length(v);
  return size > 0 ? v / size : glm::dvec2(0, 1);
}

/// The subject's box in the picture.
class PlacedBox {
 public:
  explicit PlacedBox(const View& view)
      : camera_(view.camera),
        corners_{view.subject->box_min, view.subject->box_max},
        size_(view.scene.resolution),
        to_picture_(camera_matrices(view.camera).world_to_ndc),
        middle_(place(0.5 * (corners_[0] + corners_[1])).value_or(0.5 * size_)) {}

  struct Edge {
    glm::dvec3 from, to;  ///< along an axis, ascending [world]
    int faces = 0;        ///< of its two that face the camera
  };
  Edge edge(int axis, int side) const {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const int sides[] = {side & 1, side >> 1};
    Edge edge;
    edge.from[axis] = corners_[0][axis];
    edge.to[axis] = corners_[1][axis];
    edge.from[b] = edge.to[b] = corners_[sides[0]][b];
    edge.from[c] = edge.to[c] = corners_[sides[1]][c];
    edge.faces = int(faces_camera(b, sides[0])) + int(faces_camera(c, sides[1]));
    return edge;
  }

  /// Unset behind the camera.
  std::optional<glm::dvec2> place(const glm::dvec3& point) const {
    const glm::dvec4 at = to_picture_ * glm::dvec4(point, 1);
    if (!(at.w > 0)) return {};
    return glm::dvec2(at) / at.w * size_;
  }
  const glm::dvec2& middle() const { return middle_; }

 private:
  bool faces_camera(int axis, int side) const {
    const double outwards = side ? 1 : -1;
    if (camera_.orthographic) return outwards * camera_.forward[axis] < 0;
    return outwards * (camera_.position[axis] - corners_[side][axis]) > 0;
  }

  const Camera& camera_;
  std::array<glm::dvec3, 2> corners_;
  glm::dvec2 size_;
  glm::dmat4 to_picture_;
  glm::dvec2 middle_;
};

void add_ticks(const PlacedBox& box, int axis, const PlacedBox::Edge& edge, double letter,
               Legend& legend) {
  const double low = edge.from[axis], high = edge.to[axis];
  glm::dvec3 point = edge.from;
  for (const double value : round_values(low, high, 3)) {
    point[axis] = value;
    const auto at = box.place(point);
    if (!at) continue;
    const glm::dvec2 away = unit(*at - box.middle());
    legend.lines.push_back({*at, *at + 0.35 * letter * away});
    legend.texts.push_back({*at + 0.5 * letter * away, away, formatted("%.6g", value)});
  }
  const auto from = box.place(edge.from), to = box.place(edge.to);
  legend.texts.push_back({*to, unit(*to - *from), axis_names[std::size_t(axis)]});
}

void add_box(const View& view, double letter, Legend& legend) {
  const PlacedBox box(view);
  for (int axis = 0; axis < 3; ++axis) {
    std::optional<PlacedBox::Edge> best;  // of those on the outline: the lowest, or the leftmost
    double most = -HUGE_VAL;
    for (int side = 0; side < 4; ++side) {
      const PlacedBox::Edge edge = box.edge(axis, side);
      const auto from = box.place(edge.from), to = box.place(edge.to);
      if (!from || !to) continue;
      legend.lines.push_back({*from, *to, edge.faces == 0});
      const glm::dvec2 middle = 0.5 * (*from + *to);
      const double low = middle.y - 0.5 * middle.x;
      if (edge.faces != 1 || low <= most) continue;
      best = edge;
      most = low;
    }
    if (best) add_ticks(box, axis, *best, letter, legend);
  }
}

void add_axes(const View& view, double letter, Legend& legend) {
  const double above = view.scene.scale_bar ? 6 : 3;  // of the lower left corner
  const glm::dvec2 origin(3 * letter, view.scene.resolution.y - above * letter);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec2 way(view.camera.right[axis], -view.camera.up[axis]);
    const glm::dvec2 end = origin + 1.6 * letter * way;
    legend.lines.push_back({origin, end, false, axis_colors[axis]});
    legend.texts.push_back({end, unit(way), axis_names[std::size_t(axis)]});
  }
}

}  // namespace

void add_annotations(const View& view, Legend& legend) {
  const Scene& scene = view.scene;
  const double letter = letter_size(scene.resolution.y);
  if (scene.box) add_box(view, letter, legend);
  if (scene.axes) add_axes(view, letter, legend);
  if (!scene.title.empty())
    legend.texts.push_back({{scene.resolution.x / 2.0, 0.5 * letter}, {0, 1}, scene.title});
}

void draw_lines_behind(Image& image, const Legend& legend, const Display& display) {
  image_io::Canvas canvas(image, display);
  const double thick = std::max(1.0, letter_size(image.height) / 14);
  for (const LegendLine& line : legend.lines)
    if (line.behind)
      canvas.line(line.from, line.to, thick, canvas.shown(line.color.value_or(glm::dvec3(0.3))),
                  /*under=*/true);
}

void draw_annotations(Image& image, const Legend& legend, double ink, const Display& display) {
  image_io::Canvas canvas(image, display);
  const double letter = letter_size(image.height), thick = std::max(1.0, letter / 14);
  for (const LegendLine& line : legend.lines)
    if (!line.behind)
      canvas.line(line.from, line.to, line.color ? 2 * thick : thick,
                  canvas.shown(line.color.value_or(glm::dvec3(ink))));
  for (const LegendText& text : legend.texts) {
    const image_io::TextPicture letters = image_io::fitted(text.text, letter, image.width);
    const glm::dvec2 half(0.5 * letters.width, 0.5 * letters.height);
    const glm::dvec2 middle = text.at + text.away * (half + 0.1 * letter);
    canvas.write(letters, int(std::lround(middle.x - half.x)), int(std::lround(middle.y - half.y)),
                 canvas.shown(glm::dvec3(ink)));
  }
}

}  // namespace psivox
