#include "canvas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/text.h"
#include "image/srgb_codes.h"
#include "psivox/error.h"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

namespace psivox::image_io {

namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo info = [] {
    if (embedded_font().empty())
      throw Error(ExitCode::usage, "this psivox draws no text: it was built without PSIVOX_FONT");
    const auto* const file =
        reinterpret_cast<const unsigned char*>(embedded_font().begin()->second.data());
    stbtt_fontinfo made{};
    stbtt_InitFont(&made, file, stbtt_GetFontOffsetForIndex(file, 0));
    return made;
  }();
  return info;
}

/// The characters of a text in UTF-8; bytes that are none stand for themselves.
std::vector<int> characters(std::string_view text) {
  std::vector<int> all;
  for (; !text.empty(); text.remove_prefix(first_letter(text).bytes)) {
    const char32_t code = first_letter(text).code;
    all.push_back(code == no_letter ? static_cast<unsigned char>(text[0]) : int(code));
  }
  return all;
}

}  // namespace

TextPicture text_picture(std::string_view text, double size) {
  const std::vector<int> letters = characters(text);
  const float scale = stbtt_ScaleForPixelHeight(&font(), float(size));
  int ascent = 0, descent = 0, gap = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, &descent, &gap);
  const auto advance_of = [](int letter) {
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font(), letter, &advance, &bearing);
    return advance;
  };
  float width = 0;
  for (const int letter : letters) width += scale * float(advance_of(letter));

  TextPicture picture;
  picture.width = std::max(int(std::ceil(width)), 1);
  picture.height = std::max(int(std::ceil(size)), 1);
  picture.coverage.resize(std::size_t(picture.width) * std::size_t(picture.height));
  const int baseline = int(std::lround(scale * float(ascent)));
  float x = 0;
  for (const int letter : letters) {
    int w = 0, h = 0, left = 0, top = 0;
    const float whole = std::floor(x);
    unsigned char* const glyph = stbtt_GetCodepointBitmapSubpixel(&font(), scale, scale, x - whole,
                                                                  0, letter, &w, &h, &left, &top);
    for (int gy = 0; gy < h; ++gy)
      for (int gx = 0; gx < w; ++gx) {
        const int px = int(whole) + left + gx, py = baseline + top + gy;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        float& at = picture.coverage[std::size_t(py * picture.width + px)];
        at = std::max(at, float(glyph[gy * w + gx]) / 255);
      }
    stbtt_FreeBitmap(glyph, nullptr);
    x += scale * float(advance_of(letter));
  }
  return picture;
}

glm::dvec3 Canvas::shown(const glm::dvec3& light) const {
  glm::dvec3 radiance;
  for (int c = 0; c < 3; ++c)
    radiance[c] = double(radiance_of_display(light[c], display_.tone_map)) / display_.factor();
  return radiance;
}

void Canvas::fill(const Rectangle& r, const glm::dvec3& color) {
  for (int y = r.y; y < r.y + r.height; ++y)
    for (int x = r.x; x < r.x + r.width; ++x) set(x, y, color, 1);
}

void Canvas::write(const TextPicture& text, int x, int y, const glm::dvec3& color) {
  for (int row = 0; row < text.height; ++row)
    for (int column = 0; column < text.width; ++column)
      set(x + column, y + row, color,
          double(text.coverage[std::size_t(row * text.width + column)]));
}

void Canvas::line(const glm::dvec2& from, const glm::dvec2& to, double thick,
                  const glm::dvec3& color, bool under) {
  const glm::dvec2 size(image_.width, image_.height);
  const glm::ivec2 first = glm::clamp(glm::min(from, to) - thick, glm::dvec2(0), size),
                   last = glm::clamp(glm::max(from, to) + thick, glm::dvec2(0), size - 1.0);
  const glm::dvec2 way = to - from;
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      const glm::dvec2 at = glm::dvec2(x, y) + 0.5 - from;
      const double along =
          std::clamp(glm::dot(at, way) / std::max(glm::dot(way, way), 1e-12), 0.0, 1.0);
      const double off = glm::length(at - along * way);
      if (off < 0.5 * (thick + 1)) set(x, y, color, std::min(1.0, 0.5 * (thick + 1) - off), under);
    }
}

void Canvas::set(int x, int y, const glm::dvec3& color, double coverage, bool under) {
  if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
  float* const pixel = &image_.rgba()[4 * image_.index(x, y)];
  if (under) {
    const double left = coverage * (1 - double(pixel[3]));
    for (int c = 0; c < 3; ++c) pixel[c] += float(left * color[c]);
    pixel[3] += float(left);
    return;
  }
  for (int c = 0; c < 3; ++c) pixel[c] = float(std::lerp(double(pixel[c]), color[c], coverage));
  pixel[3] = float(std::lerp(double(pixel[3]), 1.0, coverage));
}

TextPicture fitted(const std::string& text, double size, int room) {
  const TextPicture picture = text_picture(text, size);
  return picture.width <= room ? picture : text_picture(text, size * room / picture.width);
}

}  // namespace psivox::image_io
