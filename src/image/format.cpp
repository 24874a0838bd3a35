#include "format.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "error_text.h"

namespace psivox::image_io {

Format format_from_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (extension == ".exr") return Format::exr;
  if (extension == ".png") return Format::png;
  const std::string found =
      extension.empty() ? "no extension" : "unknown extension '" + path.extension().string() + "'";
  throw Error(ExitCode::usage,
              one_line("cannot write '" + path.string() + "': " + found + "; use .exr or .png"));
}

Format format_from_contents(const std::filesystem::path& path) {
  std::error_code status_error;
  const auto status = std::filesystem::status(path, status_error);
  if (status.type() == std::filesystem::file_type::not_found) {
    throw read_error(path, "there is no such file");
  }
  if (std::filesystem::is_directory(status)) throw read_error(path, "it is a directory");

  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw read_error(path, errno != 0 ? std::strerror(errno) : "it cannot be opened");

  using std::string_view_literals::operator""sv;
  constexpr auto exr_magic = "\x76\x2f\x31\x01"sv;
  constexpr auto png_magic = "\x89PNG\r\n\x1a\n"sv;
  std::array<char, 8> bytes{};
  file.read(bytes.data(), bytes.size());
  const std::string_view start(bytes.data(), static_cast<std::size_t>(file.gcount()));
  if (start.starts_with(exr_magic)) return Format::exr;
  if (start.starts_with(png_magic)) return Format::png;
  throw read_error(path, "it is neither an EXR nor a PNG file");
}

}  // namespace psivox::image_io
