#include "formats.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <system_error>

#include "base/input_file.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_file.h"

namespace fs = std::filesystem;

namespace psivox::image_io {

std::string one_line(std::string text) {
  std::ranges::replace(text, '\r', '\n');
  std::vector<std::string> lines = split(text, '\n');
  std::erase(lines, "");
  return joined(lines, "; ");
}

Error read_error(const fs::path& path, const std::string& why) {
  return Error(ExitCode::input, "cannot read " + in_quotes(path.string()) + ": " + one_line(why));
}

Error no_picture(const fs::path& path, const std::vector<std::string>& channels) {
  return read_error(
      path, "it has neither the channels R G B nor a luminance Y, but " + joined(channels, " "));
}

Error write_error(const fs::path& path, const std::string& why) {
  return Error(ExitCode::output, "cannot write " + in_quotes(path.string()) + ": " + one_line(why));
}

namespace {

constexpr int any_size = std::numeric_limits<int>::max();

/// The rows are in the order of Format.
constexpr FormatFacts formats[] = {
    {Format::exr, ".exr", "", nullptr, true, any_size},
    {Format::png, ".png", "", nullptr, true, any_size},
    {Format::tiff, ".tif", ".tiff", "tiff", true, any_size},
    {Format::jpeg, ".jpg", ".jpeg", "jpeg", false, 65500},  // libjpeg ends the program above it
    {Format::hdr, ".hdr", "", "hdr", false, any_size},
    // OpenImageIO would write alpha, but divides colour by it in 8 bits of linear light: dark
    // colours become black.
    {Format::webp, ".webp", "", "webp", false, 16383},
};

std::string known_extensions() {
  std::vector<std::string> names;
  for (const FormatFacts& facts : formats)
    for (const std::string_view extension : {facts.extension, facts.other_extension})
      if (!extension.empty()) names.emplace_back(extension);
  return joined(std::span(names).first(names.size() - 1), ", ") + " or " + names.back();
}

std::optional<Format> format_from_start(std::string_view start) {
  using std::string_view_literals::operator""sv;
  constexpr std::pair<std::string_view, Format> starts[] = {{"\x76\x2f\x31\x01"sv, Format::exr},
                                                            {"\x89PNG\r\n\x1a\n"sv, Format::png},
                                                            {"II*\0"sv, Format::tiff},
                                                            {"MM\0*"sv, Format::tiff},
                                                            {"II+\0"sv, Format::tiff},
                                                            {"MM\0+"sv, Format::tiff},
                                                            {"\xff\xd8\xff"sv, Format::jpeg},
                                                            {"#?RADIANCE"sv, Format::hdr},
                                                            {"#?RGBE"sv, Format::hdr}};
  for (const auto& [bytes, format] : starts)
    if (start.starts_with(bytes)) return format;
  if (start.starts_with("RIFF"sv) && start.ends_with("WEBP"sv)) return Format::webp;
  return std::nullopt;
}

}  // namespace

const FormatFacts& facts_of(Format format) { return formats[std::size_t(format)]; }

std::optional<Format> format_of_extension(const fs::path& path) {
  const std::string& name = path.native();
  if (name == "-") return Format::png;
  const bool piped = name.ends_with(":-");
  std::string extension = piped ? "." + name.substr(0, name.size() - 2) : path.extension().string();
  extension = lower_case(extension);
  if (!extension.empty())
    for (const FormatFacts& facts : formats)
      if (extension == facts.extension || extension == facts.other_extension) return facts.format;
  return std::nullopt;
}

Format format_from_extension(const fs::path& path) {
  if (const auto format = format_of_extension(path)) return *format;
  throw Error(ExitCode::usage, extension_problem(path));
}

Format format_from_contents(const fs::path& path) {
  std::error_code status_error;
  const auto status = fs::status(path, status_error);
  if (status.type() == fs::file_type::not_found) {
    throw read_error(path, "there is no such file");
  }
  if (fs::is_directory(status)) throw read_error(path, "it is a directory");

  std::string why;
  const int file = open_input(path, why);
  if (file < 0) throw read_error(path, why);
  std::array<char, 12> bytes{};
  const ssize_t count = ::read(file, bytes.data(), bytes.size());
  ::close(file);
  const auto format = format_from_start({bytes.data(), std::size_t(std::max<ssize_t>(count, 0))});
  if (!format) throw read_error(path, "it is no EXR, PNG, TIFF, JPEG, HDR or WebP file");
  return *format;
}

void check_size(const fs::path& path, int width, int height, double stored, int channels) {
  constexpr double most_values = 0x1p31;  // 8 GiB of floats, 16384x16384 pixels of 8 channels
  // A file that lacks stored pixels fails when they are read. The empty part of an EXR's display
  // window takes no byte of the file: it may be 1024 times what is stored, or a megapixel.
  const double shown = double(width) * height;
  const int most_channels = channels + 3;  // grey becomes R G B A
  if (width > 0 && height > 0 && shown <= 0x1p20 + 1024 * stored &&
      std::max(stored, shown) * most_channels <= most_values) {
    constexpr double value_bytes = 4 + 2;  // and the codes of 8 or 16 bits that it is read from
    return claim_memory(value_bytes * std::max(stored, shown) * channels,
                        "the picture " + in_quotes(path.string()));
  }
  throw read_error(path, "its header is damaged or asks for too much: " + std::to_string(width) +
                             "x" + std::to_string(height) + " pixels, " + std::to_string(channels) +
                             " channels");
}

void check_target(const fs::path& target) {
  if (is_standard_output(target)) {
    if (::isatty(STDOUT_FILENO) == 1)
      throw write_error(target, "the standard output is a terminal; redirect it");
    return;
  }
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) throw write_error(target, "it is a directory");
  const bool exists = fs::exists(target, ignored);
  if (exists && !fs::is_regular_file(target, ignored))
    throw write_error(target, "it is not a regular file");
  // A rename would replace a read-only file; who protected it does not expect that.
  if (exists && ::access(target.c_str(), W_OK) != 0)
    throw write_error(target, std::strerror(errno));
  const fs::path directory = target.parent_path();
  if (!directory.empty() && !fs::is_directory(directory, ignored))
    throw write_error(target, "there is no directory '" + directory.string() + "'");
}

void write_bytes(const fs::path& target, const std::string& bytes) {
  if (!is_standard_output(target)) return write_text(target.string(), bytes);
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() ||
      std::fflush(stdout) != 0)
    throw write_error(target, std::strerror(errno));
}

}  // namespace psivox::image_io

namespace psivox {

std::string extension_problem(const fs::path& path) {
  if (image_io::format_of_extension(path)) return {};
  const std::string extension = path.extension().string();
  const std::string found =
      extension.empty() ? "no extension" : "unknown extension " + in_quotes(extension);
  return "cannot write " + in_quotes(path.string()) + ": " + found + "; use " +
         image_io::known_extensions();
}

}  // namespace psivox
