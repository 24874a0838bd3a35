#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "canvas.h"
#include "psivox/camera.h"
#include "psivox/legend.h"

namespace psivox {
namespace {

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

}  // namespace

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

}  // namespace psivox
