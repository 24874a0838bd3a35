#include "values.h"

#include <blosc.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "base/text.h"

namespace psivox::vdb {
namespace {

constexpr std::string_view before = "Tree_", behind = "_5_4_3";

/// By OpenVDB's names. Those with values come first, in the order of with_value_type.
struct SupportedType {
  std::string value_type;
  int channels;
  std::string_view name_in_file = {};  ///< if it is another

  std::string grid_type() const {
    return std::string(before)
        .append(name_in_file.empty() ? value_type : name_in_file)
        .append(behind);
  }
};

constexpr int value_types = 9;
const std::array<SupportedType, value_types + 2> supported_types{{{"float", 1},
                                                                  {"double", 1},
                                                                  {"half", 1},
                                                                  {"int32", 1},
                                                                  {"int64", 1},
                                                                  {"bool", 1},
                                                                  {"vec3s", 3},
                                                                  {"vec3d", 3},
                                                                  {"vec3i", 3},
                                                                  {"points", 1, "ptdataidx32"},
                                                                  {"mask", 1}}};

const SupportedType* find(std::string_view grid_type) {
  const auto found = std::ranges::find(supported_types, grid_type, &SupportedType::grid_type);
  return found == supported_types.end() ? nullptr : &*found;
}

bool has_values(std::string_view grid_type, std::string_view value_type) {
  return grid_type == grid_type_of(value_type);
}

}  // namespace

int value_type_number(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  const auto number = type ? int(type - supported_types.data()) : -1;
  return number < value_types ? number : -1;
}

std::string grid_type_of(std::string_view value_type) {
  return std::ranges::find(supported_types, value_type, &SupportedType::value_type)->grid_type();
}

bool is_points(std::string_view grid_type) { return has_values(grid_type, "points"); }
bool is_mask(std::string_view grid_type) { return has_values(grid_type, "mask"); }

std::string stored_like(const std::string& grid_type) {
  if (is_points(grid_type)) return grid_type_of("int32");
  return is_mask(grid_type) ? grid_type_of("bool") : grid_type;
}

int channels_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->channels : 0;
}

std::string value_type_of(std::string_view grid_type) {
  const SupportedType* type = find(grid_type);
  return type ? type->value_type : std::string();
}

std::string unsupported_type(const std::string& grid_type) {
  return "has type " + grid_type + ", which cannot be rendered; supported value types: " +
         joined(names_in(supported_types, &SupportedType::value_type), ", ");
}

namespace {

/// Blosc's header, whose sizes before and after compression Blosc trusts. [bytes]
constexpr int blosc_header = 16;

[[noreturn]] void refuse_length() {
  throw std::runtime_error("a block of its values has an impossible length");
}

bool blosc_header_fits(const char* header, std::int64_t size, std::int64_t length) {
  constexpr int size_at = 4, length_at = 12;
  std::uint32_t stored_size, stored_length;
  std::memcpy(&stored_size, header + size_at, sizeof stored_size);
  std::memcpy(&stored_length, header + length_at, sizeof stored_length);
  return length >= blosc_header && stored_size == size && stored_length == length;
}

/// The length of a compressed block; 0: its `size` bytes are as they are.
std::int64_t take_length(std::istream& stream, std::int64_t size) {
  const auto length = take<std::int64_t>(stream);
  if (length > 0) return length;
  if (length != -size) refuse_length();
  return 0;
}

}  // namespace

void expand_blosc(std::string_view stored, char* to, std::size_t size) {
  if (stored.size() < blosc_header ||
      !blosc_header_fits(stored.data(), std::int64_t(size), std::int64_t(stored.size())))
    refuse_length();
  if (blosc_decompress_ctx(stored.data(), to, size, /*numinternalthreads=*/1) != std::int64_t(size))
    throw std::runtime_error("a block of its values is damaged");
}

void expand_zip(std::string_view stored, char* to, std::size_t size) {
  uLongf made = size;
  const int status = uncompress(reinterpret_cast<Bytef*>(to), &made,
                                reinterpret_cast<const Bytef*>(stored.data()), stored.size());
  if (status != Z_OK || made != size) throw std::runtime_error("a block of its values is damaged");
}

void read_block(std::istream& stream, char* to, std::int64_t size, const ValueCoding& coding) {
  const std::int64_t length = coding.has_lengths() ? take_length(stream, size) : 0;
  if (length == 0) {
    stream.read(to, size);
    return;
  }
  // what cannot be compressed is stored as it is, so that no block is much longer than its values
  constexpr std::int64_t overhead = 4096;
  if (length > size + size / 8 + overhead) refuse_length();
  const auto bytes = std::make_unique_for_overwrite<char[]>(std::size_t(length));
  stream.read(bytes.get(), length);
  const std::string_view stored(bytes.get(), std::size_t(length));
  // OpenVDB's first choice
  if (coding.compression & ValueCoding::blosc)
    expand_blosc(stored, to, std::size_t(size));
  else
    expand_zip(stored, to, std::size_t(size));
}

void skip_block(std::istream& stream, std::int64_t size, const ValueCoding& coding) {
  const std::int64_t length = coding.has_lengths() ? take_length(stream, size) : 0;
  if (length > 0 && coding.compression & ValueCoding::blosc) {
    const auto header = take<std::array<char, blosc_header>>(stream);
    stream.seekg(-blosc_header, std::ios_base::cur);
    if (!blosc_header_fits(header.data(), size, length)) refuse_length();
  }
  stream.seekg(length > 0 ? length : size, std::ios_base::cur);
}

}  // namespace psivox::vdb
