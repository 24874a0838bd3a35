#include "psivox/picture_file.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "canvas.h"
#include "medium/backdrop.h"
#include "medium/label_function.h"
#include "psivox/camera.h"
#include "scene/color.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr int color_count = 256;

/// `color`: of a scaled value.
template <typename ColorOfValue>
ColorScale scale_of(const View& view, const glm::dvec2& ends, const ColorOfValue& color) {
  const std::optional<std::string>& title = view.scene.color_bar;
  const ValueScale& values = view.medium.density->scale;
  ColorScale scale{title && !title->empty() ? *title : view.scene.grid,
                   values.value_of(ends.x),
                   values.value_of(ends.y),
                   {},
                   values};
  for (int i = 0; i < color_count; ++i)
    scale.colors.push_back(color(std::lerp(ends.x, ends.y, i / double(color_count - 1))));
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

/// 1, 2 and 5 times powers of 10 within [min, max] above 0; the powers alone if these are enough,
/// or some of them.
std::vector<double> decades(double min, double max) {
  constexpr int fewest = 3, most = 8;
  const auto first = int(std::ceil(std::log10(min) - 1e-9)),
             last = int(std::floor(std::log10(max) + 1e-9));
  const int step = (last - first + most) / most;
  std::vector<double> values;
  for (int power = first - 1; power <= last; ++power)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10, power);
      const bool wanted = factor == 1 ? (power - last) % step == 0 : last - first + 1 < fewest;
      if (wanted && value >= min * (1 - 1e-9) && value <= max * (1 + 1e-9)) values.push_back(value);
    }
  return values;
}

std::vector<Label> labels_of(const ColorScale& scale, double size, int room) {
  std::vector<Label> labels;
  for (const double value : bar_values(scale))
    labels.push_back({bar_place(scale, value), fitted(formatted("%.6g", value), size, room)});
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

/// Each label's colour, as a band of the bar.
ColorScale scale_of_labels(const View& view) {
  constexpr int rows = 8;  // of a band
  const Field& density = *view.medium.density;
  ColorScale scale = scale_of(view, {0, 1}, [](double) { return glm::dvec3(0); });
  scale.colors.clear();
  for (const LabelColor& label : label_colors(density)) {
    scale.labels.push_back(density.scale.value_of(double(label.value)));
    scale.colors.insert(scale.colors.end(), rows, label.color);
  }
  scale.min = scale.labels.front();
  scale.max = scale.labels.back();
  return scale;
}

}  // namespace

std::vector<double> bar_values(const ColorScale& scale) {
  if (!scale.labels.empty()) {
    constexpr std::size_t most = 24;
    std::vector<double> some;
    for (std::size_t i = 0; i < scale.labels.size(); i += 1 + (scale.labels.size() - 1) / most)
      some.push_back(scale.labels[i]);
    return some;
  }
  if (scale.values.is_linear()) return round_values(scale.min, scale.max, 5);
  std::vector<double> values;
  if (scale.values.kind == ValueScale::Kind::log) {
    values = decades(scale.min, scale.max);
  } else {
    const double unit = *scale.values.unit;
    if (scale.min < -unit)
      for (const double value : decades(unit, -scale.min)) values.push_back(-value);
    if (scale.min <= 0 && scale.max >= 0) values.push_back(0);
    if (scale.max > unit)
      for (const double value : decades(unit, scale.max)) values.push_back(value);
  }
  return values.size() > 1 ? values : round_values(scale.min, scale.max, 5);
}

double bar_place(const ColorScale& scale, double value) {
  if (!scale.labels.empty()) {
    const auto before = std::ranges::lower_bound(scale.labels, value) - scale.labels.begin();
    return (double(before) + 0.5) / double(scale.labels.size());
  }
  const double low = scale.values.scaled(scale.min);
  return (scale.values.scaled(value) - low) / (scale.values.scaled(scale.max) - low);
}

std::optional<ColorScale> color_scale(const View& view) {
  const Scene& scene = view.scene;
  if (scene.colormap == Colormap::labels) return scale_of_labels(view);
  const ValueScale& values = view.medium.density->scale;
  if (scene.windows()) {
    if (!scene.colormap && !scene.shows(Shows::value)) return std::nullopt;
    const glm::dvec2 ends(values.scaled(scene.range->ends.x), values.scaled(scene.range->ends.y));
    return scale_of(view, ends, [&](double value) {
      const double u = (value - ends.x) / (ends.y - ends.x);
      return scene.colormap ? colormap_color(*scene.colormap, u) : glm::dvec3(u);
    });
  }
  if (scene.transfer_function.empty()) return std::nullopt;
  const TransferFunction function =
      scaled_function(read_transfer_function(scene.transfer_function), values);
  if (function.points().empty() || !function.has_color()) return std::nullopt;
  const glm::dvec2 ends(function.points().front().value, function.points().back().value);
  if (!(ends.x < ends.y)) return std::nullopt;
  return scale_of(view, ends, [&](double value) { return function.at(value).color; });
}

Legend legend_of(const View& view) {
  Legend legend;
  if (view.scene.color_bar) legend.colors = color_scale(view);
  if (view.scene.scale_bar) legend.lengths = scale_bar(view);
  legend.behind = Backdrop(view).pixels();
  add_annotations(view, legend);
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
  const double size = letter_size(image.height);
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
