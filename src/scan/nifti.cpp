#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <limits>

#include "base/text.h"
#include "field/index_space.h"
#include "scan/streams.h"

namespace psivox::scan {
namespace {

/// Numbers of a binary header, of either byte order.
class Fields {
 public:
  Fields(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  template <typename T>
  T at(std::size_t place) const {
    std::array<char, sizeof(T)> bytes{};
    bytes_.copy(bytes.data(), sizeof(T), place);
    if (big_endian_) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }
  std::string text(std::size_t place, std::size_t length) const {
    const std::string_view field = bytes_.substr(place, length);
    return std::string(field.substr(0, field.find('\0')));
  }

 private:
  std::string_view bytes_;
  bool big_endian_;
};

/// What both versions of the format have, at different places.
struct NiftiFields {
  std::int64_t dim[8]{};
  int datatype = 0, intent = 0;
  double pixdim[8]{}, offset = 0, slope = 0, intercept = 0;
  int units = 0, qform = 0, sform = 0;
  double quaternion[3]{}, origin[3]{}, rows[3][4]{};  ///< b, c, d; of the qform; the sform
  std::string description;
};

/// Sizes of the headers, which they begin with.
constexpr std::int32_t nifti1_size = 348, nifti2_size = 540;

/// Where the fields of a version are [bytes].
struct NiftiPlaces {
  std::size_t dim, datatype, intent, pixdim, offset, slope, intercept, units, description, qform,
      sform, quaternion, origin, rows;
};
constexpr NiftiPlaces nifti1_places{40,  70,  68,  76,  108, 112, 116,
                                    123, 148, 252, 254, 256, 268, 280};
constexpr NiftiPlaces nifti2_places{16,  12,  504, 104, 168, 176, 184,
                                    500, 240, 344, 348, 352, 376, 400};

/// By the types that the version has for them.
template <typename Dim, typename Code, typename Real, typename Offset, typename Units>
NiftiFields fields_at(const NiftiPlaces& at, const Fields& from) {
  const auto real = [&](std::size_t place, std::size_t i = 0) {
    return double(from.at<Real>(place + i * sizeof(Real)));
  };
  NiftiFields to;
  for (std::size_t i = 0; i < 8; ++i) {
    to.dim[i] = from.at<Dim>(at.dim + i * sizeof(Dim));
    to.pixdim[i] = real(at.pixdim, i);
  }
  to.datatype = from.at<std::int16_t>(at.datatype);
  to.intent = from.at<Code>(at.intent);
  to.offset = double(from.at<Offset>(at.offset));
  to.slope = real(at.slope);
  to.intercept = real(at.intercept);
  to.units = from.at<Units>(at.units);
  to.description = from.text(at.description, 80);
  to.qform = from.at<Code>(at.qform);
  to.sform = from.at<Code>(at.sform);
  for (std::size_t i = 0; i < 3; ++i) {
    to.quaternion[i] = real(at.quaternion, i);
    to.origin[i] = real(at.origin, i);
    for (std::size_t j = 0; j < 4; ++j) to.rows[i][j] = real(at.rows, 4 * i + j);
  }
  return to;
}

struct NiftiType {
  int number;
  Type type;
  int components;  ///< of a value
};
constexpr NiftiType nifti_types[] = {
    {2, Type::uint8, 1},    {4, Type::int16, 1},    {8, Type::int32, 1},     {16, Type::float32, 1},
    {64, Type::float64, 1}, {128, Type::uint8, 3},  {256, Type::int8, 1},    {512, Type::uint16, 1},
    {768, Type::uint32, 1}, {1024, Type::int64, 1}, {1280, Type::uint64, 1}, {2304, Type::uint8, 4},
};

/// The types that are not read.
std::string refused_type(int number) {
  switch (number) {
    case 1:
      return "single bits";
    case 32:
    case 1792:
    case 2048:
      return "complex numbers";
    case 1536:
      return "numbers of 128 bits";
    default:
      return "the unknown type " + std::to_string(number);
  }
}

/// The rotation of a unit quaternion by its last three numbers (nifti1.h, method 2).
glm::dmat3 rotation(const double (&bcd)[3], const FileBlocks& file) {
  // stored as float32: b, c and d may exceed 1 by their rounding, as nibabel allows
  constexpr double rounding = 3 * std::numeric_limits<float>::epsilon();
  const double b = bcd[0], c = bcd[1], d = bcd[2], rest = 1 - (b * b + c * c + d * d);
  if (!(rest > -rounding)) refuse(file, "its qform is no rotation");
  const double a = rest < rounding ? 0 : std::sqrt(rest);
  const double s = 2 / (a * a + b * b + c * c + d * d);
  return {{1 - s * (c * c + d * d), s * (b * c + a * d), s * (b * d - a * c)},
          {s * (b * c - a * d), 1 - s * (b * b + d * d), s * (c * d + a * b)},
          {s * (b * d + a * c), s * (c * d - a * b), 1 - s * (b * b + c * c)}};
}

glm::dmat4 transform_of_rows(const double (&rows)[3][4]) {
  glm::dmat4 m(1);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) m[c][r] = rows[r][c];
  return m;
}

/// Sets the transform as nibabel does: by the sform, else by the qform, else by the sizes of
/// voxels, with x to the left and the origin in the middle. Some writers name an sform and leave
/// it empty: it does not count.
void set_transform(const NiftiFields& fields, Header& header, const FileBlocks& file) {
  glm::dmat4& m = header.world_from_index;
  const glm::dmat4 rows = transform_of_rows(fields.rows);
  const bool usable = fields.sform != 0 && has_volume(rows);
  if (usable) {
    m = rows;
    header.metadata["transform"] = "sform";
  } else if (fields.qform != 0) {
    const glm::dmat3 turn = rotation(fields.quaternion, file);
    const double hand = fields.pixdim[0] < 0 ? -1 : 1;
    for (int c = 0; c < 3; ++c)
      m[c] = glm::dvec4(turn[c] * (fields.pixdim[c + 1] * (c == 2 ? hand : 1)), 0);
    for (int r = 0; r < 3; ++r) m[3][r] = fields.origin[r];
    header.metadata["transform"] = "qform";
  } else {
    for (int i = 0; i < 3; ++i) {
      // dimensions that the file does not have are 1 wide
      const double size = i < fields.dim[0] ? fields.pixdim[i + 1] : 1;
      m[i][i] = i == 0 ? -size : size;
      m[3][i] = -m[i][i] * (header.shape[i] - 1) / 2;
    }
    header.metadata["transform"] = "pixdim";
  }
  if (fields.sform != 0 && !usable)
    header.notices.push_back("places it by its " + header.metadata["transform"] +
                             ": its sform is empty or singular");
}

/// Sets shape, frames and channels. A fifth dimension of 3 holds vectors; all other dimensions
/// beyond the third hold frames.
void set_shape(const NiftiFields& fields, int components, Header& header, const FileBlocks& file) {
  const std::int64_t count = fields.dim[0];
  if (count < 1 || count > 7)
    refuse(file, "its header claims " + std::to_string(count) + " dimensions");
  std::int64_t dim[8] = {0, 1, 1, 1, 1, 1, 1, 1};
  header.values = components;
  for (int i = 1; i <= count; ++i) {
    dim[i] = fields.dim[i];
    constexpr std::int64_t most = std::int64_t{1} << 48;  // so that no product overflows
    if (dim[i] < 1 || dim[i] > (i <= 3 ? 1 << 24 : 1 << 30) || header.values > most / dim[i])
      refuse(file, "its header claims a dimension of " + std::to_string(dim[i]));
    header.values *= dim[i];
  }
  header.shape = glm::ivec3(dim[1], dim[2], dim[3]);
  header.strides = {components, components * dim[1], components * dim[1] * dim[2]};
  const std::int64_t volume = components * dim[1] * dim[2] * dim[3];
  header.frame_stride = volume;
  header.frames = header.values / volume;
  if (components > 1) {
    header.channels = 3;
    header.channel_stride = 1;
    header.colour = true;
  } else if (dim[5] == 3 && dim[6] == 1 && dim[7] == 1) {
    header.channels = 3;
    header.channel_stride = volume * dim[4];
    header.frames = dim[4];
  }
  if (components == 4) header.notices.push_back("leaves out the alpha of its colours");
}

std::string_view unit_name(int units) {
  constexpr std::string_view names[] = {"", "m", "mm", "micron"};
  return names[units & 3];
}

}  // namespace

bool is_nifti(std::string_view head) {
  if (head.size() < 4) return false;
  for (const bool big : {false, true}) {
    const auto size = Fields(head, big).at<std::int32_t>(0);
    if (size == nifti1_size || size == nifti2_size) return true;
  }
  return false;
}

Header read_nifti(FileBlocks& file, bool packed) {
  ByteStream stream(file, 0, packed);
  std::string bytes(std::size_t(nifti2_size), '\0');
  bytes.resize(std::size_t(stream.read(bytes.data(), nifti2_size)));
  const auto starts = [&](std::int32_t size, bool big) {
    return bytes.size() >= std::size_t(size) && Fields(bytes, big).at<std::int32_t>(0) == size;
  };
  Header header;
  header.big_endian = starts(nifti1_size, true) || starts(nifti2_size, true);
  const bool second = starts(nifti2_size, header.big_endian);
  if (!second && !starts(nifti1_size, header.big_endian))
    refuse(file, "the file ends within its header");
  const Fields from(bytes, header.big_endian);
  const std::string magic = from.text(second ? 4 : 344, 3);
  const std::string version = second ? "2" : "1";
  if (magic != "n+" + version && magic != "ni" + version)
    refuse(file, "is an Analyze 7.5 header, which does not say where left is; nibabel converts it");
  const NiftiFields fields =
      second
          ? fields_at<std::int64_t, std::int32_t, double, std::int64_t, std::int32_t>(nifti2_places,
                                                                                      from)
          : fields_at<std::int16_t, std::int16_t, float, float, std::uint8_t>(nifti1_places, from);
  if (fields.intent / 100 == 30)  // 3000 to 3099 are those of CIFTI-2
    refuse(file, "is a CIFTI file: its values belong to surfaces, not to a volume");
  const auto* type = std::ranges::find(nifti_types, fields.datatype, &NiftiType::number);
  if (type == std::end(nifti_types))
    refuse(file, "has " + refused_type(fields.datatype) + ", which psivox does not read");

  header.format = "NIfTI-" + version;
  header.type = type->type;
  header.encoding = packed ? Encoding::gzip : Encoding::raw;
  header.detached = magic[1] == 'i';
  // an offset of 0 means the first byte that may be one
  const std::int64_t least = header.detached ? 0 : (second ? nifti2_size : nifti1_size) + 4;
  const double offset = fields.offset == 0 ? double(least) : fields.offset;
  if (!(offset >= double(least) && offset < double(std::int64_t{1} << 53)))
    refuse(file, "its header says that values begin at byte " + number_text(fields.offset));
  header.skip = std::int64_t(offset);
  set_shape(fields, type->components, header, file);
  set_transform(fields, header, file);
  // a slope of 0 means none; colours have none
  if (std::isfinite(fields.slope) && fields.slope != 0 && type->components == 1) {
    header.slope = fields.slope;
    header.intercept = fields.intercept;
    if (!std::isfinite(fields.intercept)) refuse(file, "its intercept is not finite");
  }
  header.statistic = fields.intent >= 2 && fields.intent <= 24;  // NIFTI_FIRST_STATCODE and on
  header.z_up = "a NIfTI scan";
  header.metadata["format"] = header.format;
  if (!unit_name(fields.units).empty()) header.metadata["unit"] = unit_name(fields.units);
  if (!fields.description.empty()) header.metadata["description"] = fields.description;
  return header;
}

}  // namespace psivox::scan
