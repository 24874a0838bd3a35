#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "base/text.h"
#include "scan/streams.h"

namespace psivox::scan {
namespace {

/// The fields of a header by their names in lower case, without spaces: `datafile` is `data file`.
struct NrrdText {
  std::map<std::string, std::string> fields;
  std::int64_t end = 0;  ///< of the header [bytes]

  /// A field; empty if there is none.
  const std::string& of(const std::string& name) const {
    static const std::string none;
    const auto field = fields.find(name);
    return field == fields.end() ? none : field->second;
  }
};

/// A field that every header has.
const std::string& required(const NrrdText& text, const std::string& name, const FileBlocks& file) {
  const std::string& value = text.of(name);
  if (value.empty()) refuse(file, "its header has no " + in_quotes(name));
  return value;
}

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == text.npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
}

/// Reads lines up to the first empty one, or to the end of a header whose values lie elsewhere.
/// Throws Error(input) if the header is longer than 1 MiB.
NrrdText read_nrrd_text(FileBlocks& file) {
  constexpr std::int64_t longest = 1 << 20;
  ByteStream stream(file, 0);
  NrrdText text;
  stream.line();  // the magic
  while (stream.position() < file.size()) {
    if (stream.position() > longest) refuse(file, "its header has no end");
    const std::string line = stream.line();
    if (line.empty()) break;
    const auto colon = line.find(':');
    // a comment, or a key and its value, which mean something to their writer alone
    if (line[0] == '#' || colon == line.npos || line.substr(colon).starts_with(":=")) continue;
    std::string name = lower_case(line.substr(0, colon));
    std::erase(name, ' ');
    if (name == "centerings") name = "centers";
    text.fields[name] = trimmed(std::string_view(line).substr(colon + 1));
  }
  text.end = stream.position();
  return text;
}

/// Words between spaces. Spaces within quotes or brackets do not separate words.
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

/// A name in lower case, without spaces and hyphens, which writers may leave out.
std::string plain(std::string_view name) {
  std::string text = lower_case(name);
  std::erase_if(text, [](char c) { return c == ' ' || c == '-'; });
  return text;
}

/// A row of a table: names with the same meaning.
template <typename Value>
using Names = std::pair<std::string_view, Value>;

/// The meaning of a name; null if no row has it.
template <typename Value, std::size_t rows>
const Value* meaning_of(const Names<Value> (&table)[rows], const std::string& name) {
  for (const auto& [names, value] : table)
    if (std::ranges::count(split(names), name) > 0) return &value;
  return nullptr;
}

constexpr Names<Type> nrrd_types[] = {
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
constexpr Names<Encoding> nrrd_encodings[] = {
    {"raw", Encoding::raw},
    {"gzip,gz", Encoding::gzip},
    {"text,txt,ascii", Encoding::text},
    {"hex", Encoding::hex},
};

/// Sets type, byte order, encoding, and where the values are.
void set_encoding(const NrrdText& text, Header& header, const FileBlocks& file) {
  const std::string type = lower_case(required(text, "type", file)),
                    encoding = lower_case(required(text, "encoding", file));
  const Type* known_type = meaning_of(nrrd_types, type);
  if (!known_type)
    refuse(file, "has values of type " + in_quotes(type) + ", which psivox does not read");
  const Encoding* known_encoding = meaning_of(nrrd_encodings, encoding);
  if (!known_encoding)
    refuse(file, "has the encoding " + in_quotes(encoding) +
                     "; psivox reads raw, gzip, text and hex; teem's unu save -e gzip converts it");
  header.type = *known_type;
  header.encoding = *known_encoding;
  const std::string endian = lower_case(text.of("endian"));
  header.big_endian = endian == "big";
  if (size_of(header.type) > 1 && header.encoding != Encoding::text && endian != "big" &&
      endian != "little")
    refuse(file, "does not say its byte order: 'endian' is " + in_quotes(endian));
  header.detached = !text.of("datafile").empty();
  header.begin = header.detached ? 0 : text.end;
  const std::string &lines = text.of("lineskip"), &skip = text.of("byteskip");
  if (!lines.empty()) header.lines = number<std::int64_t>(file, lines, "a line skip");
  if (!skip.empty()) header.skip = number<std::int64_t>(file, skip, "a byte skip");
  const bool from_end =
      header.skip == -1 && (header.encoding == Encoding::raw || header.encoding == Encoding::gzip);
  if (header.lines < 0 || (header.skip < 0 && !from_end))
    refuse(file, "its line skip or byte skip is below 0");
  if (from_end) header.lines = 0;
}

/// One axis of the values, the fastest first.
struct Axis {
  std::int64_t size = 1, stride = 1;
  std::string kind;  ///< plain
  std::optional<glm::dvec3> direction;
  bool spatial = true;
};

/// A vector of space. A fourth component, of a space with time, is left out.
glm::dvec3 vector_of(const FileBlocks& file, const std::string& text) {
  glm::dvec3 v(0);
  if (!text.starts_with('(') || !text.ends_with(')'))
    refuse(file, in_quotes(text) + " is no vector");
  const std::vector<std::string> parts = split(text.substr(1, text.size() - 2));
  if (parts.empty() || parts.size() > 4)
    refuse(file, in_quotes(text) + " is no vector of 3 numbers");
  for (std::size_t i = 0; i < std::min<std::size_t>(parts.size(), 3); ++i)
    v[int(i)] = number<double>(file, parts[i], "a component");
  return v;
}

/// Kinds of axes that are places. Others are colours, vectors, times and lists.
bool is_place(const std::string& kind) {
  return kind == "domain" || kind == "space" || kind == "none" || kind == "???" || kind.empty();
}

std::vector<Axis> axes_of(const NrrdText& text, const FileBlocks& file) {
  const std::vector<std::string> sizes = words(required(text, "sizes", file)),
                                 kinds = words(text.of("kinds"));
  std::vector<std::string> directions = words(text.of("spacedirections"));
  const auto count = number<int>(file, required(text, "dimension", file), "a dimension");
  if (count < 1 || count > 16 || sizes.size() != std::size_t(count))
    refuse(file, "has " + std::to_string(sizes.size()) + " sizes for " + std::to_string(count) +
                     " dimensions");
  for (const std::vector<std::string>* list : {&kinds, &std::as_const(directions)})
    if (!list->empty() && list->size() != sizes.size())
      refuse(file, "has another number of kinds or directions than of sizes");
  // some writers give no axis a direction, but all of them kinds and spacings
  const auto is_none = [](const std::string& word) { return lower_case(word) == "none"; };
  if (std::ranges::all_of(directions, is_none)) directions.clear();
  std::vector<Axis> axes(sizes.size());
  std::int64_t stride = 1;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    Axis& axis = axes[i];
    axis.size = number<std::int64_t>(file, sizes[i], "a size");
    constexpr std::int64_t most = std::int64_t{1} << 48;  // so that no product overflows
    if (axis.size < 1 || axis.size > 1 << 24 || stride > most / axis.size)
      refuse(file, "its header claims a size of " + sizes[i]);
    axis.stride = stride;
    stride *= axis.size;
    if (!kinds.empty()) axis.kind = plain(kinds[i]);
    axis.spatial = is_place(axis.kind);
    if (directions.empty()) continue;
    axis.spatial = !is_none(directions[i]) && axis.kind != "time";
    if (axis.spatial) axis.direction = vector_of(file, directions[i]);
    // a direction in time alone, or one that is not known
    if (axis.spatial && !(glm::length(*axis.direction) > 0) && axes.size() > 3) {
      axis.spatial = false;
      axis.direction.reset();
    }
  }
  // Of four axes without kinds and directions, a short first one has components, or else the last
  // one has frames.
  const auto places = std::ranges::count(axes, true, &Axis::spatial);
  if (places == 4 && axes.size() == 4 && directions.empty())
    (axes[0].size <= 4 ? axes[0] : axes[3]).spatial = false;
  return axes;
}

/// Whether an axis has red, green and blue, and alpha if it is 4 long. A first one of bytes without
/// a kind has colours, too.
bool is_colour(const Axis& axis, bool first, Type type) {
  if (first && is_place(axis.kind) && type == Type::uint8 && (axis.size == 3 || axis.size == 4))
    return true;
  constexpr Names<int> colours[] = {{"rgb,rgbcolor,3color", 3}, {"rgba,rgbacolor,4color", 4}};
  const int* channels = meaning_of(colours, axis.kind);
  return channels && *channels == axis.size;
}

/// Whether an axis has the components of a vector.
bool is_vector(const Axis& axis, bool first) {
  const std::string& kind = axis.kind;
  if (axis.size != 3) return false;
  return is_place(kind)
             ? first
             : kind.ends_with("vector") || kind.ends_with("gradient") || kind.ends_with("normal");
}

/// Sets shape, channels and frames. Returns the numbers of the axes of space.
std::vector<std::size_t> set_shape(const std::vector<Axis>& axes, Header& header,
                                   const FileBlocks& file) {
  std::vector<std::size_t> space;
  header.values = 1;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Axis& axis = axes[i];
    header.values *= axis.size;
    if (axis.spatial) {
      space.push_back(i);
    } else if (const bool colour = is_colour(axis, i == 0, header.type);
               header.channels == 1 && (colour || is_vector(axis, i == 0))) {
      header.channels = 3;
      header.channel_stride = axis.stride;
      header.colour = colour;
      if (axis.size == 4) header.notices.push_back("leaves out the alpha of its colours");
    } else if (axis.size > 1) {
      if (header.frames > 1)
        refuse(file, "has more axes than three of space, one of components and one of frames");
      header.frames = axis.size;
      header.frame_stride = axis.stride;
      header.in_time = !axis.kind.ends_with("matrix") && !axis.kind.ends_with("color");
    }
  }
  if (space.size() < 2 || space.size() > 3)
    refuse(file, "has " + std::to_string(space.size()) + " axes of space; psivox reads 2 or 3");
  for (std::size_t i = 0; i < 3; ++i) {
    const bool there = i < space.size();
    header.shape[int(i)] = there ? int(axes[space[i]].size) : 1;
    header.strides[i] = there ? axes[space[i]].stride : header.values;
  }
  return space;
}

/// What a field says of an axis; NaN if it says nothing.
double number_of_axis(const NrrdText& text, const char* field, std::size_t axis,
                      const FileBlocks& file) {
  const std::vector<std::string> all = words(text.of(field));
  return axis < all.size() ? number<double>(file, all[axis], field) : std::nan("");
}

/// The transform without directions: spacings along the axes. `axis mins` and `axis maxs` are ends
/// of cells, or centres of voxels if the axis has the centering `node`. An axis without a centering
/// has cells, as teem and ITK read it.
glm::dmat4 spaced_transform(const NrrdText& text, const std::vector<Axis>& axes,
                            const std::vector<std::size_t>& space, const FileBlocks& file) {
  glm::dmat4 m(1);
  const std::vector<std::string> centers = words(text.of("centers"));
  for (std::size_t i = 0; i < space.size(); ++i) {
    const std::size_t axis = space[i];
    const bool node = axis < centers.size() && lower_case(centers[axis]) == "node";
    const double least = number_of_axis(text, "axismins", axis, file),
                 most = number_of_axis(text, "axismaxs", axis, file);
    double size = number_of_axis(text, "spacings", axis, file);
    if (std::isnan(size) && std::isfinite(most - least))
      size = (most - least) / double(std::max<std::int64_t>(axes[axis].size - (node ? 1 : 0), 1));
    if (std::isnan(size)) size = 1;
    m[int(i)][int(i)] = size;
    if (!std::isnan(least)) m[3][int(i)] = least + (node ? 0 : size / 2);
  }
  return m;
}

/// Spaces whose z is up, and the signs that turn their x to the right and their y to the front.
constexpr Names<std::array<double, 2>> nrrd_spaces[] = {
    {"rightanteriorsuperior,ras,rightanteriorsuperiortime,rast", {1, 1}},
    {"leftanteriorsuperior,las,leftanteriorsuperiortime,last", {-1, 1}},
    {"leftposteriorsuperior,lps,leftposteriorsuperiortime,lpst", {-1, -1}},
    {"scannerxyz,scannerxyztime,scannerxyzt", {1, 1}},
};

/// Sets the transform. If the space is known, +x is to the right, +y to the front and +z up.
void set_transform(const NrrdText& text, const std::vector<Axis>& axes,
                   const std::vector<std::size_t>& space, Header& header, const FileBlocks& file) {
  glm::dmat4& m = header.world_from_index;
  if (!axes[space[0]].direction) {
    m = spaced_transform(text, axes, space, file);
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
    if (one.size() != 1) refuse(file, in_quotes(origin) + " is no vector");
    m[3] = glm::dvec4(vector_of(file, one[0]), 1);
  }
  if (const auto* signs = meaning_of(nrrd_spaces, plain(text.of("space")))) {
    header.z_up = "an NRRD scan of the space " + text.of("space");
    for (int c = 0; c < 4; ++c) m[c] *= glm::dvec4((*signs)[0], (*signs)[1], 1, 1);
  }
}

}  // namespace

bool is_nrrd(std::string_view head) { return head.starts_with("NRRD0"); }

std::string nrrd_data_file(FileBlocks& file) { return read_nrrd_text(file).of("datafile"); }

Header read_nrrd(FileBlocks& file) {
  const NrrdText text = read_nrrd_text(file);
  Header header;
  header.format = "NRRD";
  set_encoding(text, header, file);
  const std::vector<Axis> axes = axes_of(text, file);
  const std::vector<std::size_t> space = set_shape(axes, header, file);
  set_transform(text, axes, space, header, file);
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

}  // namespace psivox::scan
