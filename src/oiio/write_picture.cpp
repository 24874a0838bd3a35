#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "image/srgb_codes.h"
#include "oiio/picture_module.h"

namespace psivox::image_io {
namespace {

void add_metadata(OIIO::ImageSpec& spec, const std::map<std::string, std::string>& metadata) {
  spec.attribute("DateTime", "");  // or OpenImageIO adds the time: equal pictures are equal files
  const auto version = metadata.find("psivox:version");
  if (version == metadata.end()) return;
  spec.attribute("Software", std::string(software) + version->second);
  for (const Tag& tag : tags) {
    const auto found = metadata.find(tag.key);
    if (found != metadata.end() && found->second.size() <= longest_text)
      spec.attribute(tag.name, found->second);
  }
}

/// Red, green and blue as RGBE can hold them: from 0 to largest_rgbe, 0 for NaN.
std::vector<float> rgbe_colours(std::span<const float> rgba) {
  std::vector<float> colours;
  colours.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size(); ++i)
    if (i % 4 != 3) colours.push_back(rgba[i] > 0 ? std::min(rgba[i], largest_rgbe) : 0.0f);
  return colours;
}

/// Encodes in memory, so that each failure to write is OutputFile's to tell: libtiff and libwebp
/// lose some.
void encode(const Image& image, Format format, OIIO::TypeDesc type, int channels,
            const void* values, OutputFile& file) {
  const FormatFacts& facts = facts_of(format);
  OIIO::ImageSpec spec(image.width, image.height, channels, type);
  add_metadata(spec, image.metadata);
  if (channels == 4 && type != OIIO::TypeFloat) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (format == Format::jpeg) {
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");  // thin coloured lines keep their colour
  }
  if (format == Format::webp) spec.attribute("Compression", "webp:100");
  OIIO::Filesystem::IOVecOutput memory;
  OIIO::Filesystem::IOProxy* proxy = &memory;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);

  const auto output = OIIO::ImageOutput::create(facts.openimageio);
  const bool encoded = output && output->open("picture" + std::string(facts.extension), spec) &&
                       output->write_image(type, values) && output->close();
  const std::vector<unsigned char>& bytes = memory.buffer();
  file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  file.commit(encoded, encoded ? "" : output ? output->geterror() : OIIO::geterror());
}

bool writes(Format format) {
  return OIIO::ImageOutput::create(facts_of(format).openimageio) != nullptr;
}

/// The version of the library that runs; the header may be another.
std::string version() {
  const int number = OIIO::openimageio_version();  // major * 10000 + minor * 100 + patch
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
         std::to_string(number % 100);
}

constexpr PictureFiles table = {read_picture,       read_picture_metadata, writes, write_picture,
                                complete_ocio_view, show_by_ocio,          version};

}  // namespace

void write_picture(const Image& image, Format format, const WriteOptions& options,
                   OutputFile& file) {
  const auto rgba = image.rgba();
  if (format == Format::hdr)
    encode(image, format, OIIO::TypeFloat, 3, rgbe_colours(rgba).data(), file);
  else if (format != Format::tiff)
    encode(image, format, OIIO::TypeUInt8, 3,
           srgb_codes<std::uint8_t>(rgba, 3, options.display).data(), file);
  else if (!options.bits)
    encode(image, format, OIIO::TypeFloat, 4, rgba.data(), file);
  else if (*options.bits == 8)
    encode(image, format, OIIO::TypeUInt8, 4,
           srgb_codes<std::uint8_t>(rgba, 4, options.display).data(), file);
  else
    encode(image, format, OIIO::TypeUInt16, 4,
           srgb_codes<std::uint16_t>(rgba, 4, options.display).data(), file);
}

}  // namespace psivox::image_io

extern "C" const psivox::image_io::PictureFiles* psivox_picture_files() {
  return &psivox::image_io::table;
}
