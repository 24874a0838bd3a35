#include "oiio/exr_header.h"

#include <cstdint>
#include <fstream>
#include <string>

#include "image/error_text.h"

namespace psivox::image_io {
namespace {

/// Reads up to the next zero byte.
std::string read_name(std::istream& file) {
  std::string name;
  std::getline(file, name, '\0');
  return name;
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
    file.seekg(length, std::ios::cur);
  }
}

}  // namespace psivox::image_io
