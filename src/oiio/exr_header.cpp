#include "oiio/picture_module.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "image/format.h"

namespace psivox::image_io {
namespace {

/// Reads up to the next zero byte.
std::string read_name(std::istream& file) {
  std::string name;
  std::getline(file, name, '\0');
  return name;
}

/// Sizes of values [bytes], by the names of their types.
constexpr std::pair<std::string_view, std::size_t> fixed_sizes[] = {
    {"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"m33d", 72},       {"m33f", 36},    {"m44d", 128},
    {"m44f", 64},       {"rational", 8}, {"lineOrder", 1},
    {"tiledesc", 9},    {"timecode", 8}, {"v2d", 16},
    {"v2f", 8},         {"v2i", 8},      {"v3d", 24},
    {"v3f", 12},        {"v3i", 12},     {"deepImageState", 1}};

std::uint32_t number_at(std::string_view value, std::size_t at) {
  std::uint32_t number;
  std::memcpy(&number, value.data() + at, sizeof number);
  return number;
}

/// Names, each with 16 bytes behind it, and an empty name.
bool is_channel_list(std::string_view value) {
  while (true) {
    const std::size_t end = value.find('\0');
    if (end == value.npos) return false;
    if (end == 0) return value.size() == 1;
    if (value.size() - end < 17) return false;
    value.remove_prefix(end + 17);
  }
}

/// Strings, each behind its length.
bool is_string_list(std::string_view value) {
  while (!value.empty()) {
    if (value.size() < 4 || value.size() - 4 < number_at(value, 0)) return false;
    value.remove_prefix(4 + number_at(value, 0));
  }
  return true;
}

/// Width, height, 4 bytes a pixel.
bool is_preview(std::string_view value) {
  return value.size() >= 8 &&
         value.size() - 8 == 4 * std::uint64_t{number_at(value, 0)} * number_at(value, 4);
}

/// Whether a value of this type is as long as its attribute.
bool fills(std::string_view type, std::string_view value) {
  if (type == "chlist") return is_channel_list(value);
  if (type == "stringvector") return is_string_list(value);
  if (type == "preview") return is_preview(value);
  const auto* fixed = std::find_if(std::begin(fixed_sizes), std::end(fixed_sizes),
                                   [&](const auto& row) { return row.first == type; });
  return fixed == std::end(fixed_sizes) || fixed->second == value.size();
}

}  // namespace

void check_exr_header(const std::filesystem::path& path) {
  constexpr std::uint32_t multi_part = 1 << 12;
  std::ifstream file(path, std::ios::binary);
  const auto size = std::int64_t(std::filesystem::file_size(path));
  file.seekg(4);  // the magic number
  std::uint32_t version = 0;
  file.read(reinterpret_cast<char*>(&version), sizeof version);
  // a header ends with an empty name, several end with an empty header
  for (bool begun = false; file;) {
    if (read_name(file).empty()) {
      if (!begun || !(version & multi_part)) return;
      begun = false;
      continue;
    }
    begun = true;
    const std::string type = read_name(file);
    std::int32_t length = 0;
    if (!file.read(reinterpret_cast<char*>(&length), sizeof length)) return;
    if (length < 0 || length > size - std::int64_t(file.tellg()))
      throw read_error(path, "an attribute of type '" + type + "' is longer than the file");
    std::string value(std::size_t(length), '\0');
    file.read(value.data(), length);
    if (!fills(type, value))
      throw read_error(path, "an attribute of type '" + type + "' has a wrong length");
  }
}

}  // namespace psivox::image_io
