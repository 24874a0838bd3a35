#include <png.h>

#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "colour/srgb.h"
#include "encode.h"

namespace psivox::image_io {
namespace {

/// To [0, 1]; NaN to 0.
float clamped(float value) { return value > 0 ? (value < 1 ? value : 1.0f) : 0.0f; }

std::uint8_t quantised(float value) { return static_cast<std::uint8_t>(value * 255 + 0.5f); }

std::vector<std::uint8_t> png_pixels(std::span<const float> rgba) {
  std::vector<std::uint8_t> pixels(rgba.size());
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = clamped(rgba[i + 3]);
    for (std::size_t c = 0; c < 3 && alpha > 0; ++c) {
      pixels[i + c] = quantised(srgb_from_linear(clamped(rgba[i + c] / alpha)));
    }
    pixels[i + 3] = quantised(alpha);
  }
  return pixels;
}

/// Its texts point into the metadata.
std::vector<png_text> texts_of(const std::map<std::string, std::string>& metadata) {
  std::vector<png_text> texts;
  for (const auto& [name, value] : metadata) {
    png_text text{};
    text.compression = PNG_TEXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(name.c_str());  // libpng copies both
    text.text = const_cast<char*>(value.c_str());
    text.text_length = value.size();
    texts.push_back(text);
  }
  return texts;
}

struct Picture {
  int width, height;
  std::vector<std::uint8_t> pixels;  ///< R G B A
  std::vector<png_text> texts;
};

/// libpng leaves by longjmp where it fails: nothing here may want to be destroyed.
bool encode(png_structp png, png_infop info, const Picture& picture) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), 8, PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(png, info, picture.texts.data(), static_cast<int>(picture.texts.size()));
  png_write_info(png, info);
  const std::uint8_t* row = picture.pixels.data();
  for (int y = 0; y < picture.height; ++y, row += 4 * static_cast<std::size_t>(picture.width))
    png_write_row(png, row);
  png_write_end(png, info);
  return true;
}

/// Where libpng tells why it fails.
struct Sink {
  OutputFile& file;
  std::string failure;
};

void write_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto& sink = *static_cast<Sink*>(png_get_io_ptr(png));
  if (sink.file.write({reinterpret_cast<const char*>(bytes), count}) != count)
    png_error(png, "a write failed");
}

void fail(png_structp png, png_const_charp why) {
  static_cast<Sink*>(png_get_error_ptr(png))->failure = why;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

}  // namespace

void write_png(const Image& image, OutputFile& file) {
  const Picture picture{image.width, image.height, png_pixels(image.rgba()),
                        texts_of(image.metadata)};
  Sink sink{file, {}};
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, fail, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  bool ok = false;
  if (info) {
    png_set_write_fn(png, &sink, write_bytes, nullptr);
    ok = encode(png, info, picture);
  }
  png_destroy_write_struct(&png, &info);
  file.commit(ok, sink.failure);
}

}  // namespace psivox::image_io
