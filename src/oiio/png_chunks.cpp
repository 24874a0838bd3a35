#include "png_chunks.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "image/error_text.h"

namespace psivox::image_io {
namespace {

constexpr std::array<std::uint32_t, 256> crc_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
    table[byte] = crc;
  }
  return table;
}();

/// PNG specification, annex D.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc = crc_table[(crc ^ static_cast<unsigned char>(c)) & 0xff] ^ (crc >> 8);
  }
  return ~crc;
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char c : bytes.substr(0, 4)) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

}  // namespace

void check_png_chunks(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string contents(std::istreambuf_iterator<char>(file), {});
  std::string_view rest = contents;
  rest.remove_prefix(8);  // the signature
  // A chunk is its length, its type, as many bytes, and the checksum of type and bytes.
  while (rest.size() >= 12) {
    const std::size_t length = big_endian(rest);
    if (length > rest.size() - 12) break;
    const std::string_view checked = rest.substr(4, 4 + length);
    if (crc_of(checked) != big_endian(rest.substr(8 + length))) {
      throw read_error(path, "the PNG is damaged: a checksum is wrong");
    }
    if (checked.starts_with("IEND")) return;
    rest.remove_prefix(12 + length);
  }
  throw read_error(path, "the PNG is damaged: it is cut short");
}

}  // namespace psivox::image_io
