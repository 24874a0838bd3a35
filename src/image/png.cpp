#include <png.h>

#include <bit>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "colour/colour.h"
#include "formats.h"
#include "psivox/error.h"
#include "srgb_codes.h"

namespace psivox::image_io {
namespace {

/// Keeps why libpng fails.
void fail(png_structp png, png_const_charp why) {
  *static_cast<std::string*>(png_get_error_ptr(png)) = why;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// A PNG that is being read. Where libpng fails it leaves a member function by longjmp: none of
/// them has anything to destroy.
class PngFile {
 public:
  explicit PngFile(const std::filesystem::path& path)
      : file_(std::fopen(path.c_str(), "rb")),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure_, fail, ignore_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {}
  ~PngFile() {
    png_destroy_read_struct(&png_, &info_, nullptr);
    if (file_) std::fclose(file_);
  }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  /// Why a call failed.
  const std::string& failure() const { return failure_; }
  int width() const { return int(png_get_image_width(png_, info_)); }
  int height() const { return int(png_get_image_height(png_, info_)); }

  /// Asks for every kind of pixel as R G B A of 16 bits.
  bool read_header() {
    if (!file_ || !info_ || setjmp(png_jmpbuf(png_))) return false;
    png_init_io(png_, file_);
    // each text unpacks to at most 8 MB; later ones are left out
    png_set_chunk_cache_max(png_, 32);
    png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png_, info_);
    png_set_expand_16(png_);
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 0xffff, PNG_FILLER_AFTER);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  /// Codes of two bytes, the most significant first, and what comes behind the pixels.
  bool read_pixels(png_bytep codes) {
    if (setjmp(png_jmpbuf(png_))) return false;
    const std::size_t row = png_get_rowbytes(png_, info_);
    for (int pass = 0; pass < passes_; ++pass)
      for (int y = 0; y < height(); ++y) png_read_row(png_, codes + std::size_t(y) * row, nullptr);
    png_read_end(png_, info_);
    return true;
  }

  /// The exponent of the colours' encoding; none: sRGB, which the PNG specification advises where
  /// a file says nothing.
  std::optional<float> gamma() const {
    double encoding = 0;
    if (png_get_valid(png_, info_, PNG_INFO_sRGB) || !png_get_gAMA(png_, info_, &encoding))
      return std::nullopt;
    return float(1 / encoding);
  }

  std::map<std::string, std::string> texts() const {
    png_textp texts = nullptr;
    const int count = png_get_text(png_, info_, &texts, nullptr);
    std::map<std::string, std::string> metadata;
    for (int i = 0; i < count; ++i) metadata[texts[i].key] = texts[i].text;
    return metadata;
  }

 private:
  std::FILE* file_;
  std::string failure_ = "it cannot be opened";
  png_structp png_;
  png_infop info_;
  int passes_ = 1;
};

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
  int width, height, bits;
  bool srgb;
  const void* pixels;  ///< codes of R G B A, of 8 or 16 bits
  std::vector<png_text> texts;
};

/// libpng leaves by longjmp where it fails: nothing here may want to be destroyed.
bool encode(png_structp png, png_infop info, const Picture& picture) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), picture.bits, PNG_COLOR_TYPE_RGB_ALPHA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // a third of the default's time for 4 % more bytes, on smoke and a cloud
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
  png_set_compression_level(png, 4);
  if (picture.srgb) png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(png, info, picture.texts.data(), int(picture.texts.size()));
  png_write_info(png, info);
  if (picture.bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  const auto* row = static_cast<const png_byte*>(picture.pixels);
  for (int y = 0; y < picture.height; ++y, row += png_get_rowbytes(png, info))
    png_write_row(png, row);
  png_write_end(png, info);
  return true;
}

void append(png_structp png, png_bytep bytes, std::size_t count) {
  bool fits = true;
  try {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(bytes), count);
  } catch (const std::bad_alloc&) {
    fits = false;
  }
  if (!fits) png_error(png, "it asks for more memory than there is");
}

/// The bytes of a PNG; empty with `failure` set if libpng fails.
std::string encoded(const Image& image, const WriteOptions& options, std::string& failure) {
  Picture picture{image.width,
                  image.height,
                  options.bits.value_or(8),
                  options.display.ocio.config.empty(),
                  nullptr,
                  texts_of(image.metadata)};
  std::vector<std::uint8_t> codes;
  std::vector<std::uint16_t> wide;
  if (picture.bits == 8)
    picture.pixels = (codes = srgb_codes<std::uint8_t>(image.rgba(), 4, options.display)).data();
  else
    picture.pixels = (wide = srgb_codes<std::uint16_t>(image.rgba(), 4, options.display)).data();
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, fail, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  bool ok = false;
  if (info) {
    png_set_write_fn(png, &bytes, append, nullptr);
    ok = encode(png, info, picture);
  }
  png_destroy_write_struct(&png, &info);
  return ok ? bytes : std::string();
}

}  // namespace

Image read_png(const std::filesystem::path& path) {
  PngFile png(path);
  const auto damaged = [&] { return read_error(path, "the PNG is damaged: " + png.failure()); };
  if (!png.read_header()) throw damaged();
  const std::size_t pixels = std::size_t(png.width()) * std::size_t(png.height());
  check_size(path, png.width(), png.height(), double(pixels), 4);

  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const auto codes = std::make_unique_for_overwrite<std::uint8_t[]>(8 * pixels);
  if (!png.read_pixels(codes.get())) throw damaged();

  Image image = rgba_image(png.width(), png.height());
  image.metadata = png.texts();
  const std::span<float> values = image.rgba();
  const auto value = [&](std::size_t i) {
    return float(codes[2 * i] << 8 | codes[2 * i + 1]) / 65535;
  };
  const std::optional<float> gamma = png.gamma();
  for (std::size_t i = 0; i < values.size(); i += 4) {
    values[i + 3] = value(i + 3);
    for (std::size_t c = i; c < i + 3; ++c) {
      const float linear = gamma ? std::pow(value(c), *gamma) : linear_from_srgb(value(c));
      values[c] = linear * values[i + 3];
    }
  }
  return image;
}

std::string png_bytes(const Image& image, const WriteOptions& options) {
  std::string failure, bytes = encoded(image, options, failure);
  if (bytes.empty()) throw Error(ExitCode::output, "a PNG cannot be made: " + failure);
  return bytes;
}

}  // namespace psivox::image_io
