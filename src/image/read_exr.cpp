#include <OpenEXR/ImfChannelList.h>
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

}  // namespace

Image read_exr(const std::filesystem::path& path, bool needs_picture) {
  return with_exr(path, [&](auto& file) { return decode(path, file, needs_picture); });
}

std::map<std::string, std::string> read_exr_metadata(const std::filesystem::path& path) {
  return with_exr(path, [](const auto& file) { return metadata_of(file.header(0)); });
}

}  // namespace psivox::image_io
