#include <OpenImageIO/imageio.h>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "colour/colour.h"
#include "image/formats.h"
#include "oiio/picture_module.h"

namespace psivox::image_io {
namespace {

using Input = OIIO::ImageInput::unique_ptr;

Input open_picture(const std::filesystem::path& path, Format format) {
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
  return name == "compression" || name.starts_with("oiio:");
}

std::map<std::string, std::string> metadata_of(const OIIO::ImageSpec& spec) {
  std::map<std::string, std::string> metadata;
  const std::string writer = spec.get_string_attribute("Software");
  if (writer.starts_with(software)) {
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

}  // namespace

Image read_picture(const std::filesystem::path& path, Format format) {
  const Input input = open_picture(path, format);
  const OIIO::ImageSpec& spec = input->spec();
  check_size(path, spec.width, spec.height, double(spec.width) * spec.height, spec.nchannels);
  // Left uninitialised, so that a lying header costs no memory: the pages come as pixels do.
  const std::size_t count =
      std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(spec.nchannels);
  const auto stored = std::make_unique_for_overwrite<float[]>(count);
  const bool read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, stored.get());
  // read_image returns true for a TIFF or JPEG that is cut short.
  const std::string failure = input->geterror();
  if (!read || !failure.empty()) throw read_error(path, failure);

  const StoredPixels pixels{spec.width, spec.height, spec.channelnames, {stored.get(), count}};
  if (!have_picture(pixels.channels)) throw no_picture(path, pixels.channels);
  Image image{spec.width, spec.height, layers_of_file(pixels, {0, 0, spec.width, spec.height}),
              metadata_of(spec)};
  linearise_and_premultiply(image.rgba(), spec);
  return image;
}

std::map<std::string, std::string> read_picture_metadata(const std::filesystem::path& path,
                                                         Format format) {
  return metadata_of(open_picture(path, format)->spec());
}

}  // namespace psivox::image_io
