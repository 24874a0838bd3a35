#include "value_block.h"

#include <cstring>
#include <ios>

namespace psivox::vdb {
namespace {

/// Blosc's header has the sizes before and after compression. Blosc trusts both.
bool blosc_header_fits(std::istream& stream, std::int64_t size, std::int64_t length) {
  constexpr int header_bytes = 16, size_at = 4, length_at = 12;
  if (length < header_bytes) return false;
  char header[header_bytes];
  stream.read(header, header_bytes);
  std::uint32_t stored_size, stored_length;
  std::memcpy(&stored_size, header + size_at, sizeof stored_size);
  std::memcpy(&stored_length, header + length_at, sizeof stored_length);
  stream.seekg(-header_bytes, std::ios_base::cur);
  return stored_size == size && stored_length == length;
}

}  // namespace

void skip_compressed(std::istream& stream, std::int64_t size, const ValueCoding& coding) {
  std::int64_t length = 0;  // 0 or negative: the bytes are not compressed
  stream.read(reinterpret_cast<char*>(&length), sizeof length);
  const bool blosc = coding.compression & openvdb::io::COMPRESS_BLOSC;  // if both, OpenVDB takes it
  const bool fits =
      length <= 0 ? length == -size : !blosc || blosc_header_fits(stream, size, length);
  if (!fits) throw openvdb::IoError("a block of its values has an impossible length");
  stream.seekg(length <= 0 ? size : length, std::ios_base::cur);
}

}  // namespace psivox::vdb
