#include "psivox/picture_file.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "canvas.h"
#include "medium/backdrop.h"
#include "psivox/camera.h"
#include "scene/color.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr int color_count = 256;

template <typename ColorOfValue>
ColorScale scale_of(const View& view, double min, double max, const ColorOfValue& color) {
  ColorScale scale{view.scene.grid, min, max, {}};
  for (int i = 0; i < color_count; ++i)
    scale.colors.push_back(view.scene.resolved_luminance() *
                           color(std::lerp(min, max, i / double(color_count - 1))));
  return scale;
}

using image_io::Canvas;
using image_io::fitted;
using image_io::Rectangle;
using image_io::TextPicture;

struct Label {
  double place = 0;  ///< 0 at the bar's lower end, 1 at its upper one
  TextPicture text;
};

std::vector<Label> labels_of(const ColorScale& scale, double size, int room) {
  std::vector<Label> labels;
  for (const double value : round_values(scale.min, scale.max, 5))
    labels.push_back({(value - scale.min) / (scale.max - scale.min),
                      fitted(formatted("%.6g", value), size, room)});
  return labels;
}

/// Greatest width of the bar [picture widths].
constexpr double most_width = 0.25;

/// The greatest of 1, 2, 5, 10, 20, ... and of 0.5, 0.2, ... that is not above a length.
double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {10.0, 5.0, 2.0})
    if (factor * power <= length * (1 + 1e-9)) return factor * power;
  return power;
}

}  // namespace

std::optional<ColorScale> color_scale(const View& view) {
  const Scene& scene = view.scene;
  if (scene.windows()) {
    if (!scene.colormap && !scene.shows(Shows::value)) return std::nullopt;
    const glm::dvec2 range = scene.range->ends;
    return scale_of(view, range.x, range.y, [&](double value) {
      const double u = (value - range.x) / (range.y - range.x);
      return scene.colormap ? colormap_color(*scene.colormap, u) : glm::dvec3(u);
    });
  }
  if (scene.transfer_function.empty()) return std::nullopt;
  const TransferFunction function = read_transfer_function(scene.transfer_function);
  const double first = function.points().empty() ? 0 : function.points().front().value;
  const double last = function.points().empty() ? 0 : function.points().back().value;
  if (!function.has_color() || !(first < last)) return std::nullopt;
  return scale_of(view, first, last, [&](double value) { return function.at(value).color; });
}

Legend legend_of(const View& view) {
  Legend legend;
  if (view.scene.color_bar) legend.colors = color_scale(view);
  if (view.scene.scale_bar) legend.lengths = scale_bar(view);
  legend.behind = Backdrop(view).pixels();
  return legend;
}

std::vector<double> round_values(double min, double max, int count) {
  const double rough = (max - min) / (count + 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= rough * (1 - 1e-9)) step = factor * power;
  std::vector<double> values;
  const double slack = 1e-9 * (max - min);  // a division's rounding
  for (double i = std::ceil((min - slack) / step); i * step <= max + slack; ++i)
    values.push_back(i == 0 ? 0 : i * step);
  return values;
}

bool draw_color_bar(Image& image, const ColorScale& scale, const Display& display) {
  const int strip = color_bar_strip({image.width, image.height});
  if (strip == 0) return false;
  const double size = strip / 7.0;
  const int pad = int(std::lround(0.6 * size)), tick = int(std::lround(0.3 * size));
  const int bar_width = int(std::lround(size)), bar_height = int(std::lround(0.6 * image.height));
  const int room = strip - 3 * pad;  // inside the ground, which ends before the picture's edge
  const TextPicture title = fitted(scale.title, size, room);
  const std::vector<Label> labels = labels_of(scale, size, room - bar_width - 2 * tick);
  Rectangle ground{0, 0, strip - pad, bar_height + title.height + 3 * pad};
  ground.x = image.width - strip;
  ground.y = (image.height - ground.height) / 2;

  Canvas canvas(image, display);
  const glm::dvec3 white = canvas.white();
  canvas.fill(ground, canvas.ground());
  const Rectangle bar{ground.x + pad, ground.y + 2 * pad + title.height, bar_width, bar_height};
  canvas.write(title, bar.x, ground.y + pad, white);
  for (int y = 0; y < bar.height; ++y) {
    const double place = 1 - (y + 0.5) / bar.height;
    const auto color = std::size_t(std::lround(place * double(scale.colors.size() - 1)));
    canvas.fill({bar.x, bar.y + y, bar.width, 1}, scale.colors[color]);
  }
  const int thick = std::max(1, int(std::lround(size / 14)));
  for (const Label& label : labels) {
    const int y = bar.y + int(std::lround((1 - label.place) * (bar.height - 1)));
    canvas.fill({bar.x + bar.width, y - thick / 2, tick, thick}, white);
    canvas.write(label.text, bar.x + bar.width + 2 * tick, y - label.text.height / 2, white);
  }
  return true;
}

ScaleBar scale_bar(const View& view) {
  const Camera& camera = view.camera;
  const glm::dvec3 middle = glm::mix(view.subject->box_min, view.subject->box_max, 0.5);
  double away = 1;  // of the plane, as which the bar is drawn
  if (!camera.orthographic) {
    away = glm::dot(middle - camera.position, camera.forward);
    if (!(away > 0)) away = glm::length(camera.target - camera.position);
  }
  const double width = 2 * camera.half_width * away;  // of the picture, in the world
  const double length = round_length(most_width * width);
  return {length, length / width};
}

bool draw_scale_bar(Image& image, const ScaleBar& bar, const Display& display) {
  const double size = std::clamp(image.height / 28.0, 11.0, 60.0);  // height of the letters
  if (image.width < 8 * size || image.height < 5 * size) return false;
  const int pad = int(std::lround(0.6 * size)), thick = std::max(2, int(std::lround(size / 7)));
  const int width = int(std::lround(bar.width * image.width));
  const image_io::TextPicture text =
      image_io::fitted(formatted("%.6g", bar.length), size, image.width / 4);
  image_io::Canvas canvas(image, display);
  image_io::Rectangle ground{pad, 0, std::max(width, text.width) + 2 * pad,
                             text.height + thick + 3 * pad};
  ground.y = image.height - pad - ground.height;
  canvas.fill(ground, canvas.ground());
  const int left = ground.x + (ground.width - width) / 2;
  canvas.write(text, left + (width - text.width) / 2, ground.y + pad, canvas.white());
  canvas.fill({left, ground.y + 2 * pad + text.height, width, thick}, canvas.white());
  return true;
}

}  // namespace psivox
