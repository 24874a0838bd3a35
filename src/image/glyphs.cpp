#include "glyphs.h"

#include <algorithm>
#include <cmath>

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
  const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size));
  int ascent = 0, descent = 0, gap = 0;
  stbtt_GetFontVMetrics(&font(), &ascent, &descent, &gap);
  const auto advance_of = [](char c) {
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font(), static_cast<unsigned char>(c), &advance, &bearing);
    return advance;
  };
  float width = 0;
  for (const char c : text) width += scale * static_cast<float>(advance_of(c));

  TextPicture picture;
  picture.width = std::max(static_cast<int>(std::ceil(width)), 1);
  picture.height = std::max(static_cast<int>(std::ceil(size)), 1);
  picture.coverage.resize(static_cast<std::size_t>(picture.width) *
                          static_cast<std::size_t>(picture.height));
  const int baseline = static_cast<int>(std::lround(scale * static_cast<float>(ascent)));
  float x = 0;
  for (const char c : text) {
    int w = 0, h = 0, left = 0, top = 0;
    const float whole = std::floor(x);
    unsigned char* const glyph = stbtt_GetCodepointBitmapSubpixel(
        &font(), scale, scale, x - whole, 0, static_cast<unsigned char>(c), &w, &h, &left, &top);
    for (int gy = 0; gy < h; ++gy)
      for (int gx = 0; gx < w; ++gx) {
        const int px = static_cast<int>(whole) + left + gx, py = baseline + top + gy;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        float& at = picture.coverage[static_cast<std::size_t>(py * picture.width + px)];
        at = std::max(at, static_cast<float>(glyph[gy * w + gx]) / 255);
      }
    stbtt_FreeBitmap(glyph, nullptr);
    x += scale * static_cast<float>(advance_of(c));
  }
  return picture;
}

}  // namespace psivox::image_io
