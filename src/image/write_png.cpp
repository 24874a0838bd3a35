// Portable Network Graphics (W3C): RGBA of 8 bits, one IDAT chunk.

#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>
#include <vector>

#include "encode.h"
#include "psivox/error.h"
#include "srgb.h"

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

/// What the Paeth filter expects of a byte from those to the left, above, and above to the left.
int paeth(int left, int above, int corner) {
  const int a = std::abs(above - corner), b = std::abs(left - corner);
  const int c = std::abs(left + above - 2 * corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

/// Each row after the number of its filter.
std::string filtered(const std::vector<std::uint8_t>& pixels, std::size_t row_bytes) {
  constexpr char paeth_filter = 4;
  std::string result;
  result.reserve(pixels.size() + pixels.size() / row_bytes);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool first_row = i < row_bytes, first_column = i % row_bytes < 4;
    if (i % row_bytes == 0) result += paeth_filter;
    const int left = first_column ? 0 : pixels[i - 4];
    const int above = first_row ? 0 : pixels[i - row_bytes];
    const int corner = first_column || first_row ? 0 : pixels[i - row_bytes - 4];
    result += static_cast<char>(pixels[i] - paeth(left, above, corner));
  }
  return result;
}

std::string deflated(const std::string& bytes) {
  std::string zip(compressBound(bytes.size()), '\0');
  uLongf size = zip.size();
  const int status =
      compress2(reinterpret_cast<Bytef*>(zip.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_DEFAULT_COMPRESSION);
  if (status != Z_OK) throw std::bad_alloc();
  zip.resize(size);
  return zip;
}

std::string big_endian(std::size_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

/// A chunk is its length, its type, as many bytes, and the checksum of type and bytes.
void write_chunk(OutputFile& file, const char* type, const std::string& bytes) {
  if (bytes.size() > std::size_t(std::numeric_limits<std::int32_t>::max()))
    throw Error(ExitCode::failure, "the picture is too large for a PNG file");
  const std::string checked = type + bytes;
  const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size());
  file.write(big_endian(bytes.size()));
  file.write(checked);
  file.write(big_endian(crc));
}

/// An iTXt chunk: UTF-8, not compressed, no language.
void write_text(OutputFile& file, const std::string& keyword, const std::string& text) {
  if (keyword.empty() || keyword.size() > 79 || keyword.find('\0') != std::string::npos)
    throw Error(ExitCode::failure, "a PNG file cannot hold metadata of the name '" + keyword + "'");
  write_chunk(file, "iTXt", keyword + std::string(5, '\0') + text);
}

}  // namespace

void write_png(const Image& image, OutputFile& file) {
  file.write("\x89PNG\r\n\x1a\n");
  const std::string layout = {8, 6, 0, 0, 0};  // bits; RGBA; deflate; filters; not interlaced
  write_chunk(
      file, "IHDR",
      big_endian(std::size_t(image.width)) + big_endian(std::size_t(image.height)) + layout);
  write_chunk(file, "gAMA", big_endian(45455));     // 1/2.2, for readers that do not know sRGB
  write_chunk(file, "sRGB", std::string(1, '\0'));  // perceptual
  for (const auto& [name, value] : image.metadata) write_text(file, name, value);
  const std::size_t row_bytes = 4 * std::size_t(image.width);
  write_chunk(file, "IDAT", deflated(filtered(png_pixels(image.rgba()), row_bytes)));
  write_chunk(file, "IEND", "");
  file.commit();
}

}  // namespace psivox::image_io
