#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "colour/colour.h"
#include "image/formats.h"
#include "oiio/picture_module.h"

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

/// Throws Error(input) if an attribute of an EXR's header is longer than the file or has another
/// length than a value of its type. OpenEXR would allocate the first, and reads values by their
/// types, so that it would take the rest of the second for attributes.
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

/// A layer to read, and the places of its channels in the file.
struct LayerSource {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::optional<std::size_t>> indices;  ///< none: the channel is 1 everywhere
};

std::optional<std::size_t> index_of(const std::vector<std::string>& names,
                                    const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return std::size_t(found - names.begin());
}

std::optional<LayerSource> picture_source(const std::vector<std::string>& names) {
  const auto red = index_of(names, "R");
  const auto green = index_of(names, "G");
  const auto blue = index_of(names, "B");
  const auto grey = index_of(names, "Y");
  const auto alpha = index_of(names, "A");
  const std::vector<std::string> channels = {"R", "G", "B", "A"};
  if (red && green && blue) return LayerSource{"", channels, {red, green, blue, alpha}};
  if (grey) return LayerSource{"", channels, {grey, grey, grey, alpha}};
  return std::nullopt;
}

/// Sorts a file's channels into layers, the inverse of exr_channel_name. The picture comes first,
/// from R G B or from the grey Y, with alpha 1 if there is no A. Channels with one prefix
/// (`normal.X`, `normal.Y`) are one layer. `has_picture` tells whether the file has one.
std::vector<LayerSource> layers_from_channels(const std::vector<std::string>& names,
                                              bool& has_picture) {
  std::vector<LayerSource> layers;
  std::vector<std::optional<std::size_t>> taken;
  const auto picture = picture_source(names);
  has_picture = picture.has_value();
  if (picture) {
    layers.push_back(*picture);
    taken = picture->indices;
  }
  std::map<std::string, std::size_t> layer_of_prefix;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(taken.begin(), taken.end(), i) != taken.end()) continue;
    const std::size_t dot = names[i].rfind('.');
    if (dot == std::string::npos) {
      layers.push_back({names[i], {names[i]}, {i}});
      continue;
    }
    const std::string prefix = names[i].substr(0, dot);
    const auto [entry, is_new] = layer_of_prefix.try_emplace(prefix, layers.size());
    if (is_new) layers.push_back({prefix, {}, {}});
    layers[entry->second].channels.push_back(names[i].substr(dot + 1));
    layers[entry->second].indices.push_back(i);
  }
  // A channel alone under its prefix keeps its whole name, so that it is written under it again.
  for (const auto& [prefix, index] : layer_of_prefix) {
    LayerSource& layer = layers[index];
    if (layer.channels.size() != 1) continue;
    layer.name += "." + layer.channels.front();
    layer.channels.front() = layer.name;
  }
  return layers;
}

using Input = OIIO::ImageInput::unique_ptr;

Input open_picture(const std::filesystem::path& path, Format format) {
  if (format == Format::exr) check_exr_header(path);
  Input input = OIIO::ImageInput::create(facts_of(format).openimageio);
  if (!input) throw read_error(path, OIIO::geterror());
  // sRGB codes come as they are stored; they are decoded before they are multiplied by alpha.
  OIIO::ImageSpec wish;
  wish.attribute("oiio:UnassociatedAlpha", 1);
  OIIO::ImageSpec spec;
  if (!input->open(path.string(), spec, wish)) throw read_error(path, input->geterror());
  return input;
}

/// What OpenImageIO tells about the file's format, which a copy of the picture should not inherit.
bool is_format_attribute(std::string_view name) {
  return name == "compression" || name.starts_with("oiio:") || name.starts_with("openexr:");
}

std::map<std::string, std::string> metadata_of(const OIIO::ImageSpec& spec, Format format) {
  std::map<std::string, std::string> metadata;
  const std::string writer = spec.get_string_attribute("Software");
  if (format != Format::exr && writer.starts_with(software)) {
    metadata["psivox:version"] = writer.substr(software.size());
    for (const Tag& tag : tags)
      if (spec.find_attribute(tag.name)) metadata[tag.key] = spec.get_string_attribute(tag.name);
    return metadata;
  }
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeString && !is_format_attribute(attribute.name().string()))
      metadata[attribute.name().string()] = attribute.get_ustring().string();
  return metadata;
}

/// The picture's rectangle, in the coordinates of the stored pixels. 64 bits: an EXR's windows may
/// lie 2^31 apart.
struct Window {
  std::int64_t x = 0;
  std::int64_t y = 0;
  int width = 0;
  int height = 0;
};

/// An EXR's picture is its display window; pixels are stored for its data window. A TIFF's offset
/// is a position on paper and moves nothing.
Window picture_window(const OIIO::ImageSpec& spec, Format format) {
  if (format != Format::exr) return {0, 0, spec.width, spec.height};
  return {std::int64_t{spec.full_x} - spec.x, std::int64_t{spec.full_y} - spec.y, spec.full_width,
          spec.full_height};
}

/// Throws Error(input) where a short EXR asks for pixels that OpenEXR and OpenImageIO would
/// allocate before they find that the file has none: all of them, and up to 256 lines at a time.
/// OpenEXR's codecs pack at most 9,200 values of a black picture into a byte (dwab; 340 the next).
void check_packing(const std::filesystem::path& path, const OIIO::ImageSpec& spec) {
  constexpr double most_values_a_byte = 0x1p16;
  // a file may have fewer lines than are allocated
  constexpr double most_allocated_a_byte = 0x1p19, lines = 256;
  const auto bytes = double(std::filesystem::file_size(path));
  const double of_line = double(spec.width) * spec.nchannels;
  if (of_line * spec.height > most_values_a_byte * bytes ||
      of_line * lines > most_allocated_a_byte * bytes)
    throw read_error(
        path, "its header is damaged or asks for too much: " + std::to_string(spec.width) + "x" +
                  std::to_string(spec.height) + " pixels stored in so short a file");
}

/// Makes what a file holds linear and premultiplied. Integers are sRGB codes. Codes that
/// OpenImageIO multiplies by alpha, whatever is asked of it (WebP), are divided by it first.
void linearise_and_premultiply(std::span<float> rgba, const OIIO::ImageSpec& spec) {
  const bool codes = !spec.format.is_floating_point();
  const bool multiplied = spec.get_int_attribute("oiio:UnassociatedAlpha") == 0;
  if (!codes && multiplied) return;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    for (std::size_t c = i; c < i + 3; ++c) {
      const float value = multiplied && alpha > 0 ? rgba[c] / alpha : rgba[c];
      rgba[c] = alpha * (codes ? linear_from_srgb(value) : value);
    }
  }
}

/// The part of the stored pixels that the window shows; 0 where the window has none.
Layer cut_layer(const LayerSource& source, std::span<const float> stored,
                const OIIO::ImageSpec& spec, const Window& window) {
  const std::size_t count = source.channels.size();
  Layer layer{source.name, source.channels, {}};
  layer.values.resize(std::size_t(window.width) * std::size_t(window.height) * count);
  float* to = layer.values.data();
  for (std::int64_t y = window.y; y < window.y + window.height; ++y) {
    for (std::int64_t x = window.x; x < window.x + window.width; ++x, to += count) {
      if (x < 0 || x >= spec.width || y < 0 || y >= spec.height) continue;
      const auto from = std::size_t((y * spec.width + x) * spec.nchannels);
      for (std::size_t c = 0; c < count; ++c) {
        to[c] = source.indices[c] ? stored[from + *source.indices[c]] : 1.0f;
      }
    }
  }
  return layer;
}

}  // namespace

Image read_picture(const std::filesystem::path& path, Format format, bool needs_picture) {
  const Input input = open_picture(path, format);
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.deep) throw read_error(path, "it is a deep image; oiiotool --flatten makes a flat one");
  const Window window = picture_window(spec, format);
  check_size(path, window.width, window.height, double(spec.width) * spec.height, spec.nchannels);
  if (format == Format::exr) check_packing(path, spec);

  bool has_picture = false;
  const auto sources = layers_from_channels(spec.channelnames, has_picture);
  if (!has_picture && needs_picture) {
    std::string names;
    for (const std::string& name : spec.channelnames) names += " " + name;
    throw read_error(path, "it has neither the channels R G B nor Y, but" + names);
  }

  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const std::size_t count =
      std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(spec.nchannels);
  const auto stored = std::make_unique_for_overwrite<float[]>(count);
  const bool read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, stored.get());
  // read_image returns true for a TIFF or JPEG that is cut short.
  const std::string failure = input->geterror();
  if (!read || !failure.empty()) throw read_error(path, failure);

  Image image{window.width, window.height, {}, metadata_of(spec, format)};
  for (const LayerSource& source : sources)
    image.layers.push_back(cut_layer(source, {stored.get(), count}, spec, window));
  if (format != Format::exr) linearise_and_premultiply(image.rgba(), spec);
  return image;
}

std::map<std::string, std::string> read_picture_metadata(const std::filesystem::path& path,
                                                         Format format) {
  return metadata_of(open_picture(path, format)->spec(), format);
}

}  // namespace psivox::image_io
