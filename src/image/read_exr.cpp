#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineInputPart.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "image/formats.h"

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

/// Throws Error(input) where a short EXR asks for pixels that would be allocated before OpenEXR
/// finds that the file has none: all of them, and up to 256 lines, or a row of tiles, at a time.
/// Its codecs pack at most 9,200 values of a black picture into a byte (dwab; 340 the next).
void check_packing(const std::filesystem::path& path, const Imf::Header& header,
                   const StoredPixels& stored) {
  constexpr double most_values_a_byte = 0x1p16;
  // a file may have fewer lines than are allocated
  constexpr double most_allocated_a_byte = 0x1p19;
  const double lines = header.hasTileDescription() ? header.tileDescription().ySize : 256.0;
  const auto bytes = double(std::filesystem::file_size(path));
  const double of_line = double(stored.width) * double(stored.channels.size());
  if (of_line * double(stored.height) > most_values_a_byte * bytes ||
      of_line * std::max(lines, 256.0) > most_allocated_a_byte * bytes)
    throw read_error(
        path, "its header is damaged or asks for too much: " + std::to_string(stored.width) + "x" +
                  std::to_string(stored.height) + " pixels stored in so short a file");
}

std::int64_t width_of(const Imath::Box2i& box) { return std::int64_t{box.max.x} - box.min.x + 1; }
std::int64_t height_of(const Imath::Box2i& box) { return std::int64_t{box.max.y} - box.min.y + 1; }

/// The display window, which is the picture, in the coordinates of the data window, whose pixels
/// are stored. A side that does not fit is 0, which check_size refuses.
Window picture_window(const Imf::Header& header) {
  const Imath::Box2i &shown = header.displayWindow(), &data = header.dataWindow();
  const auto side = [](std::int64_t length) { return length == int(length) ? int(length) : 0; };
  return {std::int64_t{shown.min.x} - data.min.x, std::int64_t{shown.min.y} - data.min.y,
          side(width_of(shown)), side(height_of(shown))};
}

/// All texts but those that tell the parts of a file of several apart.
std::map<std::string, std::string> metadata_of(const Imf::Header& header) {
  std::map<std::string, std::string> metadata;
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    const std::string name = attribute.name();
    const auto* const text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
    if (text && name != "type" && name != "name") metadata[name] = text->value();
  }
  return metadata;
}

/// Calls use(file), of which OpenEXR has read the headers. What it throws becomes Error(input).
template <typename Use>
auto with_exr(const std::filesystem::path& path, const Use& use) {
  check_exr_header(path);
  try {
    Imf::MultiPartInputFile file(path.c_str(), int(std::thread::hardware_concurrency()));
    return use(file);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw read_error(path, error.what());
  }
}

/// Where a channel stands among those of its layer: R G B A, then all others.
std::pair<std::string_view, std::size_t> place_in_file(std::string_view name) {
  const std::size_t dot = name.rfind('.'), end = dot == name.npos ? 0 : dot + 1;
  const std::string_view channel = name.substr(end), known = "RGBA";
  return {name.substr(0, end), channel.size() == 1 ? known.find(channel) : known.npos};
}

Image decode(const std::filesystem::path& path, Imf::MultiPartInputFile& file, bool needs_picture) {
  const Imf::Header& header = file.header(0);
  if (Imf::isDeepData(header.type()))
    throw read_error(path, "it is a deep image; oiiotool --flatten makes a flat one");
  const Imath::Box2i& data = header.dataWindow();
  const Window window = picture_window(header);
  StoredPixels stored{width_of(data), height_of(data), {}, {}};
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
      throw read_error(path, "its channel " + std::string(channel.name()) +
                                 " has fewer pixels than the picture, which psivox does not read");
    stored.channels.emplace_back(channel.name());
  }
  std::ranges::stable_sort(stored.channels, {}, place_in_file);
  const std::size_t count = stored.channels.size();
  check_size(path, window.width, window.height, double(stored.width) * double(stored.height),
             int(count));
  check_packing(path, header, stored);
  if (needs_picture && !have_picture(stored.channels)) throw no_picture(path, stored.channels);

  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const std::size_t values = std::size_t(stored.width) * std::size_t(stored.height) * count;
  const auto pixels = std::make_unique_for_overwrite<float[]>(values);
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < count; ++c)
    frame.insert(stored.channels[c],
                 Imf::Slice::Make(Imf::FLOAT, pixels.get() + c, data, count * sizeof(float),
                                  count * sizeof(float) * std::size_t(stored.width)));
  use_exr_threads(stored.width * stored.height);
  Imf::InputPart part(file, 0);  // allocates lines for each thread
  part.setFrameBuffer(frame);
  part.readPixels(data.min.y, data.max.y);
  stored.values = {pixels.get(), values};
  return {window.width, window.height, layers_of_file(stored, window), metadata_of(header)};
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
  // beside X it is a vector's
  const auto grey = index_of(names, "X") ? std::nullopt : index_of(names, "Y");
  const auto alpha = index_of(names, "A");
  const std::vector<std::string> channels = {"R", "G", "B", "A"};
  if (red && green && blue) return LayerSource{"", channels, {red, green, blue, alpha}};
  if (grey) return LayerSource{"", channels, {grey, grey, grey, alpha}};
  return std::nullopt;
}

std::vector<LayerSource> sources_of(const std::vector<std::string>& names) {
  std::vector<LayerSource> layers;
  std::vector<std::optional<std::size_t>> taken;
  if (const auto picture = picture_source(names)) {
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

/// The part of the stored pixels that the window shows; 0 where the window has none.
Layer cut_layer(const LayerSource& source, const StoredPixels& stored, const Window& window) {
  const std::size_t count = source.channels.size();
  Layer layer{source.name, source.channels, {}};
  layer.values.resize(std::size_t(window.width) * std::size_t(window.height) * count);
  float* to = layer.values.data();
  for (std::int64_t y = window.y; y < window.y + window.height; ++y) {
    for (std::int64_t x = window.x; x < window.x + window.width; ++x, to += count) {
      if (x < 0 || x >= stored.width || y < 0 || y >= stored.height) continue;
      const auto from = std::size_t(y * stored.width + x) * stored.channels.size();
      for (std::size_t c = 0; c < count; ++c) {
        to[c] = source.indices[c] ? stored.values[from + *source.indices[c]] : 1.0f;
      }
    }
  }
  return layer;
}

}  // namespace

Image read_exr(const std::filesystem::path& path, bool needs_picture) {
  return with_exr(path, [&](auto& file) { return decode(path, file, needs_picture); });
}

std::map<std::string, std::string> metadata_of_whole_exr(const std::filesystem::path& path) {
  return with_exr(path, [&](auto& file) {
    if (!Imf::isDeepData(file.header(0).type()))
      return decode(path, file, /*needs_picture=*/false).metadata;
    const Imath::Box2i& data = file.header(0).dataWindow();
    const std::int64_t width = width_of(data);
    std::vector<unsigned> counts(std::size_t(width * height_of(data)));
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(Imf::Slice::Make(Imf::UINT, counts.data(), data, sizeof(unsigned),
                                                  sizeof(unsigned) * std::size_t(width)));
    Imf::DeepScanLineInputPart part(file, 0);
    part.setFrameBuffer(frame);
    part.readPixelSampleCounts(data.min.y, data.max.y);
    return metadata_of(file.header(0));
  });
}

std::map<std::string, std::string> read_exr_metadata(const std::filesystem::path& path) {
  return with_exr(path, [](const auto& file) { return metadata_of(file.header(0)); });
}

bool have_picture(const std::vector<std::string>& channels) {
  return picture_source(channels).has_value();
}

std::vector<Layer> layers_of_file(const StoredPixels& stored, const Window& window) {
  std::vector<Layer> layers;
  for (const LayerSource& source : sources_of(stored.channels))
    layers.push_back(cut_layer(source, stored, window));
  return layers;
}

}  // namespace psivox::image_io
