#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "psivox/error.h"
#include "psivox/text.h"
#include "scan/byte_stream.h"
#include "scan/header.h"

namespace psivox::scan {
namespace {

[[noreturn]] void refuse_nrrd(const FileBlocks& file, const std::string& what) {
  throw Error(ExitCode::input, subject(file.path()) + what);
}

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == text.npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
}

/// Words between spaces; spaces within quotes or brackets part none.
std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> all;
  std::string word;
  int depth = 0;
  bool quoted = false;
  for (const char c : std::string(text) + ' ') {
    if (c == '"') quoted = !quoted;
    if (!quoted && c == '(') ++depth;
    if (!quoted && c == ')') --depth;
    const bool space = c == ' ' || c == '\t';
    if (space && depth <= 0 && !quoted) {
      if (!word.empty()) all.push_back(word);
      word.clear();
    } else if (!space || quoted) {
      word += c;
    }
  }
  return all;
}

/// The fields of a header by their names in lower case, without spaces: `datafile` is `data file`.
struct Text {
  std::map<std::string, std::string> fields;
  std::int64_t end = 0;  ///< of the header [bytes]

  const std::string& of(const std::string& name) const {
    static const std::string none;
    const auto field = fields.find(name);
    return field == fields.end() ? none : field->second;
  }
};

/// Reads lines up to the first empty one, or to the end of a header whose values lie elsewhere.
Text read_fields(FileBlocks& file) {
  constexpr std::int64_t longest = 1 << 20;
  ByteStream stream(file, 0);
  Text text;
  stream.line();  // the magic
  while (stream.position() < file.size()) {
    if (stream.position() > longest) refuse_nrrd(file, "its header has no end");
    const std::string line = stream.line();
    if (line.empty()) break;
    const auto colon = line.find(':');
    // a comment, or a key and its value, which are the writer's own
    if (line[0] == '#' || colon == line.npos || line.substr(colon).starts_with(":=")) continue;
    std::string name = lower_case(line.substr(0, colon));
    std::erase(name, ' ');
    if (name == "centerings") name = "centers";
    text.fields[name] = trimmed(std::string_view(line).substr(colon + 1));
  }
  text.end = stream.position();
  return text;
}

/// A number of a header, as its text has it. std::from_chars knows no plus sign.
template <typename Number>
Number number(const FileBlocks& file, const std::string& text, const char* field) {
  Number value{};
  const std::string_view digits = std::string_view(text).substr(text.starts_with('+') ? 1 : 0);
  if (!read_number(digits, value))
    refuse_nrrd(file, std::string(field) + " of " + in_quotes(text) + " is no number");
  return value;
}

/// The names of each type.
constexpr std::pair<std::string_view, Type> nrrd_types[] = {
    {"signed char,int8,int8_t", Type::int8},
    {"uchar,unsigned char,uint8,uint8_t", Type::uint8},
    {"short,short int,signed short,signed short int,int16,int16_t", Type::int16},
    {"ushort,unsigned short,unsigned short int,uint16,uint16_t", Type::uint16},
    {"int,signed int,int32,int32_t", Type::int32},
    {"uint,unsigned int,uint32,uint32_t", Type::uint32},
    {"longlong,long long,long long int,signed long long,signed long long int,int64,int64_t",
     Type::int64},
    {"ulonglong,unsigned long long,unsigned long long int,uint64,uint64_t", Type::uint64},
    {"float", Type::float32},
    {"double", Type::float64},
};

void set_encoding(const Text& text, Header& header, const FileBlocks& file) {
  const std::string type = lower_case(text.of("type")), encoding = lower_case(text.of("encoding"));
  const auto* known = std::ranges::find_if(nrrd_types, [&](const auto& names) {
    return std::ranges::count(split(names.first), type) > 0;
  });
  if (known == std::end(nrrd_types))
    refuse_nrrd(file, "has values of type " + in_quotes(type) + ", which psivox does not read");
  header.type = known->second;
  if (encoding == "raw")
    header.encoding = Encoding::raw;
  else if (encoding == "gzip" || encoding == "gz")
    header.encoding = Encoding::gzip;
  else if (encoding == "text" || encoding == "txt" || encoding == "ascii")
    header.encoding = Encoding::text;
  else if (encoding == "hex")
    header.encoding = Encoding::hex;
  else
    refuse_nrrd(file, "has the encoding " + in_quotes(encoding) +
                          "; psivox reads raw, gzip, text "
                          "and hex");
  const std::string endian = lower_case(text.of("endian"));
  header.big_endian = endian == "big";
  if (size_of(header.type) > 1 && header.encoding != Encoding::text && endian != "big" &&
      endian != "little")
    refuse_nrrd(file, "does not say its byte order: 'endian' is " + in_quotes(endian));
  header.detached = !text.of("datafile").empty();
  header.begin = header.detached ? 0 : text.end;
  const std::string &lines = text.of("lineskip"), &skip = text.of("byteskip");
  if (!lines.empty()) header.lines = number<std::int64_t>(file, lines, "a line skip");
  if (!skip.empty()) header.skip = number<std::int64_t>(file, skip, "a byte skip");
  const bool from_end = header.skip == -1 && header.encoding == Encoding::raw;
  if (header.lines < 0 || (header.skip < 0 && !from_end))
    refuse_nrrd(file, "its line skip or byte skip is below 0");
}

/// One axis of the values, the fastest first.
struct Axis {
  std::int64_t size = 1, stride = 1;
  std::string kind;  ///< in lower case
  std::optional<glm::dvec3> direction;
  bool spatial = true;
};

glm::dvec3 vector_of(const FileBlocks& file, const std::string& text) {
  glm::dvec3 v(0);
  if (!text.starts_with('(') || !text.ends_with(')'))
    refuse_nrrd(file, in_quotes(text) + " is no vector");
  const std::vector<std::string> parts = split(text.substr(1, text.size() - 2));
  if (parts.empty() || parts.size() > 3)
    refuse_nrrd(file, in_quotes(text) + " is no vector of 3 numbers");
  for (std::size_t i = 0; i < parts.size(); ++i)
    v[int(i)] = number<double>(file, parts[i], "a component");
  return v;
}

/// Kinds of axes that are places. Others are colours, vectors, times and lists.
bool is_place(const std::string& kind) {
  return kind == "domain" || kind == "space" || kind == "none" || kind == "???" || kind.empty();
}

std::vector<Axis> axes_of(const Text& text, const FileBlocks& file) {
  const std::vector<std::string> sizes = words(text.of("sizes")), kinds = words(text.of("kinds")),
                                 directions = words(text.of("spacedirections"));
  const auto count = number<int>(file, text.of("dimension"), "a dimension");
  if (count < 1 || count > 16 || sizes.size() != std::size_t(count))
    refuse_nrrd(file, "has " + std::to_string(sizes.size()) + " sizes for " +
                          std::to_string(count) + " dimensions");
  for (const auto* list : {&kinds, &directions})
    if (!list->empty() && list->size() != sizes.size())
      refuse_nrrd(file, "has another number of kinds or directions than of sizes");
  std::vector<Axis> axes(sizes.size());
  std::int64_t stride = 1;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    Axis& axis = axes[i];
    axis.size = number<std::int64_t>(file, sizes[i], "a size");
    constexpr std::int64_t most = std::int64_t{1} << 48;  // so that no product overflows
    if (axis.size < 1 || axis.size > 1 << 24 || stride > most / axis.size)
      refuse_nrrd(file, "its header claims a size of " + sizes[i]);
    axis.stride = stride;
    stride *= axis.size;
    if (!kinds.empty()) axis.kind = lower_case(kinds[i]);
    axis.spatial = is_place(axis.kind);
    if (directions.empty()) continue;
    axis.spatial = lower_case(directions[i]) != "none";
    if (axis.spatial) axis.direction = vector_of(file, directions[i]);
  }
  // where nothing tells, four axes begin with few components or end with frames
  const auto places = std::ranges::count(axes, true, &Axis::spatial);
  if (places == 4 && axes.size() == 4 && directions.empty())
    (axes[0].size <= 4 ? axes[0] : axes[3]).spatial = false;
  return axes;
}

/// Whether an axis has red, green and blue, or the components of a vector.
bool has_components(const Axis& axis, bool first) {
  const std::string& kind = axis.kind;
  if (axis.size == 4) return kind == "rgba-color" || kind == "4-color";
  if (axis.size != 3) return false;
  return is_place(kind) ? first
                        : kind.ends_with("color") || kind.ends_with("vector") ||
                              kind.ends_with("gradient") || kind.ends_with("normal");
}

/// Shape, channels and frames by the axes, and returns those of space.
std::vector<std::size_t> set_shape(const std::vector<Axis>& axes, Header& header,
                                   const FileBlocks& file) {
  std::vector<std::size_t> space;
  header.values = 1;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Axis& axis = axes[i];
    header.values *= axis.size;
    if (axis.spatial) {
      space.push_back(i);
    } else if (header.channels == 1 && has_components(axis, i == 0)) {
      header.channels = 3;
      header.channel_stride = axis.stride;
      header.colour = axis.kind.ends_with("color");
      if (axis.size == 4) header.notices.push_back("leaves out the alpha of its colours");
    } else if (axis.size > 1) {
      if (header.frames > 1)
        refuse_nrrd(file,
                    "has more axes than psivox reads: three of space, one of colours or "
                    "vectors, and one of frames");
      header.frames = axis.size;
      header.frame_stride = axis.stride;
    }
  }
  if (space.size() < 2 || space.size() > 3)
    refuse_nrrd(file,
                "has " + std::to_string(space.size()) + " axes of space; psivox reads 2 or 3");
  for (std::size_t i = 0; i < 3; ++i) {
    const bool there = i < space.size();
    header.shape[int(i)] = there ? int(axes[space[i]].size) : 1;
    header.strides[i] = there ? axes[space[i]].stride : header.values;
  }
  return space;
}

/// Numbers of axes that may be missing, as NaN.
double number_of_axis(const Text& text, const std::string& field, std::size_t axis) {
  const std::vector<std::string> all = words(text.of(field));
  double value = std::nan("");
  if (axis < all.size()) read_number(all[axis], value);
  return value;
}

/// Without a space: spacings along the axes.
glm::dmat4 spaced_transform(const Text& text, const std::vector<Axis>& axes,
                            const std::vector<std::size_t>& space) {
  glm::dmat4 m(1);
  const std::vector<std::string> centers = words(text.of("centers"));
  for (std::size_t i = 0; i < space.size(); ++i) {
    const std::size_t axis = space[i];
    const bool cell = axis < centers.size() && lower_case(centers[axis]) == "cell";
    const double least = number_of_axis(text, "axismins", axis),
                 most = number_of_axis(text, "axismaxs", axis);
    double size = number_of_axis(text, "spacings", axis);
    if (std::isnan(size) && std::isfinite(most - least))
      size = (most - least) / double(std::max<std::int64_t>(axes[axis].size - (cell ? 0 : 1), 1));
    if (std::isnan(size)) size = 1;
    m[int(i)][int(i)] = size;
    if (!std::isnan(least)) m[3][int(i)] = least + (cell ? size / 2 : 0);
  }
  return m;
}

/// With +x to the right, +y to the front and +z up, where the space says what its axes are.
glm::dmat4 nrrd_transform(const Text& text, const std::vector<Axis>& axes,
                          const std::vector<std::size_t>& space, Header& header,
                          const FileBlocks& file) {
  std::string name = lower_case(text.of("space"));
  if (const auto time = name.find("-time"); time != name.npos) name.resize(time);
  if (name == "ras") name = "right-anterior-superior";
  if (name == "las") name = "left-anterior-superior";
  if (name == "lps") name = "left-posterior-superior";
  if (name.ends_with("-superior"))
    header.z_up = "an NRRD scan of the space " + name;
  else if (name == "scanner-xyz")
    header.z_up = "an NRRD scan of a scanner's space";
  glm::dmat4 m(1);
  if (text.of("spacedirections").empty()) {
    m = spaced_transform(text, axes, space);
  } else {
    for (std::size_t i = 0; i < space.size(); ++i)
      m[int(i)] = glm::dvec4(axes[space[i]].direction.value_or(glm::dvec3(0)), 0);
    if (space.size() == 2) {
      const glm::dvec3 x(m[0]), y(m[1]), normal = glm::cross(x, y);
      m[2] = glm::dvec4(normal * (glm::length(x) / glm::length(normal)), 0);
    }
  }
  if (const std::string& origin = text.of("spaceorigin"); !origin.empty()) {
    const std::vector<std::string> one = words(origin);
    if (one.size() != 1) refuse_nrrd(file, in_quotes(origin) + " is no vector");
    m[3] = glm::dvec4(vector_of(file, one[0]), 1);
  }
  const glm::dvec3 sign(name.starts_with("left-") ? -1 : 1,
                        name.find("-posterior") != name.npos ? -1 : 1, 1);
  for (int c = 0; c < 4; ++c) m[c] *= glm::dvec4(sign, 1);
  return m;
}

}  // namespace

bool is_nrrd(std::string_view head) { return head.starts_with("NRRD0"); }

Header read_nrrd(FileBlocks& file) {
  const Text text = read_fields(file);
  Header header;
  header.format = "NRRD";
  set_encoding(text, header, file);
  const std::vector<Axis> axes = axes_of(text, file);
  const std::vector<std::size_t> space = set_shape(axes, header, file);
  header.world_from_index = nrrd_transform(text, axes, space, header, file);
  header.metadata["format"] = header.format;
  for (const char* name : {"space", "content"})
    if (!text.of(name).empty()) header.metadata[name] = text.of(name);
  if (const auto units = words(text.of("spaceunits")); !units.empty()) {
    std::string unit = units[0];
    std::erase(unit, '"');
    if (!unit.empty()) header.metadata["unit"] = unit;
  }
  return header;
}

std::string data_path(FileBlocks& header) {
  namespace fs = std::filesystem;
  const FileRun first = header.run(0, 1);
  const std::string_view head(first.bytes.get(), std::size_t(first.size));
  const fs::path own(header.path());
  if (is_nifti(head)) {
    const bool first_version = head.size() > 346 && head.substr(344).starts_with("ni1");
    if (!first_version && !head.substr(4).starts_with("ni2")) return {};
    return fs::path(own).replace_extension(".img").string();
  }
  if (!is_nrrd(head)) return {};
  const std::string name = read_fields(header).of("datafile");
  if (name.empty()) return {};
  if (name.starts_with("LIST") || name.find('%') != name.npos)
    refuse_nrrd(header, "its values lie in several files, which psivox does not read together");
  const fs::path path(name);
  if (path.is_absolute() || std::ranges::count(path, fs::path("..")))
    refuse_nrrd(header, "its values lie in " + in_quotes(name) +
                            "; psivox reads files in the header's folder or below");
  return (own.parent_path() / path).string();
}

}  // namespace psivox::scan
