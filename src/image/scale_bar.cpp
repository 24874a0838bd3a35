#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "canvas.h"
#include "psivox/legend.h"

namespace psivox {
namespace {

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
