#include <new>

#include "error_text.h"
#include "format.h"
#include "picture_files.h"
#include "psivox/image.h"
#include "read_png.h"

namespace psivox {

using image_io::Format;

Image read_image(const std::filesystem::path& path) {
  const Format format = image_io::format_from_contents(path);
  try {
    if (format == Format::png) return image_io::read_png(path);
    return image_io::picture_files(ExitCode::failure).read(path, format);
  } catch (const std::bad_alloc&) {
    throw image_io::read_error(path, "there is not enough memory for its pixels");
  }
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

std::string openimageio_version() { return image_io::picture_files(ExitCode::failure).version(); }

}  // namespace psivox
