// OpenEXR's file layout: one part, scan lines, zip compression.
// https://openexr.com/en/latest/OpenEXRFileLayout.html

#include <Imath/half.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <vector>

#include "encode.h"
#include "psivox/error.h"

namespace psivox::image_io {
namespace {

constexpr int block_rows = 16;  // of ZIP_COMPRESSION
constexpr int zip_level = 4;    // OpenEXR's own default

/// A plane of the file, and where its values are.
struct Channel {
  std::string name;
  const float* values = nullptr;  ///< of the first pixel
  std::size_t stride = 0;         ///< floats from pixel to pixel
  bool half = false;

  std::size_t bytes() const { return half ? 2 : 4; }
};

/// In the file's order: by name.
std::vector<Channel> sorted_channels(const Image& image, const WriteOptions& options) {
  std::vector<Channel> channels;
  for (const Layer& layer : image.layers) {
    const bool picture = &layer == &image.layers.front();
    // Half's largest number is 65504 and its 11 bits miscount steps above 2048: layers stay float.
    for (std::size_t c = 0; c < layer.channels.size(); ++c)
      channels.push_back({exr_channel_name(layer, c), layer.values.data() + c,
                          layer.channels.size(), picture && options.half});
  }
  std::sort(channels.begin(), channels.end(),
            [](const Channel& a, const Channel& b) { return a.name < b.name; });
  return channels;
}

static_assert(std::endian::native == std::endian::little, "EXR's numbers are copied as they are");

template <class Value>
void put(std::string& to, Value value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put_name(std::string& to, const std::string& name) {
  to.append(name.c_str(), name.size() + 1);
}

void put_attribute(std::string& to, const char* name, const char* type, const std::string& value) {
  put_name(to, name);
  put_name(to, type);
  put(to, static_cast<std::int32_t>(value.size()));
  to += value;
}

template <class... Values>
std::string packed(Values... values) {
  std::string bytes;
  (put(bytes, values), ...);
  return bytes;
}

/// A name ends at its first zero byte and has at most 255; the number of an attribute's bytes is an
/// int.
void check_names(const Image& image, const std::vector<Channel>& channels) {
  const auto check = [](const std::string& what, const std::string& name) {
    if (name.empty() || name.size() > 255 || name.find('\0') != std::string::npos)
      throw Error(ExitCode::failure, "an EXR file cannot hold " + what + " '" + name + "'");
  };
  for (const Channel& channel : channels) check("the channel", channel.name);
  static constexpr const char* own[] = {
      "channels",         "compression",        "dataWindow",        "displayWindow", "lineOrder",
      "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "tiles"};
  for (const auto& [name, value] : image.metadata) {
    check("metadata of the name", name);
    if (std::find(std::begin(own), std::end(own), name) != std::end(own) ||
        value.size() > std::size_t(std::numeric_limits<std::int32_t>::max()))
      throw Error(ExitCode::failure, "an EXR file cannot hold the metadata '" + name + "'");
  }
}

std::string header(const Image& image, const std::vector<Channel>& channels) {
  bool long_names = false;  // of more than 31 bytes
  std::string list;
  for (const Channel& channel : channels) {
    long_names |= channel.name.size() > 31;
    put_name(list, channel.name);
    list += packed(std::int32_t{channel.half ? 1 : 2}, std::int32_t{0}, std::int32_t{1},
                   std::int32_t{1});  // type; not perceptually linear; sampling
  }
  list += '\0';
  for (const auto& [name, value] : image.metadata) long_names |= name.size() > 31;

  std::string text = packed(std::int32_t{20000630}, std::int32_t{long_names ? 2 | 0x400 : 2});
  const std::string window = packed(std::int32_t{0}, std::int32_t{0}, std::int32_t{image.width - 1},
                                    std::int32_t{image.height - 1});
  put_attribute(text, "channels", "chlist", list);
  put_attribute(text, "compression", "compression", "\3");  // ZIP_COMPRESSION
  put_attribute(text, "dataWindow", "box2i", window);
  put_attribute(text, "displayWindow", "box2i", window);
  put_attribute(text, "lineOrder", "lineOrder", std::string(1, '\0'));  // INCREASING_Y
  put_attribute(text, "pixelAspectRatio", "float", packed(1.0f));
  put_attribute(text, "screenWindowCenter", "v2f", packed(0.0f, 0.0f));
  put_attribute(text, "screenWindowWidth", "float", packed(1.0f));
  for (const auto& [name, value] : image.metadata)
    put_attribute(text, name.c_str(), "string", value);
  return text += '\0';
}

/// The pixels of some rows: row by row, in a row channel by channel.
std::string raw_block(const std::vector<Channel>& channels, int width, int first, int rows) {
  std::size_t pixel_bytes = 0;
  for (const Channel& channel : channels) pixel_bytes += channel.bytes();
  std::string raw(pixel_bytes * std::size_t(width) * std::size_t(rows), '\0');
  char* to = raw.data();
  for (int y = first; y < first + rows; ++y)
    for (const Channel& channel : channels) {
      const float* from = channel.values + std::size_t(y) * std::size_t(width) * channel.stride;
      for (int x = 0; x < width; ++x, from += channel.stride, to += channel.bytes()) {
        if (channel.half) {
          const std::uint16_t half = imath_float_to_half(*from);
          std::memcpy(to, &half, sizeof half);
        } else {
          std::memcpy(to, from, sizeof *from);
        }
      }
    }
  return raw;
}

/// As OpenEXR zips: even bytes before odd ones, each as its difference from the one before; stored
/// as they were if that is not shorter.
std::string zipped(std::string raw) {
  std::string parted(raw.size(), '\0'), changes(raw.size(), '\0');
  const std::size_t half = raw.size() / 2;  // values have 2 or 4 bytes
  for (std::size_t i = 0; i < half; ++i) {
    parted[i] = raw[2 * i];
    parted[half + i] = raw[2 * i + 1];
  }
  changes[0] = parted[0];
  for (std::size_t i = 1; i < raw.size(); ++i)
    changes[i] = static_cast<char>(parted[i] - parted[i - 1] + 128);
  std::string zip(compressBound(changes.size()), '\0');
  uLongf size = zip.size();
  const int status =
      compress2(reinterpret_cast<Bytef*>(zip.data()), &size,
                reinterpret_cast<const Bytef*>(changes.data()), changes.size(), zip_level);
  if (status == Z_MEM_ERROR) throw std::bad_alloc();
  if (status != Z_OK || size >= raw.size()) return raw;
  zip.resize(size);
  return zip;
}

}  // namespace

std::string exr_channel_name(const Layer& layer, std::size_t channel) {
  if (layer.name.empty()) return layer.channels[channel];
  if (layer.channels.size() == 1) return layer.name;
  return layer.name + "." + layer.channels[channel];
}

void write_exr(const Image& image, const WriteOptions& options, OutputFile& file) {
  const std::vector<Channel> channels = sorted_channels(image, options);
  check_names(image, channels);
  if (double(image.width) * block_rows * 4 * double(channels.size()) > 0x1p31)
    throw Error(ExitCode::failure, "the picture is too wide for an EXR file");
  file.write(header(image, channels));

  // The table of the blocks' places comes first, and is known last.
  const auto blocks = static_cast<std::size_t>((image.height - 1) / block_rows + 1);
  const std::int64_t table_at = file.tell();
  std::vector<std::uint64_t> table(blocks);
  const std::string_view table_bytes(reinterpret_cast<const char*>(table.data()), blocks * 8);
  file.write(table_bytes);
  constexpr std::size_t band = 16;  // blocks at a time, which bounds the copy
  for (std::size_t first = 0; first < blocks; first += band) {
    std::vector<std::string> zips(std::min(band, blocks - first));
    tbb::parallel_for(std::size_t{0}, zips.size(), [&](std::size_t i) {
      const int y = int(first + i) * block_rows;
      zips[i] = zipped(raw_block(channels, image.width, y, std::min(block_rows, image.height - y)));
    });
    for (std::size_t i = 0; i < zips.size(); ++i) {
      table[first + i] = static_cast<std::uint64_t>(file.tell());
      file.write(packed(static_cast<std::int32_t>((first + i) * block_rows),
                        static_cast<std::int32_t>(zips[i].size())));
      file.write(zips[i]);
    }
  }
  file.seek(table_at);
  file.write(table_bytes);
  file.commit();
}

}  // namespace psivox::image_io
