#include "canvas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "image/srgb_codes.h"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

// The font's file, byte for byte.
__asm__(
    ".section .rodata\n"
    ".hidden psivox_font\n"
    ".global psivox_font\n"
    "psivox_font: .incbin \"" PSIVOX_FONT
    "\"\n"
    ".previous\n");
extern "C" const unsigned char psivox_font[];

namespace psivox::image_io {
namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo info = [] {
    stbtt_fontinfo made{};
    stbtt_InitFont(&made, psivox_font, stbtt_GetFontOffsetForIndex(psivox_font, 0));
    return made;
  }();
  return info;
}

}  // namespace

TextPicture text_picture(std::string_view text, double size) {
  const float scale = stbtt_ScaleForPixelHeight(&font(), float(size));
  int ascent = 0, descent = 0, gap = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, &descent, &gap);
  const auto advance_of = [](char c) {
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font(), static_cast<unsigned char>(c), &advance, &bearing);
    return advance;
  };
  float width = 0;
  for (const char c : text) width += scale * float(advance_of(c));

  TextPicture picture;
  picture.width = std::max(int(std::ceil(width)), 1);
  picture.height = std::max(int(std::ceil(size)), 1);
  picture.coverage.resize(std::size_t(picture.width) * std::size_t(picture.height));
  const int baseline = int(std::lround(scale * float(ascent)));
  float x = 0;
  for (const char c : text) {
    int w = 0, h = 0, left = 0, top = 0;
    const float whole = std::floor(x);
    unsigned char* const glyph = stbtt_GetCodepointBitmapSubpixel(
        &font(), scale, scale, x - whole, 0, static_cast<unsigned char>(c), &w, &h, &left, &top);
    for (int gy = 0; gy < h; ++gy)
      for (int gx = 0; gx < w; ++gx) {
        const int px = int(whole) + left + gx, py = baseline + top + gy;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        float& at = picture.coverage[std::size_t(py * picture.width + px)];
        at = std::max(at, float(glyph[gy * w + gx]) / 255);
      }
    stbtt_FreeBitmap(glyph, nullptr);
    x += scale * float(advance_of(c));
  }
  return picture;
}

glm::dvec3 Canvas::shown(double light) const {
  return glm::dvec3(radiance_of_display(light, display_.tone_map) / display_.factor());
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

void Canvas::set(int x, int y, const glm::dvec3& color, double coverage) {
  if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
  float* const pixel = &image_.rgba()[4 * image_.index(x, y)];
  for (int c = 0; c < 3; ++c) pixel[c] = float(std::lerp(double(pixel[c]), color[c], coverage));
  pixel[3] = float(std::lerp(double(pixel[3]), 1.0, coverage));
}

TextPicture fitted(const std::string& text, double size, int room) {
  const TextPicture picture = text_picture(text, size);
  return picture.width <= room ? picture : text_picture(text, size * room / picture.width);
}

}  // namespace psivox::image_io
