#include "value_block.h"

#include <openvdb/points/StreamCompression.h>

#include <cstring>
#include <ios>

namespace psivox::vdb {
namespace {

constexpr int blosc_header = 16;  // [bytes]

/// Blosc's header has the sizes before and after compression. Blosc trusts both.
bool blosc_header_fits(const char* header, std::int64_t size, std::int64_t length) {
  constexpr int size_at = 4, length_at = 12;
  std::uint32_t stored_size, stored_length;
  std::memcpy(&stored_size, header + size_at, sizeof stored_size);
  std::memcpy(&stored_length, header + length_at, sizeof stored_length);
  return stored_size == size && stored_length == length;
}

bool blosc_header_fits(std::istream& stream, std::int64_t size, std::int64_t length) {
  if (length < blosc_header) return false;
  char header[blosc_header];
  stream.read(header, blosc_header);
  stream.seekg(-blosc_header, std::ios_base::cur);
  return blosc_header_fits(header, size, length);
}

}  // namespace

void expand_blosc(std::string_view stored, char* to, std::size_t size) {
  if (stored.size() < blosc_header ||
      !blosc_header_fits(stored.data(), std::int64_t(size), std::int64_t(stored.size())))
    throw openvdb::IoError("a compressed block has an impossible length");
  openvdb::compression::bloscDecompress(to, size, size + blosc_overhead, stored.data());
}

void skip_compressed(std::istream& stream, std::int64_t size, const ValueCoding& coding) {
  const auto length = take<std::int64_t>(stream);  // 0 or negative: the bytes are not compressed
  const bool blosc = coding.compression & openvdb::io::COMPRESS_BLOSC;  // if both, OpenVDB takes it
  const bool fits =
      length <= 0 ? length == -size : !blosc || blosc_header_fits(stream, size, length);
  if (!fits) throw openvdb::IoError("a block of its values has an impossible length");
  stream.seekg(length <= 0 ? size : length, std::ios_base::cur);
}

}  // namespace psivox::vdb
