#include <png.h>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>

#include "base/loaded_module.h"
#include "colour/srgb.h"
#include "format.h"
#include "picture_files.h"
#include "psivox/image.h"

namespace psivox::image_io {
namespace {

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
  int width() const { return static_cast<int>(png_get_image_width(png_, info_)); }
  int height() const { return static_cast<int>(png_get_image_height(png_, info_)); }

  /// Asks for every kind of pixel as R G B A of 16 bits.
  bool read_header() {
    if (!file_ || !info_ || setjmp(png_jmpbuf(png_))) return false;
    png_init_io(png_, file_);
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
      for (int y = 0; y < height(); ++y)
        png_read_row(png_, codes + static_cast<std::size_t>(y) * row, nullptr);
    png_read_end(png_, info_);
    return true;
  }

  /// The exponent of the colours' encoding; none: sRGB, which the PNG specification advises where
  /// a file says nothing.
  std::optional<float> gamma() const {
    double encoding = 0;
    if (png_get_valid(png_, info_, PNG_INFO_sRGB) || !png_get_gAMA(png_, info_, &encoding))
      return std::nullopt;
    return static_cast<float>(1 / encoding);
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

}  // namespace

Image read_png(const std::filesystem::path& path) {
  PngFile png(path);
  const auto damaged = [&] { return read_error(path, "the PNG is damaged: " + png.failure()); };
  if (!png.read_header()) throw damaged();
  const std::size_t pixels =
      static_cast<std::size_t>(png.width()) * static_cast<std::size_t>(png.height());
  check_size(path, png.width(), png.height(), double(pixels), 4);

  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const auto codes = std::make_unique_for_overwrite<std::uint8_t[]>(8 * pixels);
  if (!png.read_pixels(codes.get())) throw damaged();

  Image image{png.width(), png.height(), {{"", {"R", "G", "B", "A"}, {}}}, png.texts()};
  std::vector<float>& values = image.layers.front().values;
  values.resize(4 * pixels);
  const auto value = [&](std::size_t i) {
    return static_cast<float>(codes[2 * i] << 8 | codes[2 * i + 1]) / 65535;
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

namespace {

const PictureFiles* load_module(ExitCode if_missing) {
  std::string problem;
  const auto get = reinterpret_cast<GetPictureFiles>(
      load_symbol(PSIVOX_OIIO_MODULE, picture_files_symbol, /*shared=*/false, problem));
  if (get) return get();
  throw Error(if_missing,
              one_line("cannot load the module that reads and writes pictures: " + problem));
}

}  // namespace

const PictureFiles& picture_files(ExitCode if_missing) {
  static const PictureFiles* const loaded = load_module(if_missing);  // tried again if it throws
  return *loaded;
}

}  // namespace psivox::image_io

namespace psivox {

using image_io::Format;

namespace {

Image read_any(const std::filesystem::path& path, Format format, bool needs_picture) {
  try {
    if (format == Format::png) return image_io::read_png(path);
    return image_io::picture_files(ExitCode::failure).read(path, format, needs_picture);
  } catch (const std::bad_alloc&) {
    throw image_io::read_error(path, "there is not enough memory for its pixels");
  }
}

}  // namespace

Image read_image(const std::filesystem::path& path) {
  return read_any(path, image_io::format_from_contents(path), /*needs_picture=*/true);
}

Image read_layers(const std::filesystem::path& path) {
  const Format format = image_io::format_from_contents(path);
  if (format != Format::exr)
    throw image_io::read_error(path, "it is no EXR, which alone has layers");
  return read_any(path, format, /*needs_picture=*/false);
}

std::map<std::string, std::string> read_metadata(const std::filesystem::path& path) {
  const Format format = image_io::format_from_contents(path);
  return format == Format::png
             ? image_io::read_png(path).metadata
             : image_io::picture_files(ExitCode::failure).read_metadata(path, format);
}

std::string read_metadata(const std::filesystem::path& path, const std::string& key) {
  const auto metadata = read_metadata(path);
  const auto found = metadata.find(key);
  return found == metadata.end() ? std::string() : found->second;
}

OcioView complete_view(const OcioView& view) {
  return image_io::picture_files(ExitCode::failure).complete_view(view);
}

void show_by(const OcioView& view, std::span<float> rgb) {
  image_io::picture_files(ExitCode::failure).show_by(view, rgb);
}

std::string openimageio_version() { return image_io::picture_files(ExitCode::failure).version(); }

}  // namespace psivox
