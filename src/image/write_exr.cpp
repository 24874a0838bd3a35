#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "base/text_file.h"
#include "formats.h"

namespace psivox::image_io {
namespace {

/// Pixels that one thread encodes or decodes before others have begun.
constexpr std::int64_t few_pixels = 1 << 14;

Imf::Header header_of(const Image& image) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.zipCompressionLevel() = 2;  // a quarter less time than its 4, 1.3 % more bytes
  for (const auto& [name, value] : image.metadata)
    if (header.find(name) == header.end())  // what the format itself needs has its own type
      header.insert(name, Imf::StringAttribute(value));
  for (const auto& [name, m] : image.matrices) {
    Imath::M44f rows;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) rows[i][j] = m[i][j];
    header.insert(name, Imf::M44fAttribute(rows));
  }
  return header;
}

/// Numbers that half cannot hold become its largest: infinity would spread wherever the picture is
/// composited. Infinity stays infinity.
std::vector<half> as_halves(const std::vector<float>& values) {
  std::vector<half> halves;
  halves.reserve(values.size());
  for (const float value : values)
    halves.emplace_back(std::isinf(value) ? value : std::clamp(value, -largest_half, largest_half));
  return halves;
}

/// One channel of a layer's interleaved values.
template <typename Value>
Imf::Slice slice(Imf::PixelType type, const std::vector<Value>& values, int width,
                 std::size_t channels, std::size_t channel) {
  const std::size_t stride = channels * sizeof(Value);
  // read only, whatever its type says
  auto* first = const_cast<char*>(reinterpret_cast<const char*>(values.data() + channel));
  return {type, first, stride, stride * std::size_t(width)};
}

/// Deep samples as one part of scan lines: volume samples, from Z to ZBack, tidy.
void encode_deep(const Image& image, Imf::OStream& stream) {
  const std::pair<const char*, float DeepSample::*> members[] = {
      {"Z", &DeepSample::z}, {"ZBack", &DeepSample::z_back}, {"R", &DeepSample::r},
      {"G", &DeepSample::g}, {"B", &DeepSample::b},          {"A", &DeepSample::a}};
  const auto width = std::size_t(image.width);
  const DeepPixels& deep = image.deep;
  Imf::Header header = header_of(image);
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION;
  Imf::DeepFrameBuffer pixels;
  // read only, whatever its type says
  auto* counts = const_cast<char*>(reinterpret_cast<const char*>(deep.counts.data()));
  pixels.insertSampleCountSlice(
      {Imf::UINT, counts, sizeof(deep.counts[0]), sizeof(deep.counts[0]) * width});
  std::vector<char*> places[std::size(members)];  // of the first sample of each pixel
  for (std::size_t m = 0; m < std::size(members); ++m) {
    const auto& [name, member] = members[m];
    auto* sample = const_cast<DeepSample*>(deep.samples.data());
    for (const std::uint32_t count : deep.counts) {
      places[m].push_back(count ? reinterpret_cast<char*>(&(sample->*member)) : nullptr);
      sample += count;
    }
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    pixels.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(places[m].data()),
                                       sizeof(char*), sizeof(char*) * width, sizeof(DeepSample)));
  }
  Imf::DeepScanLineOutputFile output(stream, header);
  output.setFrameBuffer(pixels);
  output.writePixels(image.height);
}

void encode(const Image& image, const WriteOptions& options, Imf::OStream& stream) {
  if (!image.deep.counts.empty()) return encode_deep(image, stream);
  Imf::Header header = header_of(image);
  Imf::FrameBuffer pixels;
  std::vector<half> halves;
  for (const Layer& layer : image.layers) {
    // Half's largest number is 65504 and its 11 bits miscount steps above 2048: layers stay float.
    const bool is_half = options.half && &layer == &image.layers.front();
    if (is_half) halves = as_halves(layer.values);
    const Imf::PixelType type = is_half ? Imf::HALF : Imf::FLOAT;
    const std::size_t count = layer.channels.size();
    for (std::size_t c = 0; c < count; ++c) {
      const std::string name = exr_channel_name(layer, c);
      header.channels().insert(name, Imf::Channel(type));
      pixels.insert(name, is_half ? slice(type, halves, image.width, count, c)
                                  : slice(type, layer.values, image.width, count, c));
    }
  }
  Imf::OutputFile output(stream, header);
  output.setFrameBuffer(pixels);
  output.writePixels(image.height);
}

}  // namespace

void use_exr_threads(std::int64_t pixels) {
  static std::once_flag threads;  // which may all write and read pictures
  if (pixels > few_pixels)
    std::call_once(threads,
                   [] { Imf::setGlobalThreadCount(int(std::thread::hardware_concurrency())); });
}

void write_exr(const Image& image, const WriteOptions& options,
               const std::filesystem::path& target) {
  use_exr_threads(image.width * std::int64_t(image.height));
  try {
    if (is_standard_output(target)) {  // which cannot seek
      Imf::StdOSStream bytes;
      encode(image, options, bytes);
      return write_bytes(target, bytes.str());
    }
    HiddenFile file(target);
    std::ofstream out(file.path(), std::ios::binary);
    Imf::StdOFStream stream(out, "picture.exr");
    encode(image, options, stream);
    out.close();
    // OpenEXR's destructors swallow errors of the last bytes
    if (!out) throw write_error(target, std::strerror(errno));
    file.show();
  } catch (const Iex::BaseExc& error) {
    throw write_error(target, error.what());
  } catch (const std::system_error& failure) {
    throw write_error(target, failure.code().message());
  }
}

}  // namespace psivox::image_io
