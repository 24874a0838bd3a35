// A drawing as pixels. What has a distance is covered by it, half a pixel soft; letters are dots.

#include <algorithm>
#include <cmath>

#include "colour/srgb.h"
#include "study/drawing.h"
#include "study/letters.h"

namespace psivox {
namespace {

double linear(std::uint8_t code) { return linear_from_srgb(code / 255.0); }

class Raster {
 public:
  Raster(int width, int height, double scale) : scale_(scale) {
    image_.width = width;
    image_.height = height;
    const auto pixels = std::size_t(width) * std::size_t(height);
    image_.layers.push_back({"", {"R", "G", "B", "A"}, std::vector<float>(4 * pixels, 1.0f)});
  }

  void draw(const Drawing::Line& line) {
    const double dx = line.x2 - line.x1, dy = line.y2 - line.y1;
    const double length = std::hypot(dx, dy);
    if (line.dash <= 0 || length == 0) return stroke(line);
    for (double at = 0; at < length; at += 2 * line.dash) {
      const double a = at / length, b = std::min(at + line.dash, length) / length;
      stroke({line.x1 + a * dx, line.y1 + a * dy, line.x1 + b * dx, line.y1 + b * dy, line.width,
              line.ink});
    }
  }

  void draw(const Drawing::Mark& m) {
    const auto distance = [&](double x, double y) {
      const double dx = std::abs(x - m.x), dy = std::abs(y - m.y);
      switch (m.shape) {
        case Drawing::Shape::square:
          return std::max(dx, dy) - m.radius;
        case Drawing::Shape::diamond:
          return (dx + dy - m.radius) * 0.7071;
        case Drawing::Shape::ring:
          return std::abs(std::hypot(dx, dy) - m.radius) - 0.75;
        default:
          return std::hypot(dx, dy) - m.radius;
      }
    };
    const double r = m.radius + 1;
    fill(m.x - r, m.y - r, m.x + r, m.y + r, m.ink, distance);
  }

  void draw(const Drawing::Text& text) {
    constexpr double dot = 1, advance = (letter_columns + 1) * dot;
    const double width = double(text.text.size()) * advance - dot;
    const double shift = text.anchor == Drawing::Anchor::start    ? 0
                         : text.anchor == Drawing::Anchor::middle ? width / 2
                                                                  : width;
    for (std::size_t i = 0; i < text.text.size(); ++i) {
      const int c = static_cast<unsigned char>(text.text[i]);
      const std::uint8_t* columns = letters[c >= 32 && c < 127 ? c - 32 : '?' - 32];
      for (int column = 0; column < letter_columns; ++column)
        for (int row = 0; row < letter_rows; ++row) {
          if (!(columns[column] >> row & 1)) continue;
          const double along = double(i) * advance + column * dot - shift;
          const double down = (row - letter_rows) * dot;
          if (text.upwards)
            dot_at(text.x + down, text.y - along - dot, dot, text.ink);
          else
            dot_at(text.x + along, text.y + down, dot, text.ink);
        }
    }
  }

  Image image_;

 private:
  void stroke(const Drawing::Line& l) {
    const double dx = l.x2 - l.x1, dy = l.y2 - l.y1, square = dx * dx + dy * dy;
    const double r = l.width / 2 + 1;
    fill(std::min(l.x1, l.x2) - r, std::min(l.y1, l.y2) - r, std::max(l.x1, l.x2) + r,
         std::max(l.y1, l.y2) + r, l.ink, [&](double x, double y) {
           const double along =
               square > 0 ? std::clamp(((x - l.x1) * dx + (y - l.y1) * dy) / square, 0.0, 1.0) : 0;
           return std::hypot(x - l.x1 - along * dx, y - l.y1 - along * dy) - l.width / 2;
         });
  }

  void dot_at(double x, double y, double side, Ink ink) {
    fill(x, y, x + side, y + side, ink, [&](double px, double py) {
      return std::max(std::abs(px - x - side / 2), std::abs(py - y - side / 2)) - side / 2;
    });
  }

  /// The pixels of a box, in units, where `distance` to the shape [units] is below 0, or partly.
  template <typename Distance>
  void fill(double x0, double y0, double x1, double y1, Ink ink, Distance distance) {
    const double color[3] = {linear(ink.r), linear(ink.g), linear(ink.b)};
    const int left = std::max(int(std::floor(x0 * scale_)), 0);
    const int top = std::max(int(std::floor(y0 * scale_)), 0);
    const int right = std::min(int(std::ceil(x1 * scale_)), image_.width);
    const int bottom = std::min(int(std::ceil(y1 * scale_)), image_.height);
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        const double d = distance((x + 0.5) / scale_, (y + 0.5) / scale_) * scale_;
        const double cover = std::clamp(0.5 - d, 0.0, 1.0);
        float* pixel = &image_.rgba()[std::size_t(y * image_.width + x) * 4];
        for (int c = 0; c < 3; ++c)
          pixel[c] = float(double(pixel[c]) * (1 - cover) + color[c] * cover);
      }
  }

  double scale_;
};

}  // namespace

Image picture_of(const Drawing& drawing, int scale) {
  Raster raster(drawing.width * scale, drawing.height * scale, scale);
  for (const auto& item : drawing.items)
    std::visit([&](const auto& shape) { raster.draw(shape); }, item);
  return std::move(raster.image_);
}

}  // namespace psivox
